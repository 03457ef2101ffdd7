"""Events between two neighbouring points of a branch: detection, location and kind.

| Kind | Condition |
| --- | --- |
| fold | the parameter has an extremum along the branch |
| branch point, symmetry breaking | a real eigenvalue 0 (multiplier 1) that is no fold |
| Hopf | a complex pair of eigenvalues on the imaginary axis |
| period doubling | a real multiplier -1 |
| torus | a complex pair of multipliers on the unit circle |
| rest | the orbit shrinks to an equilibrium (at a Hopf point) |
| period halving | an orbit becomes one of half its period |
| symmetry recovered | a solution without symmetry becomes one with symmetry |
| range, period, names of users' events | a given function is zero |

The growth exponents of a point are sorted (`Point.levels`); each is a continuous function along the
branch. If the number of positive ones changes from a to b, the zeros of exponents number a to b
are located. All events are located in the arclength by `costly_root`.

Every stability change must be explained: one multiplier 1 for each fold, and a change of the sign
of the determinant for each branch point. If that fails, or if a located function is not zero where
it changes its sign, the step has probably jumped to another branch, and is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from modal.continuation.equations import (
    ALIKE,
    GRID,
    EquilibriumEquations,
    length,
)
from modal.continuation.path import LOCATION_TOLERANCE, Point, Settings, Stepper
from modal.continuation.problem import ContinuationError
from modal.foundation.root_finding import costly_root

Array = NDArray[np.float64]

MAX_RESIDUE = 1e-3
"""Largest value of a function at its zero, relative to its values at the ends of the step."""

NOISE = 1e-6
"""Value of a function that counts as zero in any case."""

SINGULAR = 1e-3
"""Relative singular value below which a point is close to a branch point."""

MAX_INTERPOLATION_ERROR = 0.01
"""Distance from a segment, relative to its length, above which Newton's method has left it."""

HOPF_ITERATIONS = 20
"""Largest number of secant steps to the Hopf point at which an orbit ends."""

MAX_FREQUENCY_DIFFERENCE = 0.1
"""Relative difference of an orbit's frequency to that of the Hopf point at which it ends."""


class UserEvent(NamedTuple):
    """A function whose zeros are events.

    Attributes
    ----------
    name : str
        Kind of the event.
    function : callable
        ``function(states, parameter)`` of the nodal states (node, n); continuous.
    is_terminal : bool
        True if the branch ends there.
    """

    name: str
    function: Callable[[Array, float], float]
    is_terminal: bool = True


@dataclass(frozen=True)
class Event:
    """A special point of a branch.

    Attributes
    ----------
    kind : str
        See the module; "lost", "closed" and "points" are ends without a location.
    point : Point
        The solution there.
    value : complex
        The critical eigenvalue [1/time] or multiplier.
    reason : str
        Details of an end.
    """

    kind: str
    point: Point = field(repr=False)
    value: complex = 0.0j
    reason: str = ""

    @property
    def parameter(self) -> float:
        """The parameter."""
        return self.point.parameter

    @property
    def rotation(self) -> float:
        """Angle of the critical multiplier, in turns per period: 0.5 for a period doubling."""
        return float(abs(np.angle(self.value)) / (2.0 * np.pi))


SWITCHING = (
    "branch point",
    "symmetry breaking",
    "Hopf",
    "period doubling",
)
"""Kinds at which other branches start that can be followed."""


