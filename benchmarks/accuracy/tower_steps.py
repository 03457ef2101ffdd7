"""A span between two towers with communication steps of any size: error of the force on a tower.

    python benchmarks/accuracy/tower_steps.py

The steps are drawn at random from 1 us to 50 ms; after three of ten the master returns to the saved
state and draws another one. The reference is the monolithic solution with steps of 1.25 ms. The
second table has the force after 20 steps of 5 ms and one shorter one of a Jacobi master.
"""

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.fmu.cosim import Cosim
from gallop_fmu.fmu.model_bin import model_bin
from gallop_fmu.fmu.variables import fmu_variables

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "examples" / "towers"))
from coupling import galloping_span
from modal_tower import MODES, Mode
from monolithic import Monolith

Array = NDArray[np.float64]

ELEMENTS = 8
STOP = 2.0
SHORTEST, LONGEST = 1e-6, 0.05
REJECTED = 0.3
"""Share of the steps that the master takes back."""
AFTER_START = 0.3
"""Time [s] from which errors count: before, the start of the motion excites axial waves that the
monolithic solution does not resolve, either (77 N between steps of 1.25 and 0.625 ms)."""
TOLERANCE, MOST_ITERATIONS = 1e-9, 60


class Tower:
    """The tower of the examples, without an FMU."""

    def __init__(self, preload: list[float]) -> None:
        self.modes = [[Mode(*numbers) for numbers in MODES[axis]] for axis in ("x1", "x3")]
        self.preload, self.force = preload, preload

    def advance(self, force: list[float], h: float) -> None:
        for modes, begin, end, rest in zip(
            self.modes, self.force, force, self.preload, strict=True
        ):
            for mode in modes:
                mode.advance(begin - rest, end - rest, h)
        self.force = force

    def displacement(self) -> list[float]:
        return [sum(mode.shape * mode.q for mode in modes) for modes in self.modes]

    def velocity(self) -> list[float]:
        return [sum(mode.shape * mode.rate for mode in modes) for modes in self.modes]

    def save(self) -> tuple[list[tuple[float, float]], list[float]]:
        return [(mode.q, mode.rate) for modes in self.modes for mode in modes], self.force

    def restore(self, saved: tuple[list[tuple[float, float]], list[float]]) -> None:
        for mode, motion in zip(
            (mode for modes in self.modes for mode in modes), saved[0], strict=True
        ):
            mode.q, mode.rate = motion
        self.force = saved[1]


class Coupled:
    """The cable in co-simulation with its towers; `gives_velocity`: their velocities, too."""

    def __init__(self, gives_velocity: bool, time_step: float = 0.00125) -> None:
        self.scene = galloping_span(time_step).with_values({"numerics.elements": ELEMENTS})
        reference = {v.name: v.reference for v in fmu_variables(self.scene)}
        self.cosim = Cosim(model_bin(self.scene, "towers", "1"), "towers")
        self.cosim.set_up(0.0, None)
        self.cosim.enter_initialization()
        self.cosim.exit_initialization()
        ends = ("support.left", "support.right")
        self.forces, preloads, self.places, self.velocities = (
            [reference[f"{end}.{name}{k}"] for end in ends for k in (1, 3)]
            for name in ("f", "preload.f", "x", "v")
        )
        static = self.cosim.get("real", preloads)
        self.towers = [Tower(static[:2]), Tower(static[2:])]
        self.time, self.gives_velocity = 0.0, gives_velocity

    def force(self) -> list[float]:
        return self.cosim.get("real", self.forces)

    def displacement(self) -> list[float]:
        return self.towers[0].displacement() + self.towers[1].displacement()

    def velocity(self) -> list[float]:
        return self.towers[0].velocity() + self.towers[1].velocity()

    def move_towers(self, force: list[float], h: float) -> None:
        self.towers[0].advance(force[:2], h)
        self.towers[1].advance(force[2:], h)

    def move_cable(self, begin: list[float], end: list[float], h: float) -> None:
        """Make a step in which the ends move from `begin` to `end`."""
        if self.gives_velocity:
            self.cosim.set("real", self.places, begin)
            rates = [(b - a) / h for a, b in zip(begin, end, strict=True)]
            self.cosim.set("real", self.velocities, rates)
        else:
            self.cosim.set("real", self.places, end)
        self.cosim.step(self.time, h)

    def save(self) -> tuple[object, ...]:
        return self.cosim.save(), [tower.save() for tower in self.towers], self.time

    def restore(self, saved: tuple[object, ...]) -> None:
        state, towers, self.time = saved  # type: ignore[assignment]
        self.cosim.restore(state)  # type: ignore[arg-type]
        for tower, one in zip(self.towers, towers, strict=True):  # type: ignore[call-overload]
            tower.restore(one)

    def jacobi(self, h: float) -> None:
        force, place = self.force(), self.displacement()
        ahead = [x + v * h for x, v in zip(place, self.velocity(), strict=True)]
        self.move_towers(force, h)
        self.move_cable(place, ahead if self.gives_velocity else place, h)
        self.time += h

    def gauss_seidel(self, h: float) -> None:
        begin = self.displacement()
        self.move_towers(self.force(), h)
        self.move_cable(begin, self.displacement(), h)
        self.time += h

    def iterated(self, h: float) -> None:
        saved, begin = self.save(), self.displacement()
        guess = [x + v * h for x, v in zip(begin, self.velocity(), strict=True)]
        for _ in range(MOST_ITERATIONS):
            self.move_cable(begin, guess, h)
            self.move_towers(self.force(), h)
            self.time += h
            found = self.displacement()
            if max(abs(a - b) for a, b in zip(found, guess, strict=True)) < TOLERANCE:
                return
            guess = found
            self.restore(saved)
        raise RuntimeError(f"the iteration did not converge at {self.time:.4f} s, step {h:.3g} s")


