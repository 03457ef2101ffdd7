r"""The condensed span: a few modes, tension constant along the span, for screening and sweeps.

Derivation.  S is the arc length of the initial equilibrium X(S), a prime d/dS, c = X1' the cosine of its slope.  Axial
inertia is left out, so the horizontal tension H = T p1 is the same along the span.  With the strain
``X'.u' + u'.u'/2`` and springs k_l, k_r along x1 at the ends it follows, to second order in the slopes u',

    H = H0 + k (e + Q),       1/k = 1/k_c + 1/k_l + 1/k_r,    1/k_c = int dS / (EA c^2),
    e = int X2' u2' / c dS,   Q = 1/2 int (u2'^2 / c^3 + u3'^2 / c) dS,

where u1' = - X2' u2' / c of the static longitudinal motion is in the c^3 of Q.  The energy k (e + Q)^2 / 2 gives the
linear stiffness k e e, and the quadratic and cubic forces.  (Irvine's theory is its limit for a shallow parabola, rigid
ends and e alone.)

Modes.  Everything linear is the element's: mass, damping and stiffness matrices come from its mesh, the longitudinal
displacements follow statically (their mass is kept), the lowest shapes of vertical, horizontal and twisting motion
alone form a basis, in which the coupled eigenvalue problem is solved: eccentric ice couples the three.

Damping.  The element's Rayleigh damping is built once from the initial state, so it damps the strain that is linear in
the displacements, which differs from the true one by s = (u2'^2/c^2 + u3'^2)/2.  Quasi-statically its rate is
dH/dt / EA - ds/dt, which costs the power b2 EA int (dH/dt / EA - ds/dt)^2 dS.  Its linear part is in the matrix; the
rest is small for rigid ends, but takes a tenth off the amplitude of large galloping between longitudinal springs.

Wind and ice.  The full quasi-steady load with the scene's coefficient curve, and the turned ice's inertia and weight, at
eight Gauss sections of the span.

In time the linear part of each mode is exact, the rest is integrated by an exponential Runge-Kutta scheme of order four
(Cox, Matthews 2002, J. Comput. Phys. 176, 430-455).
"""

from __future__ import annotations

import math
import time as clock
from collections.abc import Sequence
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.channels import NODE_CHANNELS, SPAN_CHANNELS, Channel
from gallop_fmu.engine import CONDENSED_MODES, CONDENSED_SECTIONS, Array, Condensed, Inputs, Model, build
from gallop_fmu.errors import SceneError
from gallop_fmu.laws import Harmonic, Law
from gallop_fmu.outcome import Outcome, Report, SimulationError
from gallop_fmu.result import Result
from gallop_fmu.scene import Scene

if TYPE_CHECKING:
    import xarray as xr

    from gallop_fmu.simulation import Progress

VERTICAL, HORIZONTAL, TORSIONAL = 7, 4, 5
"""Shapes of each direction, the lowest ones, symmetric and antisymmetric."""

ELEMENTS = 16
"""Finest mesh that is condensed; a finer one changes the frequencies of these shapes by less than 1e-5."""

STEPS_PER_PERIOD = 14
"""Time steps in a period of the first symmetric vertical mode."""

CHANNELS = ("u2", "u3", "theta", "v2", "v3", "omega", "tension", "angle_of_attack")
"""What a condensed run records at a node."""

HORIZONTAL_TENSION = Channel("horizontal_tension", "N", "horizontal tension, the same along the span")

DEEPEST_SAG = 1.0 / 8.0
STEEPEST_CHORD = 0.3
"""Sag and height difference over the span's length up to which a scene is accepted."""

STATIC_ITERATIONS = 50
SECONDS_BETWEEN_CALLS = 500.0
"""Simulated time between two calls of the progress function [s]."""


@dataclass(frozen=True)
class CondensedSpan:
    """A span in the coordinates of its coupled modes; arrays are padded with empty modes to 16.

    Attributes
    ----------
    model : Model
        The element model that was condensed.
    frequency_hz : ndarray, shape (mode,)
        Natural frequencies [Hz] of the modes that are not empty.
    shapes : ndarray, shape (16, node, 4)
        Displacements u1, u2, u3, theta per unit coordinate at the model's nodes.
    values : dict
        What the kernel needs, by the names of ``gallop_condensed``; without the time step.
    start : ndarray, shape (16,)
        Coordinates of the scene's initial seed.
    """

    model: Model
    frequency_hz: Array
    shapes: Array
    values: dict[str, float | Array]
    start: Array

    @property
    def vertical_hz(self) -> float:
        """Frequency [Hz] of the mode that moves mid-span most, up or down."""
        middle = np.abs(self.shapes[: len(self.frequency_hz), self.model.middle, 1])
        return float(self.frequency_hz[np.argmax(middle > 0.5 * middle.max())])

    def at(self, fraction: Array, side: float = 0.0) -> tuple[Array, Array]:
        """Shapes (point, mode, 4) and their slopes by S, at fractions of the mesh; `side` leans to an element."""
        return _interpolated(self.model, self.shapes, fraction, side)[:2]