class Segment:
    """The branch between two points on the same mesh.

    Parameters
    ----------
    stepper
        For corrections.
    base, new : Point
        The points.
    length_
        Distance along the tangent of the first.
    """

    def __init__(self, stepper: Stepper, base: Point, new: Point, length_: float) -> None:
        self.stepper, self.base, self.new, self.length = stepper, base, new, length_
        # Hermite's cubic polynomial, with the slope by the distance along the first tangent
        slope = new.tangent * (length_ / float(base.equations.dual(base.tangent) @ new.tangent))
        move = new.x - base.x
        start = length_ * base.tangent
        self._powers = (base.x, start, 3.0 * move - 2.0 * start - slope, start + slope - 2.0 * move)

    def at(self, part: float) -> Point:
        """Point at a part 0..1 of the segment."""
        if part in (0.0, 1.0):
            return self.new if part else self.base
        base, step = self.base, part * self.length
        guess = sum(vector * part**k for k, vector in enumerate(self._powers))
        assert isinstance(guess, np.ndarray)
        if base.linear.determinant == self.new.linear.determinant:
            guess = self.stepper.near(base.equations, guess, base, step)

        def correct(cutoff: float) -> Point:
            return self.stepper.correct(
                base.equations, guess, base.x, base.tangent, step, cutoff=cutoff
            )

        if base.linear.determinant == self.new.linear.determinant:
            return correct(0.0)
        try:
            point = correct(0.0)
        except ContinuationError:
            return correct(SINGULAR)
        is_near = length(base.equations, point.x - guess) <= MAX_INTERPOLATION_ERROR * self.length
        return point if is_near else correct(SINGULAR)

    def zero(self, function: Callable[[Point], float]) -> tuple[float, Point]:
        """Part and point at which a function is zero that changes its sign.

        Raises
        ------
        ContinuationError
            If it is not continuous there, or a correction fails.
        """
        found: dict[float, Point] = {}

        def value(part: float) -> float:
            found[part] = self.at(part)
            return function(found[part])

        ends = value(0.0), value(1.0)
        part = costly_root(value, (0.0, 1.0), ends, self.stepper.settings.location_tolerance)
        if abs(function(found[part])) > MAX_RESIDUE * max(map(abs, ends)) + NOISE:
            raise ContinuationError(
                f"a jump to another branch is not excluded at {self.new.parameter:.6g}: a quantity"
                " that is continuous along a branch is not"
            )
        return part, found[part]


Found = list[tuple[float, Event]]


def events_between(
    segment: Segment, settings: Settings, user: Sequence[UserEvent], max_period: float
) -> Found:
    """Events of a segment in the order of the branch, each with its part 0..1 of the segment.

    Raises
    ------
    ContinuationError
        If the changes of stability cannot be explained; see the module.
    """
    base, new = segment.base, segment.new
    ends = _returns(segment)
    if ends:
        return ends
    found = _fold_and_crossings(segment, settings.max_unstable)
    for bound in (settings.lowest, settings.highest):
        if (base.parameter - bound) * (new.parameter - bound) < 0.0:
            part, point = segment.zero(lambda at, bound=bound: at.parameter - bound)  # type: ignore[misc]
            found.append((part, Event("range", point, reason=f"end of the range: {bound:g}")))
    if base.period <= max_period < new.period:
        part, point = segment.zero(lambda at: at.period - max_period)
        reason = f"the period exceeds {max_period:.4g}: the orbit approaches a homoclinic one"
        found.append((part, Event("period", point, reason=reason)))
    for event in user:

        def level(point: Point, event: UserEvent = event) -> float:
            return event.function(point.states, point.parameter)

        if level(base) * level(new) < 0.0:
            part, point = segment.zero(level)
            found.append((part, Event(event.name, point)))
    return sorted(found, key=lambda one: one[0])


def _fold_and_crossings(segment: Segment, max_unstable: int | None) -> Found:
    """Folds and changes of stability; each must explain the other, if all are located."""
    base, new = segment.base, segment.new
    found: Found = []
    if base.tangent[-1] * new.tangent[-1] < 0.0:
        part, point = segment.zero(lambda at: float(at.tangent[-1]))
        found.append((part, Event("fold", point)))
    limit = np.inf if max_unstable is None else max_unstable
    crossings = _crossings(segment, limit)
    if max(base.unstable, new.unstable) > limit + 1:
        return found + [(part, _named(event)) for part, event in crossings]
    simple = [one for one in crossings if one[1].kind == "branch point"]
    if found and simple:  # the multiplier 1 of the fold
        nearest = min(simple, key=lambda one: abs(one[0] - found[0][0]))
        simple.remove(nearest)
        crossings.remove(nearest)
    elif found:
        raise ContinuationError("a fold without a change of stability")
    if (base.linear.determinant != new.linear.determinant) != (len(simple) % 2 == 1):
        raise ContinuationError(
            f"a jump to another branch is not excluded at {new.parameter:.6g}: the determinant"
            " changes its sign, and the stability does not, or the other way round"
        )
    return found + [(part, _named(event)) for part, event in crossings]


def _crossings(segment: Segment, limit: float) -> Found:
    """Zeros of the growth exponents that change their sign, with at most so many growing ones."""
    low, high = sorted((segment.base.unstable, segment.new.unstable))
    found: Found = []
    number = low
    while number < high and number <= limit:
        part, point = segment.zero(lambda at, k=number: float(at.levels[k]))  # type: ignore[misc]
        value = complex(point.spectrum[number])
        is_orbit = point.equations.kind == "orbit"
        if value.imag != 0.0:
            kind = "torus" if is_orbit else "Hopf"
            number += 2
        else:
            kind = "period doubling" if is_orbit and value.real < 0.0 else "branch point"
            number += 1
        found.append((part, Event(kind, point, value)))
    return found