class Recorded(Monolith):
    """Records the force on the left tower along the span [N]."""

    def __init__(self, step: float) -> None:
        coupled = Coupled(False)
        self.static, self.force = coupled.towers[0].preload[0], dict[float, float]()
        super().__init__(coupled.scene, MODES, step)

    def _residual(self, y: Array, v: Array, a: Array, time: float) -> Array:
        own = self._forces(y, v, a, time=time)[self.inner]
        self.force[time] = self.static - float(own)  # the last iteration remains
        return super()._residual(y, v, a, time)


def monolithic(step: float) -> tuple[Array, Array]:
    """Times [s] and force on the left tower [N]."""
    whole = Recorded(step)
    whole.run(STOP, 1000)
    times = sorted(whole.force)
    return np.array(times), np.array([whole.force[time] for time in times])


def random_steps(
    scheme: str, gives_velocity: bool, seed: int, reference: tuple[Array, Array]
) -> tuple[float, float]:
    """Largest and RMS error of the force, as fractions of the largest force."""
    rng = np.random.default_rng(seed)
    coupled = Coupled(gives_velocity)
    times, forces = [], []
    while coupled.time < STOP - LONGEST:
        h = float(np.exp(rng.uniform(np.log(SHORTEST), np.log(LONGEST))))
        saved = coupled.save() if rng.random() < REJECTED else None
        getattr(coupled, scheme)(h)
        if saved is not None:
            coupled.restore(saved)
            continue
        times.append(coupled.time)
        forces.append(coupled.force()[0])
    error = np.array(forces) - np.interp(times, *reference)
    error = error[np.array(times) > AFTER_START] / np.max(np.abs(reference[1]))
    return float(np.max(np.abs(error))), float(np.sqrt(np.mean(error**2)))


def after_a_shorter_step(gives_velocity: bool, h: float, time_step: float = 0.01) -> float:
    """Force on the left tower [N] after 20 Jacobi steps of 5 ms and one of `h` [s]."""
    coupled = Coupled(gives_velocity, time_step)
    for _ in range(20):
        coupled.jacobi(0.005)
    coupled.jacobi(h)
    return coupled.force()[0]


def main() -> None:
    reference = monolithic(0.00125)
    print(f"largest force {np.max(np.abs(reference[1])) / 1e3:.2f} kN; errors relative to it")
    print("scheme        velocities  largest     RMS")
    for scheme in ("iterated", "gauss_seidel", "jacobi"):
        for gives_velocity in (True, False):
            errors = [random_steps(scheme, gives_velocity, seed, reference) for seed in range(5)]
            largest, rms = np.max(errors, axis=0)
            print(f"{scheme:13} {'yes' if gives_velocity else 'no':10} {largest:8.2%} {rms:8.2%}")
    print("\nstep          force without velocities, with them [kN]")
    for h in (5e-3, 1e-3, 1e-4, 1e-5, 1e-6):
        pair = [after_a_shorter_step(gives, h) / 1e3 for gives in (False, True)]
        print(f"{h:8g} s    {pair[0]:8.2f} {pair[1]:8.2f}", flush=True)


if __name__ == "__main__":
    main()
