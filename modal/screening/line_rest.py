"""Equilibrium of a line over the wind speed: where it loses stability, and to which motions.

As in `modal.screening.span_diagram`, the winds do not depend on the scene's wind: the first step
and the unit of the wind are those of a fixed grid of wind speeds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import SceneError
from modal.continuation.branch import Branch
from modal.continuation.events import Event
from modal.continuation.path import Settings
from modal.continuation.problem import ContinuationError
from modal.continuation.starts import equilibria
from modal.motions.line_model import LineModel
from modal.motions.motion_words import name_of_oscillation
from modal.motions.reduced_model import static_equilibrium
from modal.motions.rotated import equilibria_at
from modal.motions.span_problem import SpanProblem, WindFamily
from modal.screening.span_diagram import BEGIN, BEYOND, TYPICAL, first_growth
from modal.screening.verdict import grows_with_wind

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

FIRST_STEP, MAX_STEP = 0.05, 1.0
"""Lengths of continuation steps of rest, in typical displacements and lowest onsets."""

NEWTON_TOLERANCE, LOCATION_TOLERANCE = 1e-5, 1e-4
"""Last correction of Newton's method, in typical sizes, and accuracy of the place of an onset,
relative to the step: onsets change by 1e-5 of them."""

STATIC = ("fold", "branch point", "symmetry breaking")
"""Events at which rest becomes statically unstable (divergence)."""

LADDER = np.geomspace(0.02, 1.5, 12)
"""Largest vertical or horizontal velocities of a trial oscillation, relative to the wind speed."""

PHASES = 2.0 * np.pi * np.arange(8) / 8.0
"""Phases of a trial oscillation at which its power is evaluated."""

MAX_TRIALS = 8
"""Number of the least stable modes whose amplitude is estimated."""


@dataclass(frozen=True)
class LineOnset:
    """Motions of the same kind that begin on rest: the lowest wind at which one of them grows.

    Attributes
    ----------
    name : str
        The motion in words, such as "two loops in span 2".
    kind : str
        Family of its modes: "vertical", "horizontal", "string swing", "bundle torsion", ...
    loops : int
        Half-waves in a span.
    wind_speed : float
        Lowest wind speed [m/s] in which it grows.
    frequency_hz : float
        Its frequency [Hz] there.
    growth_rate : float or None
        Largest growth rate [1/s] of such motions in the scene's wind; None: none grows.
    modes : int
        Number of modes of this kind that grow in the scene's wind.
    """

    name: str
    kind: str
    loops: int
    wind_speed: float
    frequency_hz: float
    growth_rate: float | None
    modes: int

    def __str__(self) -> str:
        return f"{self.name} from {self.wind_speed:.4g} m/s ({self.frequency_hz:.3g} Hz)"


@dataclass(frozen=True)
class Trial:
    """A mode of rest in the scene's wind, and the oscillation that the wind would drive in it.

    Attributes
    ----------
    kind, loops, name
        As in `LineOnset`.
    rate, omega : float
        Growth rate [1/s] and angular frequency [rad/s].
    shape : ndarray, shape (mode,)
        Complex coordinates of the mode, of unit largest velocity relative to the wind speed.
    size : float or None
        Largest velocity, relative to the wind speed, at which the wind's work in a cycle just
        equals the damping's, and falls below it as the oscillation grows; None: there is none.
    """

    kind: str
    loops: int
    name: str
    rate: float
    omega: float
    shape: ComplexArray
    size: float | None


@dataclass(frozen=True)
class LineRest:
    """Rest of a line over the wind speed.

    Attributes
    ----------
    model : LineModel
        The reduced line.
    problem : SpanProblem
        The same as a system of equations.
    wind, highest : float
        The scene's wind and the end of the search [m/s].
    unit : float or None
        Wind speed of the fixed grid at which rest is unstable for the first time.
    branch : Branch or None
        Rest over the wind; None if it is stable up to the highest wind.
    end_reason : str
        Reason why rest is not known up to the highest wind; empty if it is.
    """

    model: LineModel
    problem: SpanProblem
    wind: float
    highest: float
    unit: float | None
    branch: Branch | None
    end_reason: str

    @cached_property
    def begins(self) -> list[Event]:
        """Hopf points at which an oscillation begins to grow with the wind, the lowest first."""
        events = [] if self.branch is None else self.branch.of_kind("Hopf")
        grow = [one for one in events if grows_with_wind(one)]
        return sorted(grow, key=lambda one: one.parameter)

    @property
    def divergence(self) -> float | None:
        """Lowest wind speed [m/s] from which rest is statically unstable; None: it is not."""
        events = [] if self.branch is None else self.branch.events
        return min((one.parameter for one in events if one.kind in STATIC), default=None)

    def growth(self, state: Array) -> tuple[ComplexArray, ComplexArray]:
        """Eigenvalues [1/s] and coordinates (mode, eigenvalue) of disturbances of an equilibrium.

        Of each pair the one with positive frequency, the fastest growing first.
        """
        jacobian = self.problem.rates(state[None], self.wind).by_state[0]
        values, vectors = np.linalg.eig(jacobian)
        order = np.argsort(-values.real)
        order = order[values[order].imag >= 0.0]
        return values[order], vectors[: self.model.size, order]

    def equilibria(self) -> list[tuple[Array, bool]]:
        """Equilibria (2 mode,) in the scene's wind, and True for those that are stable."""
        return [
            (state, bool(self.growth(state)[0][0].real < 0.0))
            for state in equilibria_at(self.problem, self.wind)
        ]