def condense(scene: Scene) -> CondensedSpan:
    """Reduce a span to its lowest modes.

    Raises
    ------
    SceneError
        If the scene is outside the range of the condensed model; the message says why.
    SimulationError
        If no initial equilibrium exists.
    """
    _check_scene(scene)
    if scene.numerics.elements > ELEMENTS:
        coarse = scene.numerics.model_copy(update={"elements": ELEMENTS})
        scene = scene.model_copy(update={"numerics": coarse})
    model = Model(scene)
    rest = model.equilibrium()
    if rest.sag > DEEPEST_SAG * scene.span.length:
        raise SceneError(_refused(f"its sag is {rest.sag / scene.span.length:.3f} of its length, above {DEEPEST_SAG:g}"))
    air = Inputs(time=0.0, wind_speed=0.0, attack_angle=0.0, support=np.zeros((2, 3)))
    mass, damping, stiffness = (model.tangent(**{name: 1.0}, inputs=air) for name in ("mass", "damping", "stiffness"))
    basis = _basis(model, mass, stiffness)
    squares, vectors = _eigen(_projected(stiffness, basis) + _springs(model, basis), _projected(mass, basis))
    if squares[0] <= 0.0:
        raise SceneError(_refused("its initial equilibrium is unstable"))
    _check_laws(scene, math.sqrt(squares[-1]) / (2.0 * math.pi))
    empty = CONDENSED_MODES - len(squares)
    shapes = np.einsum("bk,bni->kni", vectors, basis)
    shapes = np.concatenate([shapes, np.zeros((empty, *shapes.shape[1:]))])
    coupling = _projected(damping, shapes)
    values: dict[str, float | Array] = {
        "horizontal_tension": rest.horizontal_tension,
        "damping_time": rest.translation_damping[1],
        "frequency": np.concatenate([np.sqrt(squares), np.ones(empty)]),
        "damping": np.diag(coupling),
        "coupling": coupling - np.diag(np.diag(coupling)),
        **_stretching(model, shapes),
        **_at_sections(model, shapes),
        "load": _loads(model, shapes),
    }
    start = scene.initial
    wave = np.sin(np.pi * rest.x[:, 0] / scene.span.length)
    seed = wave[:, None] * [0.0, start.seed_vertical, start.seed_horizontal, start.seed_twist]
    q = np.einsum("kei,eij,ej->k", _by_element(shapes), mass, _by_element(seed[None])[0])
    return CondensedSpan(model, np.sqrt(squares) / (2.0 * np.pi), shapes, values, q)


def _refused(reason: str) -> str:
    return f"the condensed model does not take this span: {reason}; use simulate(scene)"


def _check_scene(scene: Scene) -> None:
    rise = abs(scene.span.height_difference)
    if rise > STEEPEST_CHORD * scene.span.length:
        raise SceneError(_refused(f"span.height_difference is {rise / scene.span.length:.3f} of its length, above {STEEPEST_CHORD:g}"))
    for name in ("left", "right"):
        motion = getattr(scene.supports, name).motion
        if motion is not None and any(getattr(motion, axis) is not None for axis in ("x1", "x2", "x3")):
            raise SceneError(_refused(f"supports.{name}.motion moves a tower, and towers stand still in it"))
    for index, load in enumerate(scene.loads):
        if load.force[0] != 0.0:
            raise SceneError(_refused(f"loads.{index}.force pulls along the span, where its tension is constant"))


def _check_laws(scene: Scene, highest: float) -> None:
    """Refuse excitation that the modes left out would answer to."""
    laws: dict[str, Law | None] = {f"loads.{index}.law": load.law for index, load in enumerate(scene.loads)}
    laws["wind.history"] = scene.wind.history
    for name, law in laws.items():
        if isinstance(law, Harmonic) and law.frequency > 0.5 * highest:
            raise SceneError(_refused(f"{name}.frequency = {law.frequency} Hz is above {0.5 * highest:.3f} Hz, half of its highest mode"))


