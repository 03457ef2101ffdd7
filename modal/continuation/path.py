"""Pseudo-arclength continuation: one step along a branch, and the checks that it stays on it.

A step predicts x0 + s t along the tangent t and corrects by Newton's method, subject to
<t, x - x0> = s. It is repeated with half the length if Newton's method fails, if the
discretisation is too coarse, or if one of these signs of a jump to another branch is seen:

- the tangent turns by more than `MAX_ANGLE`;
- the correction is longer than `MAX_CORRECTION` times the step, or much longer than the curvature
  of the previous step explains;
- a Floquet multiplier (eigenvalue) changes by more than `MAX_SPECTRUM_CHANGE`;
- the determinant of the equations with <t, .> changes its sign although no bifurcation explains
  that (it keeps its sign along a branch up to a branch point; `modal.continuation.events`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from modal.continuation import collocation as co
from modal.continuation.broyden import improved
from modal.continuation.equations import Equations, Linear, OrbitEquations, length
from modal.continuation.problem import ContinuationError

Array = NDArray[np.float64]

NEWTON_TOLERANCE = 1e-8
"""Length of Newton's last correction; the error left is of second order in it."""

LOCATION_TOLERANCE = 1e-9
"""Accuracy of an event's place, relative to the step."""

NEWTON_ITERATIONS, FEW_ITERATIONS = 8, 3
"""Largest number of iterations in a step, and the number at which steps may grow."""

CHEAP_PER_NEWTON = 4
"""Number of corrections by `modal.continuation.broyden` that count as one of Newton's."""

GOOD = 1e-3
"""Length of a correction of a good guess."""

MAX_FIRST_CORRECTION = 10.0
"""Length of a correction above which Newton's iteration is considered lost."""

TARGET_ANGLE, MAX_ANGLE = 0.15, 0.45
"""Angles [rad] between successive tangents: wanted, and largest accepted."""

MAX_CORRECTION = 0.3
"""Largest distance from prediction to solution, relative to the step."""

MAX_BEND_RATIO, FREE_CORRECTION = 8.0, 0.02
"""Largest distance relative to the one that the curvature before explains; distances up to
`FREE_CORRECTION` times the step need no explanation."""

MAX_SPECTRUM_CHANGE = 0.5
"""Largest change of a multiplier (eigenvalue) in a step, relative to 1 + its absolute value."""

SAME_MESH = 0.2
"""Change of the ends of mesh intervals, relative to the mean interval, that is not worth a new
mesh."""

STEP_GROWTH, STEP_SHRINK = 1.6, 0.5
"""Largest growth of a step, and its factor after a failure."""


class GrowingLimit(NamedTuple):
    """Limit of a branch on which many disturbances grow.

    Attributes
    ----------
    disturbances : int
        Number of growing disturbances that is not too large.
    points : int
        Number of points in a row with more than that after which a branch may be given up.
    change : float
        Change of the parameter over these points, relative to its largest value there, from which
        it is.
    """

    disturbances: int
    points: int
    change: float