def _named(event: Event) -> Event:
    """Call a branch point a symmetry breaking if it is one."""
    if event.kind != "branch point":
        return event
    point = event.point
    direction = point.equations.null_vector(point.linear)
    if not point.equations.breaks_symmetry(point.x, direction):
        return event
    return Event("symmetry breaking", point, event.value)


def _returns(segment: Segment) -> Found:
    """Rest, period halving or symmetry recovered: where a branch runs into one with less motion.

    Behind that point, the branch would repeat its mirror image or itself with a shift of time. Such
    a part of the motion (deviation from the mean, from the motion half a period later, from the
    mirror image) changes its sign there.
    """
    base, new = segment.base, segment.new
    for kind, part_of in _parts(base):
        reference = part_of(base)
        if float(np.sum(part_of(new) * reference)) > 0.0:
            continue
        if kind == "rest":
            return [(1.0, _hopf_near(segment))]

        def level(at: Point, part_of: PartOf = part_of, reference: Array = reference) -> float:
            return float(np.sum(part_of(at) * reference))

        part, point = segment.zero(level)
        return [(part, Event(kind, point))]
    return []


PartOf = Callable[[Point], Array]


def _parts(base: Point) -> list[tuple[str, PartOf]]:
    """Parts of the motion, scaled, that do not vanish at a point."""
    problem = base.equations.problem
    scale, mirror = problem.scale, problem.symmetry
    parts: list[tuple[str, PartOf]] = []
    if isinstance(base.equations, EquilibriumEquations):
        if mirror is not None:
            parts.append(("symmetry recovered", lambda at: _less_mirrored(at.states, mirror, 0)))
    else:

        def grid(at: Point) -> Array:
            return at.at(GRID) / scale

        half = len(GRID) // 2
        parts.append(("rest", lambda at: grid(at) - grid(at).mean(axis=0)))
        parts.append(("period halving", lambda at: grid(at) - np.roll(grid(at), half, axis=0)))
        if mirror is not None:
            scaled = mirror * scale / scale[:, None]
            for shift in (0, half):
                parts.append(
                    (
                        "symmetry recovered",
                        lambda at, shift=shift: _less_mirrored(grid(at), scaled, shift),  # type: ignore[misc]
                    )
                )
    size = float(np.max(np.abs(base.states / scale)))
    return [one for one in parts if float(np.max(np.abs(one[1](base)))) > ALIKE * size]


def _less_mirrored(states: Array, mirror: Array, shift: int) -> Array:
    """States less their mirror image some instants later."""
    return np.asarray(states - np.roll(states, shift, axis=0) @ mirror.T)


def _hopf_near(segment: Segment) -> Event:
    """Find the Hopf point at which the orbits of a segment shrink to rest.

    Raises
    ------
    ContinuationError
        If there is none with their frequency.
    """
    base = segment.base
    omega = 2.0 * np.pi / base.period
    equations = EquilibriumEquations(
        base.equations.problem, segment.stepper.settings.parameter_scale
    )
    state = base.mean
    hold = np.zeros(len(state) + 1)
    hold[-1] = equations.parameter_scale

    def at(parameter: float) -> tuple[Point, complex]:
        x = np.append(state, parameter)
        point = segment.stepper.correct(equations, x, x, hold, 0.0)
        value = point.spectrum[np.argmin(np.abs(point.spectrum - 1j * omega))]
        return point, complex(value)

    low, high = base.parameter, segment.new.parameter
    if low == high:
        high = low + LOCATION_TOLERANCE * equations.parameter_scale
    growth_low, growth_high = at(low)[1].real, at(high)[1].real
    for _ in range(HOPF_ITERATIONS):
        if growth_high == growth_low:
            break
        following = high - growth_high * (high - low) / (growth_high - growth_low)
        low, growth_low, high = high, growth_high, following
        point, value = at(high)
        growth_high = value.real
        if abs(high - low) <= LOCATION_TOLERANCE * equations.parameter_scale:
            if abs(value.imag - omega) > MAX_FREQUENCY_DIFFERENCE * omega:
                break
            return Event("rest", point, value)
    raise ContinuationError(f"no Hopf point found near {base.parameter:.6g}, where orbits shrink")