def _eigen(stiffness: Array, mass: Array) -> tuple[Array, Array]:
    """Squares of the natural frequencies [1/s2] and mass-normalised vectors (row, mode)."""
    inverse = np.linalg.inv(np.linalg.cholesky(mass))
    squares, vectors = np.linalg.eigh(inverse @ stiffness @ inverse.T)
    return squares, inverse.T @ vectors


def _by_element(shapes: Array) -> Array:
    """Nodal values (mode, node, 4) as (mode, element, 12)."""
    return np.concatenate([shapes[:, 0:-2:2], shapes[:, 1:-1:2], shapes[:, 2::2]], axis=2)


def _projected(elements: Array, shapes: Array) -> Array:
    """Modal matrix of element matrices (element, 12, 12)."""
    u = _by_element(shapes)
    return np.asarray(np.einsum("kei,eij->kej", u, elements).reshape(len(u), -1) @ u.reshape(len(u), -1).T)


def _springs(model: Model, shapes: Array) -> Array:
    """Modal stiffness of the supports' springs."""
    ends = shapes[:, [0, -1]][:, :, [0, 2]]
    return np.asarray(np.einsum("kei,ei,lei->kl", ends, model.equilibrium().support_stiffness, ends))


def _block(elements: Array, row: int, column: int) -> Array:
    """Matrix (node, node) of one unknown's forces by another's displacements."""
    total = np.zeros((2 * len(elements) + 1,) * 2)
    for e, element in enumerate(elements):
        total[2 * e : 2 * e + 3, 2 * e : 2 * e + 3] += element[row::4, column::4]
    return total


def _basis(model: Model, mass: Array, stiffness: Array) -> Array:
    """Lowest shapes (mode, node, 4) of each direction alone; u1 follows statically."""
    springs = model.equilibrium().support_stiffness
    inner = np.arange(1, model.nodes - 1)
    free = [inner] * 4
    for unknown, column in ((0, 0), (2, 1)):
        left, right = springs[:, column] > 0.0
        free[unknown] = np.arange(0 if left else 1, model.nodes - (0 if right else 1))
    along = _block(stiffness, 0, 0)
    along[[0, -1], [0, -1]] += springs[:, 0]
    inverse = np.linalg.inv(along[np.ix_(free[0], free[0])])
    shapes = []
    for unknown, count in ((1, VERTICAL), (2, HORIZONTAL), (3, TORSIONAL)):
        own = np.ix_(free[unknown], free[unknown])
        pull = _block(stiffness, 0, unknown)[np.ix_(free[0], free[unknown])]
        follow = -inverse @ pull
        k, m = _block(stiffness, unknown, unknown), _block(mass, unknown, unknown)
        if unknown == 2:
            k[[0, -1], [0, -1]] += springs[:, 1]
        heavy = _block(mass, 0, 0)[np.ix_(free[0], free[0])]
        _, vectors = _eigen(k[own] + pull.T @ follow, m[own] + follow.T @ heavy @ follow)
        part = np.zeros((min(count, len(free[unknown])), model.nodes, 4))
        part[:, free[unknown], unknown] = vectors[:, : len(part)].T
        part[:, free[0], 0] = (follow @ vectors[:, : len(part)]).T
        shapes.append(part)
    return np.concatenate(shapes)


def _interpolated(model: Model, shapes: Array, fraction: Array, side: float = 0.0) -> tuple[Array, Array, Array, Array]:
    """At fractions of the mesh: shapes (point, mode, 4), their slopes, X' (point, 3), and dS per unit fraction."""
    where = np.asarray(fraction) * model.elements
    e = np.clip(np.floor(where + side).astype(int), 0, model.elements - 1)
    xi = (2.0 * (where - e) - 1.0)[:, None]
    values = np.hstack([0.5 * xi * (xi - 1.0), 1.0 - xi**2, 0.5 * xi * (xi + 1.0)])
    slopes = np.hstack([xi - 0.5, -2.0 * xi, xi + 0.5])
    nodes = 2 * e[:, None] + np.arange(3)
    moves = shapes[:, nodes]
    tangent = np.einsum("pn,pni->pi", slopes, model.equilibrium().x[nodes])
    stretch = np.linalg.norm(tangent, axis=1, keepdims=True)
    shape, slope = (np.einsum("pn,kpni->pki", part, moves) for part in (values, slopes / stretch))
    return shape, slope, tangent / stretch, 2.0 * model.elements * stretch[:, 0]


