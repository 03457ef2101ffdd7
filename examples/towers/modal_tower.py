"""A tower as an FMU: motion of its attachment under the cable's force, from a few modes.

Built with pythonfmu's FmuBuilder, see `coupling.build_tower`. As in the cable's FMU, an input is
the value reached at the end of a communication step, linearly from that of the last one; so both
sides treat a step alike, and a master that iterates a step to convergence gets a result of second
order. Under a force that is linear in time each mode has an exact solution, so the tower adds no
error of its own.
"""

import atexit
import ctypes
import math
from pathlib import Path
from xml.etree.ElementTree import Element, SubElement

from pythonfmu import (
    DefaultExperiment,
    Fmi2Causality,
    Fmi2Initial,
    Fmi2Slave,
    Fmi2Variability,
    Real,
)

# For every instance, pythonfmu 0.7.0 runs this text in the module's namespace, and then gives up a
# reference to the namespace that it never owned. Without one to give up, the namespace is freed and
# the host crashes a little later.
ctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))

MODES = {
    # axis: (modal mass [kg], frequency [Hz], damping ratio, value of the mode at the cable)
    "x1": [(5000.0, 2.5, 0.02, 1.0), (3000.0, 8.0, 0.02, 0.5)],
    "x3": [(6000.0, 2.2, 0.02, 1.0), (3500.0, 7.0, 0.02, 0.5)],
}
"""A fictitious lattice tower of about 20 m: first bending below 3 Hz, second three times higher."""

UNITS = {
    "m": {"m": "1"},
    "m/s": {"m": "1", "s": "-1"},
    "N": {"kg": "1", "m": "1", "s": "-2"},
    "kg": {"kg": "1"},
    "Hz": {"s": "-1"},
    "1": {},
}


class Mode:
    """One damped oscillator, at rest as long as the force on the tower is its preload."""

    def __init__(self, mass: float, frequency: float, damping_ratio: float, shape: float) -> None:
        self.mass, self.frequency, self.damping_ratio, self.shape = (
            mass,
            frequency,
            damping_ratio,
            shape,
        )
        self.q = self.rate = 0.0

    def advance(self, begin: float, end: float, h: float) -> None:
        """Solve exactly over `h` [s] while the force changes linearly from `begin` to `end` [N]."""
        omega = 2.0 * math.pi * self.frequency
        decay = self.damping_ratio * omega
        turning = math.sqrt(omega**2 - decay**2)
        slope = self.shape * (end - begin) / (h * self.mass * omega**2)
        level = self.shape * begin / (self.mass * omega**2) - 2.0 * decay * slope / omega**2
        q, rate = (
            self.q - level,
            self.rate - slope,
        )  # apart from the particular solution level + slope t
        shrink, cosine, sine = (
            math.exp(-decay * h),
            math.cos(turning * h),
            math.sin(turning * h) / turning,
        )
        self.q = level + slope * h + shrink * (q * cosine + (rate + decay * q) * sine)
        self.rate = slope + shrink * (rate * cosine - (omega**2 * q + decay * rate) * sine)