@dataclass(frozen=True)
class Settings:
    """Bounds of a continuation.

    Attributes
    ----------
    lowest, highest : float
        Range of the parameter.
    tolerance : float
        Largest error of the discretisation, relative to the amplitude of the motion.
    first_step, max_step, min_step : float
        Lengths of steps in the scalar product of `modal.continuation.equations`.
    max_points : int
        Largest number of points of a branch.
    max_period : float
        Period at which a family of orbits ends, relative to its first period.
    max_unstable : int or None
        Number of growing disturbances above which changes of stability are not located, and above
        which `modal.continuation.diagram.explore` follows no branches; None: no limit.
    max_unstable_at_rest : int or None
        The same for equilibria; None: `max_unstable`. A system of several parts that oscillate
        almost independently has many oscillations that begin at almost the same parameter.
    max_total_points : int or None
        Number of points of all branches after which `modal.continuation.diagram.explore` follows no
        more; None: no limit.
    on_point : callable or None
        Called with each new point of a branch, to show progress.
    newton_tolerance : float
        Length of Newton's last correction; the error left is of second order in it.
    location_tolerance : float
        Accuracy of an event's place, relative to the step.
    unit : float or None
        Parameter change of length 1; None: the range.
    max_growing : GrowingLimit or None
        Where a branch of orbits is given up because many disturbances grow; None: nowhere.
    give_up : callable or None
        Returns True for a point behind which a branch is not followed.
    is_wanted : callable or None
        Returns True for an event at which `modal.continuation.diagram.explore` seeks branches;
        None: at all events.
    """

    lowest: float
    highest: float
    tolerance: float = 1e-5
    first_step: float = 0.02
    max_step: float = 0.1
    min_step: float = 1e-6
    max_points: int = 400
    max_period: float = 50.0
    max_unstable: int | None = None
    max_unstable_at_rest: int | None = None
    max_total_points: int | None = None
    on_point: Callable[[Point], object] | None = None
    newton_tolerance: float = NEWTON_TOLERANCE
    location_tolerance: float = LOCATION_TOLERANCE
    unit: float | None = None
    max_growing: GrowingLimit | None = None
    give_up: Callable[[Point], bool] | None = None
    is_wanted: Callable[[Any], bool] | None = None

    @property
    def at_rest(self) -> Settings:
        """The settings for equilibria."""
        if self.max_unstable_at_rest is None:
            return self
        return replace(self, max_unstable=self.max_unstable_at_rest)

    @property
    def parameter_scale(self) -> float:
        """Parameter change of length 1."""
        return self.highest - self.lowest if self.unit is None else self.unit


@dataclass(frozen=True)
class Point:
    """A solution on a branch.

    Attributes
    ----------
    equations : Equations
        Discretised equations; of an orbit they have the mesh.
    x : ndarray
        States, for an orbit the period, and the parameter.
    tangent : ndarray
        Unit direction of the branch.
    spectrum : ndarray
        Eigenvalues [1/time], or Floquet multipliers without the trivial one.
    trivial_error : float
        Relative error of the trivial multiplier 1: a check of the orbit's accuracy.
    error : float
        Estimated error of the discretisation, relative to the amplitude: that between the nodes,
        or that of the trivial multiplier (relative to the largest multiplier) if it is larger.
    """

    equations: Equations = field(repr=False)
    x: Array = field(repr=False)
    tangent: Array = field(repr=False)
    linear: Linear = field(repr=False)
    iterations: int
    spectrum: NDArray[np.complex128]
    trivial_error: float
    error: float

    @property
    def parameter(self) -> float:
        """The parameter."""
        return float(self.x[-1])

    @property
    def period(self) -> float:
        """Period of an orbit; 0 for an equilibrium."""
        return float(self.x[-2]) if self.equations.kind == "orbit" else 0.0

    @property
    def states(self) -> Array:
        """States at the nodes (node, n); of an equilibrium the one state."""
        return self.equations.states(self.x)

    @property
    def levels(self) -> Array:
        """Growth of the disturbances, descending; positive ones are unstable."""
        return self.equations.levels(self.spectrum)

    @property
    def unstable(self) -> int:
        """Number of growing disturbances."""
        return int(np.sum(self.levels > 0.0))

    @property
    def is_stable(self) -> bool:
        """True if no disturbance grows."""
        return self.unstable == 0

    @property
    def mean(self) -> Array:
        """Mean over the period of each component, shape (n,)."""
        if isinstance(self.equations, OrbitEquations):
            return co.mean(self.equations.mesh, self.states)
        return np.asarray(self.states[0])

    @property
    def extremes(self) -> tuple[Array, Array]:
        """Lowest and highest value of each component, two of shape (n,)."""
        if self.equations.kind == "orbit":
            return co.extremes(self.states)
        return self.states[0], self.states[0]

    @property
    def amplitude(self) -> Array:
        """Half peak-to-peak of each component, shape (n,)."""
        low, high = self.extremes
        return np.asarray(0.5 * (high - low))

    def at(self, phases: Array) -> Array:
        """States (phase, n) at phases, in parts of the period."""
        if isinstance(self.equations, OrbitEquations):
            return self.equations.at(self.x, phases)
        return np.repeat(self.states, len(phases), axis=0)