def _stretching(model: Model, shapes: Array) -> dict[str, float | Array]:
    """k, e and G of the derivation, at the element's Gauss points."""
    gauss = (0.5 + np.array([-0.5, 0.5]) / math.sqrt(3.0) + np.arange(model.elements)[:, None]).ravel() / model.elements
    _, slope, tangent, per = _interpolated(model, shapes, gauss)
    c, length = tangent[:, 0], per / len(gauss)
    flexibility = conductor = float(np.sum(length / c**2)) / model.scene.conductor.axial_stiffness
    flexibility += sum(1.0 / k for k in model.equilibrium().support_stiffness[:, 0] if k > 0.0)
    vertical, horizontal = slope[:, :, 1], slope[:, :, 2]
    return {
        "stiffness": 1.0 / flexibility,
        "share": conductor / flexibility,
        "elongation": (length * tangent[:, 1] / c) @ vertical,
        "stretch": vertical.T @ (vertical * (length / c**3)[:, None]) + horizontal.T @ (horizontal * (length / c)[:, None]),
    }


def _at_sections(model: Model, shapes: Array) -> dict[str, float | Array]:
    """Shapes and slopes at Gauss sections, alone and times what an integral over the span needs."""
    point, weight = np.polynomial.legendre.leggauss(CONDENSED_SECTIONS)
    shape, slope, tangent, per = _interpolated(model, shapes, 0.5 * (point + 1.0))
    length = 0.5 * weight * per
    moves = np.moveaxis(shape[:, :, 1:], 2, 0)  # (component, section, mode)
    slopes = np.stack([slope[:, :, 1] / tangent[:, :1], slope[:, :, 2]])
    stress = model.equilibrium().translation_damping[1] * model.scene.conductor.axial_stiffness
    return {
        "shape": np.swapaxes(moves, 1, 2),
        "weighted": moves * length[:, None],
        "slope": np.swapaxes(slopes, 1, 2),
        "slope_weighted": slopes * (stress * length)[:, None],
    }


def _loads(model: Model, shapes: Array) -> Array:
    """Modal forces (load, mode) of each load at amplitude factor 1."""
    rows = np.zeros((len(model.scene.loads), len(shapes)))
    edges = np.arange(model.elements + 1) / model.elements
    middles = (np.arange(model.elements) + 0.5) / model.elements
    reached = np.append(0.0, np.cumsum(_interpolated(model, shapes, middles)[3])) / model.elements
    for row, load in zip(rows, model.scene.loads, strict=True):
        count = load.evenly_spaced or 0
        places = [load.position] if load.position is not None else np.arange(1, count + 1) / (count + 1)
        fraction = np.interp(np.array(places) * reached[-1], reached, edges)
        row += np.einsum("pki,i->k", _interpolated(model, shapes, fraction)[0], [*load.force, load.torque])
    return rows


