"""Neutral slopes of the modes of a span or line, tracked over the wind speed.

See `modal.stability.required_slope` for the equations.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Scene, SceneError
from modal.linear.line_modes import LineMode
from modal.linear.linearise import SmallMotion
from modal.linear.mode_tracking import Snapshot
from modal.linear.modes import Mode
from modal.linear.neutral_slope import NeutralMode, SlopeProblem
from modal.linear.slope_load import Coefficient, SlopeLoad, straight_curve

if TYPE_CHECKING:
    from scipy.sparse import csc_array

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

WIND_STEP = 1.0
"""Largest step [m/s] between two wind speeds at which a mode is tracked."""

MIN_WIND_STEP = WIND_STEP / 16.0
"""Step [m/s] that is not halved any more."""

MIN_SHARES: dict[Coefficient, float] = {"lift": 0.05, "moment": 0.5}
"""Share of the kinetic energy in motion on which a slope acts, below which none is looked for."""

SEARCHED_MODES = 64
"""Modes among which a torsional one is looked for."""

MIN_LIKENESS = 0.5
"""Modal assurance criterion with the mode at the previous wind speed, below which it is another."""

SLOPES: dict[Coefficient, str] = {"lift": "CD + dCL/dalpha", "moment": "dCM/dalpha"}
"""The slopes that are printed."""

OTHER: dict[Coefficient, Coefficient] = {"lift": "moment", "moment": "lift"}


@dataclass(frozen=True)
class SlopePath:
    """Neutral slopes over the wind speed.

    Attributes
    ----------
    slopes, estimates : ndarray, shape (mode, speed)
        Slope [1/rad], and its estimate by the balance of damping; NaN where there is none.
    frequencies : ndarray, shape (mode, speed)
        Frequency [Hz] of the neutral mode.
    reaches : ndarray, shape (mode, speed)
        Amplitude limit [m] at a saturation of 1.
    """

    slopes: Array
    estimates: Array
    frequencies: Array
    reaches: Array


class SlopeSearch:
    """Finds neutral slopes of the modes of a span or line.

    Parameters
    ----------
    scene
        The span or line.
    count
        Number of modes, the lowest in still air.
    drag
        Drag coefficient.

    Attributes
    ----------
    motion : SmallMotion
        The span or line with constant drag, without lift and moment.
    modes : list of Mode or LineMode
        Its modes in still air.
    numbers : list of int
        Their numbers from 1, in order of frequency.
    drag : float
        The drag coefficient.
    remarks : list of str
        What could not be computed.
    """

    def __init__(self, scene: Scene | LineScene, count: int, drag: float) -> None:
        self.drag = drag
        self.motion = SmallMotion(scene.with_values({"aerodynamics": straight_curve(scene, drag)}))
        self.modes, self.numbers = _chosen_modes(self.motion, count)
        self.remarks: list[str] = []
        mesh = self.motion.mesh
        self._kept = np.flatnonzero(mesh.free)
        nodes = np.zeros((self.motion.model.nodes, 4))
        windy = self.motion.inputs(1.0)
        still = mesh.tangent(nodes, damping=1.0, inputs=mesh.still)
        in_wind = mesh.tangent(nodes, damping=1.0, inputs=windy)
        self._still_damping, self._drag_damping = self._free(still), self._free(in_wind - still)
        self._loads = {name: self._of_free(SlopeLoad.of(mesh, name, drag)) for name in OTHER}
        self._equations: dict[float, tuple[csc_array, csc_array, csc_array] | None] = {}

    def _free(self, matrix: csc_array) -> csc_array:
        return matrix[self._kept][:, self._kept]

    def _of_free(self, load: SlopeLoad) -> SlopeLoad:
        return SlopeLoad(self._free(load.damping), self._free(load.stiffness))

    def _in_wind(self, speed: float) -> tuple[csc_array, csc_array, csc_array] | None:
        """Mass, damping and stiffness of the free unknowns; None without an equilibrium."""
        if speed not in self._equations:
            try:
                self._equations[speed] = self.motion.in_wind(speed).of_free()
            except SceneError as problem:
                self._equations[speed] = None
                self.remarks.append(f"{problem}; no slope from this wind speed on")
        return self._equations[speed]

    def along_wind(self, coefficient: Coefficient, speeds: Array, other_slope: float) -> SlopePath:
        """Find the neutral slopes of a coefficient, with a given slope [1/rad] of the other one."""
        shape = len(self.modes), len(speeds)
        path = SlopePath(*(np.full(shape, np.nan) for _ in range(4)))
        weak = np.minimum(WIND_STEP, speeds[:1])
        for k, mode in enumerate(self.modes):
            if _share(mode, coefficient) < MIN_SHARES[coefficient]:
                continue
            path.estimates[k] = self._estimates(mode, coefficient, speeds)
            start = NeutralMode(
                omega=2.0 * np.pi * mode.frequency_hz,
                slope=float(self._estimates(mode, coefficient, weak)[0]),
                growth_by_slope=0.0,
                vector=self._moving(mode).astype(np.complex128),
            )
            above = []
            for at, found in self._tracked(start, coefficient, speeds, other_slope):
                if found.growth_by_slope >= 0.0:
                    above.append((float(speeds[at]), self._shown(coefficient, found.slope)))
                    continue
                path.slopes[k, at] = found.slope
                path.frequencies[k, at] = found.omega / (2.0 * np.pi)
                path.reaches[k, at] = self._reach(found, float(speeds[at]))
            self._remark(k, coefficient, speeds[np.isnan(path.slopes[k])].tolist(), dict(above))
        return path

    def _shown(self, coefficient: Coefficient, slope: float) -> float:
        """CD + dCL/dalpha, or dCM/dalpha, of a slope."""
        return self.drag + slope if coefficient == "lift" else slope

    def _remark(
        self, k: int, coefficient: Coefficient, missing: list[float], above: dict[float, float]
    ) -> None:
        """Say at which wind speeds a mode has no slope below which it grows."""
        mode = self.modes[k]
        name = f"mode {self.numbers[k]} ({mode.family}, {mode.frequency_hz:.4g} Hz)"
        quantity = SLOPES[coefficient]
        for speed, slope in above.items():
            self.remarks.append(
                f"{name}: at {speed:g} m/s it grows where {quantity} is above {slope:.3g} 1/rad,"
                " not below: motion and twist are coupled"
            )
        unknown = [f"{speed:g}" for speed in missing if speed not in above]
        if unknown:
            self.remarks.append(f"{name}: no {quantity} was found at {', '.join(unknown)} m/s")

    def _moving(self, mode: Mode | LineMode) -> Array:
        """Shape of a mode at the free unknowns."""
        return mode.shape.ravel()[self._kept]

    def _estimates(self, mode: Mode | LineMode, coefficient: Coefficient, speeds: Array) -> Array:
        """Equation (2) of `required_slope` over the wind speed."""
        shape, of_slope = self._moving(mode), self._loads[coefficient].damping
        structure, drag, slope = (
            float(shape @ (matrix @ shape))
            for matrix in (self._still_damping, self._drag_damping, of_slope)
        )
        return -(structure / speeds + drag) / slope

    def _tracked(
        self, start: NeutralMode, coefficient: Coefficient, speeds: Array, other_slope: float
    ) -> Iterator[tuple[int, NeutralMode]]:
        """Follow one mode over the wind speed: number of the wind speed, and neutral mode.

        The path begins in weak wind, whose load does not couple the modes. Where a mode is not
        found, the step is halved.
        """
        before = min(WIND_STEP, float(speeds[0]))
        pending = _steps(before, speeds)[::-1]
        while pending:
            speed = pending.pop()
            equations = self._in_wind(speed)
            if equations is None:
                return
            problem = self._problem(equations, speed, coefficient, other_slope)
            found = problem.neutral(replace(start, slope=start.slope * before / speed))
            if found is None or _likeness(found, start, problem.mass) < MIN_LIKENESS:
                if speed - before > MIN_WIND_STEP:
                    pending += [speed, 0.5 * (before + speed)]
                continue
            start, before = found, speed
            at = int(np.searchsorted(speeds, speed))
            if speeds[at] == speed:
                yield at, found

    def _problem(
        self,
        equations: tuple[csc_array, csc_array, csc_array],
        speed: float,
        coefficient: Coefficient,
        other_slope: float,
    ) -> SlopeProblem:
        mass, damping, stiffness = equations
        load, other = self._loads[coefficient], self._loads[OTHER[coefficient]]
        return SlopeProblem(
            mass=mass,
            damping=damping + other_slope * speed * other.damping,
            stiffness=stiffness + other_slope * speed**2 * other.stiffness,
            slope_damping=speed * load.damping,
            slope_stiffness=speed**2 * load.stiffness,
        )

    def _reach(self, point: NeutralMode, speed: float) -> float:
        """Amplitude [m] of equation (4) for a saturation of 1 and a very negative slope."""
        mesh = self.motion.mesh
        full = np.zeros(mesh.free.size, dtype=np.complex128)
        full[self._kept] = point.vector
        nodal = mesh.spread(full.reshape(mesh.free.shape))
        across = np.abs(mesh.sections.motion(nodal)[0])
        length = mesh.sections.length
        largest = np.max(np.abs(np.sum(mesh.node_normal * nodal[:, :2], axis=1)))
        squares, quartic = length @ across**2, length @ across**4
        return float(speed / point.omega * np.sqrt(4.0 / 3.0 * squares / quartic) * largest)

    def divergence(self, speeds: Array) -> Array:
        """Lowest positive slope of the moment [1/rad] at which the stiffness is singular."""
        from scipy.sparse.linalg import LinearOperator, eigs, splu

        found = np.full(len(speeds), np.nan)
        load = self._loads["moment"].stiffness
        for k, speed in enumerate(speeds.tolist()):
            equations = self._in_wind(speed)
            if equations is None:
                break
            factors = splu(equations[2])
            operator = LinearOperator(
                load.shape, matvec=lambda x, f=factors: -f.solve(load @ x), dtype=np.float64
            )
            largest = eigs(operator, 1, which="LR", v0=np.ones(load.shape[0]))[0][0].real
            if largest > 0.0:
                found[k] = 1.0 / (largest * speed**2)
        return found


def _chosen_modes(motion: SmallMotion, count: int) -> tuple[list[Mode | LineMode], list[int]]:
    """The lowest modes in still air, and the lowest torsional one, with their numbers from 1."""
    chosen: list[Mode | LineMode] = list(Snapshot.of(motion, count).modes)
    numbers = list(range(1, len(chosen) + 1))
    if all(mode.family != "torsional" for mode in chosen):
        more: Sequence[Mode | LineMode] = Snapshot.of(motion, max(count, SEARCHED_MODES)).modes
        for number, mode in enumerate(more, start=1):
            if mode.family == "torsional":
                return [*chosen, mode], [*numbers, number]
    return chosen, numbers


def _steps(first: float, speeds: Array) -> list[float]:
    """Wind speeds [m/s] from a first one, with others between them where they are far apart."""
    steps = [first]
    for low, high in pairwise([first, *speeds.tolist()]):
        between = int(np.ceil((high - low) / WIND_STEP))
        steps += np.linspace(low, high, between + 1)[1:].tolist() if between else []
    return steps


def _share(mode: Mode | LineMode, coefficient: Coefficient) -> float:
    """Share of the kinetic energy in motion on which a slope of the coefficient acts."""
    twist = mode.shares["torsional"]
    if coefficient == "moment":
        return twist
    return 1.0 - twist - mode.shares["horizontal"] - mode.shares["longitudinal"]


def _likeness(found: NeutralMode, before: NeutralMode, mass: csc_array) -> float:
    """Modal assurance criterion of two modes with modal mass 1."""
    return float(np.abs(found.vector.conj() @ (mass @ before.vector)) ** 2)