class Stepper:
    """Steps along a branch.

    Parameters
    ----------
    settings
        Bounds of the continuation.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self._last: tuple[Equations, Linear] | None = None

    def correct(
        self,
        equations: Equations,
        guess: Array,
        base: Array,
        direction: Array,
        distance: float,
        reference: Array | None = None,
        cutoff: float = 0.0,
    ) -> Point:
        """Find the solution at a distance from a base point along a direction.

        Parameters
        ----------
        equations
            Equations on their mesh.
        guess, base, direction : ndarray
            First guess, point x0 and unit direction d of condition (1) of `equations`.
        distance
            s of (1).
        reference : ndarray, optional
            Orbit y_0 of the phase condition; the base by default.
        cutoff
            Relative singular value below which the guess is not corrected in that direction. Near a
            branch point, the direction of the other branch is nearly free, and Newton's method
            diverges in it.

        Raises
        ------
        ContinuationError
            If Newton's method does not converge.
        """
        row, x, last, cheap = equations.dual(direction), guess.copy(), np.inf, 0
        phase = base if reference is None else reference
        for iteration in range(1, NEWTON_ITERATIONS + 1):
            try:
                excess = float(row @ (x - base)) - distance
                linear = equations.linearise(x, phase, row, excess, cutoff)
                self._last = (equations, linear)
            except np.linalg.LinAlgError:
                break
            size = length(equations, linear.change)
            if not np.isfinite(size) or size > MAX_FIRST_CORRECTION or size > 2.0 * last:
                break
            x, last = x + linear.change, size
            if equations.kind == "orbit" and x[-2] <= 0.0:
                break
            if size < self.settings.newton_tolerance * (1.0 + length(equations, x)):
                work = iteration - (-cheap // CHEAP_PER_NEWTON)
                return self._point(equations, x, linear, work)
            if cutoff == 0.0:
                condition = (row, distance + float(row @ base))
                tolerance = self.settings.newton_tolerance
                x, more = improved(equations, x, phase, condition, (linear, size), tolerance)
                cheap += more
        raise ContinuationError(
            f"Newton's method found no {equations.kind} at a parameter near {guess[-1]:.6g}"
        )

    def near(self, equations: Equations, guess: Array, point: Point, distance: float) -> Array:
        """Improve a guess at a distance from a point with the matrix of the last linearisation.

        The guess is good; otherwise it is returned.
        """
        if self._last is None or self._last[0] is not equations:
            return guess
        row = equations.dual(point.tangent)
        place = distance + float(row @ point.x)
        tolerance = self.settings.newton_tolerance
        near = (self._last[1], GOOD)
        return improved(equations, guess, point.x, (row, place), near, tolerance)[0]

    def _point(self, equations: Equations, x: Array, linear: Linear, iterations: int) -> Point:
        tangent = linear.tangent / length(equations, linear.tangent)
        spectrum, trivial_error = equations.spectrum(x, linear)
        largest = float(np.max(np.abs(spectrum), initial=1.0))
        error = max(equations.error(x), trivial_error / largest)
        return Point(equations, x, tangent, linear, iterations, spectrum, trivial_error, error)

    def step(self, point: Point, length_: float, bend: float | None) -> tuple[Point, Point]:
        """Take one step, on a finer mesh if necessary.

        Parameters
        ----------
        point
            Base point.
        length_
            Length s of the step.
        bend
            Curvature of the previous step [1/length]; None: unknown.

        Returns
        -------
        Point, Point
            The base point on the mesh of the new point, and the new point.

        Raises
        ------
        ContinuationError
            If no solution is found, the mesh limit is reached, or the solution may lie on another
            branch.
        """
        while True:
            guess = point.x + length_ * point.tangent
            new = self.correct(point.equations, guess, point.x, point.tangent, length_)
            if new.error <= self.settings.tolerance:
                break
            point = self.remeshed(point, new)
        self._check(point, new, guess, length_, bend)
        return point, new

    def remeshed(
        self, point: Point, errors_of: Point | None = None, is_held: bool = False
    ) -> Point:
        """Compute a point again on a mesh that suits it, or another point nearby.

        With `is_held`, the parameter is kept, otherwise the position along the tangent.

        Raises
        ------
        ContinuationError
            If the error of the other point needs more than `MAX_INTERVALS` intervals.
        """
        source = point if errors_of is None else errors_of
        old = point.equations
        if not isinstance(old, OrbitEquations) or not isinstance(source.equations, OrbitEquations):
            return point
        wanted = co.wanted_intervals(old.intervals, source.error, self.settings.tolerance)
        if errors_of is not None:
            if old.intervals >= co.MAX_INTERVALS:
                raise ContinuationError(
                    f"the orbit at {source.parameter:.6g} is not resolved by {co.MAX_INTERVALS}"
                    f" mesh intervals: estimated error {source.error:.2g}, allowed"
                    f" {self.settings.tolerance:.2g}"
                )
            wanted = max(wanted, old.intervals + 2)
        new = source.equations.remeshed(source.x, min(wanted, co.MAX_INTERVALS))
        if errors_of is None and not is_held and _is_same_mesh(old.mesh, new.mesh):
            return point
        x, tangent = old.transferred(point.x, new), old.transferred(point.tangent, new)
        if is_held:
            tangent = np.zeros_like(x)
            tangent[-1] = 1.0
        return self.correct(new, x, x, tangent / length(new, tangent), 0.0)

    def _check(
        self, point: Point, new: Point, guess: Array, length_: float, bend: float | None
    ) -> None:
        """Raise if the new point may lie on another branch."""
        equations = new.equations
        away = length(equations, new.x - guess) / length_
        angle = angle_between(point, new)
        explained = 0.5 * length_ * (bend if bend is not None else np.inf)
        change = spectrum_change(point.spectrum, new.spectrum)
        if angle > MAX_ANGLE:
            reason = f"the tangent turns by {np.degrees(angle):.0f} degrees"
        elif away > MAX_CORRECTION or away > max(FREE_CORRECTION, MAX_BEND_RATIO * explained):
            reason = f"the solution is {away:.2g} step lengths away from its prediction"
        elif change > MAX_SPECTRUM_CHANGE:
            reason = f"the stability changes by {change:.2g}"
        else:
            return
        raise ContinuationError(
            f"a jump to another branch is not excluded at {new.parameter:.6g}: {reason}"
        )

    def next_length(self, length_: float, angle: float, iterations: int) -> float:
        """Length of the next step: by the angle of the tangents and by Newton's work."""
        growth = TARGET_ANGLE / max(angle, 1e-3 * TARGET_ANGLE)
        if iterations > FEW_ITERATIONS:
            growth = min(growth, 0.5 * (1.0 + FEW_ITERATIONS / iterations))
        return min(length_ * min(max(growth, STEP_SHRINK), STEP_GROWTH), self.settings.max_step)