def simulate_condensed(
    scene: Scene,
    stop_time: float | None = None,
    *,
    time_step: float | None = None,
    record_every: int | None = None,
    record_nodes: Literal["midspan", "all"] | Sequence[int] = "midspan",
    progress: Progress | None = None,
    on_failure: Literal["raise", "return"] = "raise",
) -> Result:
    """Compute the motion of a span with its condensed model, about ten times as fast as `simulate`.

    Sixteen coupled modes (seven vertical, four horizontal, five torsional shapes, antisymmetric ones among them), the
    tension constant along the span, all of the aerodynamic curve, turning ice and the element's damping.

    Parameters
    ----------
    scene
        What to compute.
    stop_time
        Simulated time [s]; None takes the scene's.
    time_step
        Longest time step [s]; None takes a fourteenth of the first symmetric vertical period. The scene's time step has
        no part in it but to say when to record.
    record_every
        Time steps of the scene from one record to the next, as for `simulate`; None takes the scene's.
    record_nodes
        As for `simulate`, in the numbering of the scene's mesh.
    progress, on_failure
        As for `simulate`.

    Returns
    -------
    Result
        Laid out as that of `simulate`, with the node channels `CHANNELS`, ``wind_speed`` and ``horizontal_tension``.
        ``dataset.attrs["model"]`` says that the model was condensed.

    Raises
    ------
    SceneError
        If an argument is not allowed, or the scene is outside the model's range: a sag above an eighth of the span, a
        height difference above 0.3 of it, moving towers, loads along the span, harmonic excitation above half of its
        highest frequency.
    SimulationError
        If the run ends early (slack, attack angle out of range, motion not finite) and `on_failure` is ``"raise"``.
    """
    from gallop_fmu.simulation import _check_arguments, _nodes

    stop_time = scene.run.stop_time if stop_time is None else stop_time
    every = scene.run.record_every if record_every is None else record_every
    _check_arguments(stop_time, every, CHANNELS, on_failure)
    if time_step is not None and not (math.isfinite(time_step) and time_step > 0.0):
        raise SceneError(f"time_step = {time_step}: must be a positive number of seconds")
    nodes = _nodes(record_nodes, scene.numerics.elements)
    started = clock.perf_counter()
    span = condense(scene)
    interval = every * scene.numerics.time_step
    longest = 1.0 / (STEPS_PER_PERIOD * span.vertical_hz) if time_step is None else time_step
    pace = _Pace.of(interval, longest)
    kernel = Condensed(span.model, {**span.values, "time_step": pace.time_step})
    q, v = _start(scene, span, kernel), np.zeros(CONDENSED_MODES)
    records = max(1, math.ceil(stop_time / interval - 1e-9))
    first = np.stack([q, v])[None]
    parts, report = _march(kernel, q, v, pace, records, interval, stop_time, progress)
    history = np.concatenate([first, *parts])[: records + 1]
    seconds = clock.perf_counter() - started
    result = Result(_dataset(scene, span, pace, history, nodes, interval, report, seconds), scene, report)
    if report.outcome is not Outcome.COMPLETED and on_failure == "raise":
        raise SimulationError(report, result)
    return result


@dataclass(frozen=True)
class _Pace:
    """Time step [s], steps to a record, records within a step; one of the latter is 1."""

    time_step: float
    every: int
    within: int

    @classmethod
    def of(cls, interval: float, longest: float) -> _Pace:
        within = math.floor(longest / interval * (1.0 + 1e-9))
        if within >= 1:
            return cls(within * interval, 1, within)
        every = math.ceil(interval / longest * (1.0 - 1e-9))
        return cls(interval / every, every, 1)


def _start(scene: Scene, span: CondensedSpan, kernel: Condensed) -> Array:
    """Coordinates at time 0: the seed, upon the static equilibrium in the wind if the scene asks for it."""
    if scene.initial.wind == "at_once":
        return span.start.copy()
    q, still, step = np.zeros(CONDENSED_MODES), np.zeros(CONDENSED_MODES), 1e-6
    squares = np.asarray(span.values["frequency"]) ** 2
    for _ in range(STATIC_ITERATIONS):
        force = kernel.forces(q, still)[0]
        slope = np.array([(kernel.forces(q + row, still)[0] - force) / step for row in step * np.eye(CONDENSED_MODES)]).T
        change = np.linalg.solve(np.diag(squares) - slope, force - squares * q)
        q = q + change
        if np.max(np.abs(change)) < 1e-9 * max(1.0, float(np.max(np.abs(q)))):
            return np.asarray(q + span.start)
    raise SimulationError(Report(Outcome.EQUILIBRIUM_NOT_FOUND, 0.0))


def _march(
    kernel: Condensed,
    q: Array,
    v: Array,
    pace: _Pace,
    records: int,
    interval: float,
    stop_time: float,
    progress: Progress | None,
) -> tuple[list[Array], Report]:
    """Run in portions, so that progress is shown and Ctrl-C is heard."""
    report = Report(Outcome.COMPLETED, 0.0, lowest_tension=math.inf)
    steps = math.ceil(records / pace.within) * pace.every
    portion = max(1, round(SECONDS_BETWEEN_CALLS / (pace.time_step * pace.every))) * pace.every
    parts: list[Array] = []
    for first in range(0, steps, portion):
        stopped = False
        try:
            part, report = kernel.run(q, v, first, min(portion, steps - first), pace.every, pace.within, report)
            parts.append(part)
            if report.outcome is not Outcome.COMPLETED:
                break
            stopped = progress is not None and progress(min(report.time, stop_time), stop_time) is False
        except KeyboardInterrupt:
            stopped = True
        if stopped and first + portion < steps:
            return parts, replace(report, outcome=Outcome.STOPPED_BY_USER)
    return parts, report