def line_rest(model: LineModel, wind: float, highest: float) -> LineRest:
    """Follow the equilibrium of a line up to a wind speed.

    Parameters
    ----------
    model
        The line.
    wind, highest
        The scene's wind and the highest one [m/s].

    Raises
    ------
    SceneError
        If the line is not at rest in a weak wind, or leaves its curve below the scene's wind.
    """
    unit, end_reason = first_growth(model, highest, 0.0)
    problem = SpanProblem(WindFamily(model), model, TYPICAL * (unit or highest))
    branch = None
    if unit is not None:
        settings = Settings(
            BEGIN * unit,
            (1.0 + BEYOND) * highest,
            first_step=FIRST_STEP,
            max_step=MAX_STEP,
            unit=unit,
            newton_tolerance=NEWTON_TOLERANCE,
            location_tolerance=LOCATION_TOLERANCE,
        )
        q, _ = static_equilibrium(model, settings.lowest)
        guess = np.append(q[0], np.zeros(model.size))
        try:
            start = settings.lowest * (1.0 + BEYOND)
            branch = equilibria(problem, guess, start, settings, problem.end_of_curve())
        except ContinuationError as error:
            raise SceneError(f"the line could not be screened, because {error}") from None
    return LineRest(model, problem, wind, highest, unit, branch, end_reason)


def onsets(rest: LineRest, trials: Sequence[Trial]) -> tuple[LineOnset, ...]:
    """Motions that begin on rest up to the highest wind, each kind once.

    Parameters
    ----------
    rest
        Rest over the wind.
    trials
        Modes in the scene's wind.
    """
    found: dict[tuple[str, int], LineOnset] = {}
    for event in rest.begins:
        point = event.point
        jacobian = point.equations.problem.rates(point.states, point.parameter).by_state[0]
        values, vectors = np.linalg.eig(jacobian)
        near = int(np.argmin(np.abs(values - 1j * abs(event.value.imag))))
        shape = vectors[: rest.model.size, near]
        kind, loops, name = name_of_oscillation(shape, rest.model)
        alike = [one.rate for one in trials if (one.kind, one.loops) == (kind, loops)]
        growing = [rate for rate in alike if rate > 0.0]
        hertz = abs(event.value.imag) / (2.0 * np.pi)
        onset = LineOnset(
            *(name, kind, loops, event.parameter, hertz),
            growth_rate=max(growing, default=None),
            modes=len(growing),
        )
        found.setdefault((kind, loops), onset)
    return tuple(found.values())


def trials(rest: LineRest, state: Array) -> list[Trial]:
    """Modes of an equilibrium in the scene's wind, with the amplitude that the wind would drive.

    The amplitude is that of an energy balance: with the shape and frequency of the linear mode, the
    mean power of all forces over a cycle is zero. It is a start for simulations, no result.

    Parameters
    ----------
    rest
        Rest over the wind.
    state : ndarray, shape (2 mode,)
        The equilibrium.
    """
    model, n = rest.model, rest.model.size
    values, shapes = rest.growth(state)
    found = []
    for number, (value, shape) in enumerate(zip(values, shapes.T, strict=True)):
        omega = float(value.imag)
        if omega <= 0.0 or omega > 2.0 * np.pi * model.highest_hz:
            continue
        if number >= MAX_TRIALS and value.real <= 0.0:
            break
        moves = np.tensordot(shape, model.shapes[:, :, 1:3], axes=(0, 0))
        shape = shape * rest.wind / (omega * float(np.max(np.abs(moves))))
        kind, loops, name = name_of_oscillation(shape, model)
        size = _balanced(model, state[:n], shape, omega, rest.wind)
        found.append(Trial(kind, loops, name, float(value.real), omega, shape, size))
    return found


def _balanced(
    model: LineModel, mean: Array, shape: ComplexArray, omega: float, wind: float
) -> float | None:
    """Largest size of `LADDER` at which the power of an oscillation changes from drive to loss."""
    turns = (np.exp(1j * PHASES)[:, None] * shape)[None] * LADDER[:, None, None]
    away, v = ((one * turns).real.reshape(-1, model.size) for one in (1.0, 1j * omega))
    # Forces of tension do no work in a cycle.
    work = -v * model.unstretched(mean + away, v, -(omega**2) * away, wind)
    power = work.sum(axis=1).reshape(len(LADDER), -1).mean(axis=1) / LADDER**2
    ends = np.flatnonzero((power[:-1] > 0.0) & (power[1:] <= 0.0))
    if len(ends) == 0:
        return None
    k = int(ends[-1])
    part = power[k] / (power[k] - power[k + 1])
    return float(LADDER[k] * (LADDER[k + 1] / LADDER[k]) ** part)