def _is_same_mesh(one: Array, other: Array) -> bool:
    """True if no end of an interval moves by more than `SAME_MESH` of a mean interval."""
    return len(one) == len(other) and bool(np.max(np.abs(one - other)) < SAME_MESH / (len(one) - 1))


def angle_between(point: Point, new: Point) -> float:
    """Angle [rad] between the tangents of two points on the same mesh."""
    cosine = float(new.equations.dual(point.tangent) @ new.tangent)
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)))


def reversed_point(point: Point) -> Point:
    """Return the same point with the opposite direction of the branch."""
    linear = point.linear._replace(determinant=-point.linear.determinant)
    return replace(point, tangent=-point.tangent, linear=linear)


def spectrum_change(one: NDArray[np.complex128], other: NDArray[np.complex128]) -> float:
    """Largest change of a multiplier (eigenvalue), relative to 1 + its absolute value.

    The values are paired so that the sum of the changes is least. The change is infinite if a value
    is not finite: a motion can grow within one period beyond the range of numbers.
    """
    from scipy.optimize import linear_sum_assignment  # slow to import

    if len(one) == 0:
        return 0.0
    if not (np.all(np.isfinite(one)) and np.all(np.isfinite(other))):
        return float("inf")
    size = 1.0 + np.minimum(np.abs(one)[:, None], np.abs(other)[None, :])
    cost = np.abs(one[:, None] - other[None, :]) / size
    return float(np.max(cost[linear_sum_assignment(cost)]))