def _dataset(
    scene: Scene,
    span: CondensedSpan,
    pace: _Pace,
    history: Array,
    nodes: NDArray[np.int32],
    interval: float,
    report: Report,
    seconds: float,
) -> xr.Dataset:
    import xarray as xr  # a third of a second, which `import gallop_fmu` should not cost

    rest = span.model.equilibrium()
    time = interval * np.arange(len(history))
    fraction = nodes / (2.0 * scene.numerics.elements)
    q, v = history[:, 0], history[:, 1]
    shape = np.moveaxis(span.at(fraction)[0], 2, 0)[1:]  # (component, node, mode)
    moves, rates = (np.einsum("inm,tm->itn", shape, y, optimize=True) for y in (q, v))
    wind = np.asarray((scene.wind.history.at(time) if scene.wind.history else np.full(len(time), scene.wind.speed or 0.0)))
    values: dict[str, Array] = dict(zip(CHANNELS, (*moves, *rates), strict=False))
    tension = _horizontal_tension(span, q)
    values["tension"] = tension[:, None] * _stretch(span, q, fraction)
    values["angle_of_attack"] = _attack_angles(scene, wind, *rates[:2], moves[2], rates[2])
    described = {channel.name: channel for channel in (*NODE_CHANNELS, *SPAN_CHANNELS, HORIZONTAL_TENSION)}
    variables = {name: (("time", "node"), values[name]) for name in CHANNELS}
    spans = {"wind_speed": (("time",), wind), "horizontal_tension": (("time",), tension)}
    x1 = _interpolated(span.model, rest.x[None], fraction)[0][:, 0, 0]
    dataset = xr.Dataset({**variables, **spans}, {"time": time, "node": nodes, "x1": ("node", x1)})
    dataset.time.attrs.update(units="s", long_name="time")
    dataset.x1.attrs.update(units="m", long_name="position of the node along the span")
    for name in (*variables, *spans):
        dataset[name].attrs.update(units=described[name].unit, long_name=described[name].meaning)
    dataset.attrs.update(
        title=scene.title,
        source=f"gallop-fmu {version('gallop-fmu')}",
        kernel=build(),
        model=f"condensed: {len(span.frequency_hz)} modes, tension constant along the span",
        integrator="exponential Runge-Kutta of order four (Cox, Matthews 2002)",
        time_step=pace.time_step,
        scene=scene.to_toml(),
        outcome=report.outcome.name.lower(),
        message=str(report),
        seconds=seconds,
        sag=rest.sag,
        horizontal_tension=rest.horizontal_tension,
        held_imbalance=rest.imbalance,
        steps=report.steps,
        substeps=report.steps,
        iterations=0,
        refactorisations=0,
        halvings=0,
        lowest_tension=report.lowest_tension,
    )
    return dataset


def _horizontal_tension(span: CondensedSpan, q: Array) -> Array:
    """H = H0 + k (e + Q) at each instant [N]."""
    elongation = q @ np.asarray(span.values["elongation"])
    square = 0.5 * np.einsum("tm,tm->t", q @ np.asarray(span.values["stretch"]), q)
    return np.asarray(span.values["horizontal_tension"] + span.values["stiffness"] * (elongation + square))


def _stretch(span: CondensedSpan, q: Array, fraction: Array) -> Array:
    """Tension over horizontal tension (time, node), from the slope of the conductor; averaged between elements."""
    parts = []
    for side in (-1e-6, 1e-6):
        _, slope, tangent, _ = _interpolated(span.model, span.shapes, fraction, side)
        rise, drift = (q @ slope[:, :, i].T for i in (1, 2))
        c = tangent[:, 0]
        parts.append(np.sqrt(1.0 + ((tangent[:, 1] + rise) / c) ** 2 + (drift / c) ** 2))
    return np.asarray(0.5 * (parts[0] + parts[1]))


def _attack_angles(scene: Scene, wind: Array, v2: Array, v3: Array, theta: Array, omega: Array) -> Array:
    """Ice angle, twist and direction of the relative wind [rad]."""
    radius = 0.5 * scene.conductor.diameter
    if scene.aerodynamics is not None and scene.aerodynamics.reference_radius:
        radius = scene.aerodynamics.reference_radius
    relative = np.arctan2(-v2 - radius * omega, wind[:, None] - v3)
    return np.asarray(math.radians(scene.ice.attack_angle_deg) + theta + relative)