class ModalTower(Fmi2Slave):
    """Two modes along the span and two across it; the tower point does not move vertically."""

    description = (
        "A tower of a few modes. The forces reach their values linearly at the end of a"
        " communication step. The tower is at rest under preload.f1 and preload.f3: give it the"
        " static forces of the cable."
    )

    def __init__(self, **settings):
        super().__init__(**settings)
        # pythonfmu's library for Linux uses freed memory at exit, unless its Python state is
        # released before.
        for library in Path(self.resources).parent.glob("binaries/linux64/*.so"):
            atexit.register(ctypes.CDLL(str(library)).finalizePythonInterpreter)
        self.modes = {axis: [Mode(*numbers) for numbers in MODES[axis]] for axis in MODES}
        self.force, self.reached, self.preload = ({"f1": 0.0, "f3": 0.0} for _ in range(3))
        self.default_experiment = DefaultExperiment(start_time=0.0, stop_time=20.0, step_size=0.005)
        self.units: dict[str, str] = {}
        for n, direction in (("1", "along the span"), ("3", "across the span, downwind")):
            force, axis = f"f{n}", f"x{n}"
            self._entry(
                self.force,
                force,
                force,
                "N",
                "input",
                f"force of the cable on the tower {direction}",
            )
            self._entry(
                self.preload,
                force,
                f"preload.{force}",
                "N",
                "parameter",
                f"force at rest {direction}",
            )
            self._output(
                axis, "m", f"displacement of the tower point {direction}", lambda m: m.shape * m.q
            )
            self._output(
                f"v{n}",
                "m/s",
                f"velocity of the tower point {direction}",
                lambda m: m.shape * m.rate,
            )
            for k, mode in enumerate(self.modes[axis], start=1):
                for field, unit in (
                    ("mass", "kg"),
                    ("frequency", "Hz"),
                    ("damping_ratio", "1"),
                    ("shape", "1"),
                ):
                    name, what = (
                        f"{axis}_mode[{k}].{field}",
                        f"{field.replace('_', ' ')} of mode {k} {direction}",
                    )
                    self._entry(vars(mode), field, name, unit, "parameter", what)

    def _entry(self, owner, key, name, unit, causality, description):
        """Register an input or a parameter that lives in a dictionary."""
        parameter = causality == "parameter"
        variable = Real(
            name,
            causality=Fmi2Causality[causality],
            variability=Fmi2Variability.fixed if parameter else Fmi2Variability.continuous,
            initial=Fmi2Initial.exact if parameter else None,
            description=description,
            getter=lambda: owner[key],
            setter=lambda value: owner.__setitem__(key, value),
        )
        self.units[name] = unit
        self.register_variable(variable, nested=False)

    def _output(self, name, unit, description, part):
        modes = self.modes[f"x{name[-1]}"]
        variable = Real(
            name,
            causality=Fmi2Causality.output,
            variability=Fmi2Variability.continuous,
            initial=Fmi2Initial.calculated,
            description=description,
            getter=lambda: sum(part(mode) for mode in modes),
        )
        self.units[name] = unit
        self.register_variable(variable, nested=False)

    def exit_initialization_mode(self):
        self.reached = dict(self.force)

    def do_step(self, current_time, step_size):
        for axis, modes in self.modes.items():
            name = f"f{axis[-1]}"
            begin, end = (
                self.reached[name] - self.preload[name],
                self.force[name] - self.preload[name],
            )
            for mode in modes:
                mode.advance(begin, end, step_size)
        self.reached = dict(self.force)
        return True

    def _all_modes(self):
        return [mode for modes in self.modes.values() for mode in modes]

    def _get_fmu_state(self):
        motion = [(mode.q, mode.rate) for mode in self._all_modes()]
        return super()._get_fmu_state() | {"motion": motion, "reached": self.reached}

    def _set_fmu_state(self, state):
        state = dict(state)
        for mode, motion in zip(self._all_modes(), state.pop("motion"), strict=True):
            mode.q, mode.rate = motion
        super()._set_fmu_state(state)

    def to_xml(self, model_options=None) -> Element:
        """Model description of pythonfmu, with units and the dependencies of the outputs."""
        root = super().to_xml(model_options or {})
        root.set(
            "generationDateAndTime", root.get("generationDateAndTime", "").replace("+00:00", "Z")
        )
        definitions = Element("UnitDefinitions")
        for name, base in UNITS.items():
            SubElement(SubElement(definitions, "Unit", name=name), "BaseUnit", base)
        root.insert(1, definitions)
        unknowns = SubElement(root.find("ModelStructure"), "InitialUnknowns")
        for index, variable in enumerate(root.find("ModelVariables"), start=1):
            variable.find("Real").set("unit", self.units[variable.get("name")])
            if variable.get("causality") == "output":
                SubElement(unknowns, "Unknown", index=str(index))
        for output in root.find("ModelStructure/Outputs"):
            output.set("dependencies", "")
        return root
