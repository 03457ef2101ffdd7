"""Derivatives of events, motions and their growth by any change of the system.

A small change df of the right-hand side f(y, p) changes a quantity Q of a solution by

    dQ = Re [sum over k of a_k . df(y_k) + b_k . df_y(y_k) c_k],                                 (1)

a sum over the states y_k of the solution: its one state, or those at the Gauss points of an orbit.
A `Gradient` has a, b and c. They do not depend on df, so that one `Gradient` gives the derivatives
by any number of numbers m of the system, with df = (df/dm) dm.

Let F(x; p) = 0 be the equations of the solution, for orbits those of collocation with the phase
condition, and g = dQ/dx. Then dQ = -z . dF with the adjoint z, F_x' z = g.

**Events.** An event is where a level L(x; p) of the solution is zero: the real part of an
eigenvalue (Hopf), the logarithm of an absolute multiplier (period doubling, torus). Its parameter
has the derivative dp = -dL/(dL/dp). At a fold, F_x itself is singular, and its left null vector w
gives dp = -w . dF/(w . F_p).

**Eigenvalues and multipliers.** With B(x, mu) v = 0, w . B = 0 and D = w . (B_mu v),

    dmu = -w . (B_x[dx] + dB) v/D,    w . f_yy[dy] v = dy . (f_yy[v]' w).                        (2)

The second equation needs f_y only in the direction v, where it is a central difference; all other
terms are exact for the discretised equations. For an orbit, B has the linearised equations of
collocation with v(1) = mu v(0). Null vectors are solutions of bordered systems, of which the same
factors give the left and the right one.

References
----------
Kuznetsov, Y. A. (2004). Elements of applied bifurcation theory, 3rd ed., section 10.2.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.polynomial import polynomial
from numpy.typing import NDArray

from modal.continuation import collocation as co
from modal.continuation.equations import OrbitEquations
from modal.continuation.events import Event
from modal.continuation.path import Point
from modal.continuation.problem import ContinuationError, Problem

if TYPE_CHECKING:
    from scipy.sparse.linalg import SuperLU

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

DIRECTION_STEP = 1e-4
"""Step of a difference of the Jacobian in a direction, in typical sizes of the state."""

KINDS = ("Hopf", "rest", "fold", "period doubling", "torus")
"""Kinds of events whose derivatives are known."""

Difference = Iterable[tuple[Problem, float]]
"""Systems with several values of a number, and factors with which they sum up to a derivative by
it: [(less, -1/(2 h)), (more, 1/(2 h))] is the central difference with the step h."""

_ALL_POWERS = np.linalg.inv(np.vander(co.NODES, increasing=True))
"""Coefficients of the Lagrange polynomials: (power, node)."""


@dataclass(frozen=True)
class Gradient:
    """Derivative of a quantity by a change of the right-hand side, equation (1) of the module.

    Attributes
    ----------
    value : float
        The quantity.
    parameter : float
        Parameter p of the solution.
    states : ndarray, shape (state, n)
        States y_k.
    weight : ndarray, shape (state, n)
        a_k.
    left, right : ndarray, shape (state, n)
        b_k and c_k.
    """

    value: float
    parameter: float
    states: Array = field(repr=False)
    weight: Array = field(repr=False)
    left: ComplexArray = field(repr=False)
    right: ComplexArray = field(repr=False)

    def along(self, change: Array, of_jacobian: Array) -> float:
        """Derivative by a change df (state, n) with its Jacobian df_y (state, n, n)."""
        direct = float(np.sum(self.weight * change))
        return direct + float(np.einsum("ka,kab,kb->", self.left, of_jacobian, self.right).real)

    def by_number(self, difference: Difference) -> float:
        """Derivative by a number of the system."""
        change = np.zeros_like(self.states)
        of_jacobian = np.zeros((*self.states.shape, self.states.shape[1]))
        for problem, factor in difference:
            rates = problem.rates(self.states, self.parameter)
            change += factor * rates.value
            of_jacobian += factor * rates.by_state
        return self.along(change, of_jacobian)

    def by_parameter(self, problem: Problem) -> float:
        """Derivative by the parameter p, with f_p as the system gives it."""
        direct = float(
            np.sum(self.weight * problem.rates(self.states, self.parameter).by_parameter)
        )
        moved = _directional(problem, self.states, self.parameter, self.right)[1]
        return direct + float(np.sum(self.left * moved).real)

    def times(self, factor: float) -> Gradient:
        """Gradient of a multiple of the quantity."""
        return replace(
            self, value=factor * self.value, weight=factor * self.weight, left=factor * self.left
        )


def onset(event: Event) -> Gradient:
    """Gradient of the parameter at which an event lies.

    Parameters
    ----------
    event
        An event of one of the `KINDS`.

    Raises
    ------
    ContinuationError
        If it is of another kind.
    """
    if event.kind not in KINDS:
        raise ContinuationError(f"the derivative of a {event.kind} is not known")
    point = event.point
    if event.kind == "fold":
        found = _of_fold(point)
    elif point.equations.kind == "equilibrium":
        found = _of_eigenvalue(point, event.value)
    else:
        found = _Orbit(point).growth_exponent(event.value, 0.0)
    slope = found.by_parameter(point.equations.problem)
    return replace(found.times(-1.0 / slope), value=point.parameter)


def growth(point: Point, number: int = 0) -> Gradient:
    """Gradient of a growth rate [1/time]: the largest one, or the one of another number.

    Of an equilibrium it is the real part of an eigenvalue, of an orbit the logarithm of an absolute
    multiplier over the period. The parameter is constant.
    """
    value = complex(point.spectrum[number])
    if point.equations.kind == "equilibrium":
        return _of_eigenvalue(point, value)
    exponent = float(np.log(np.abs(value)))
    orbit = _Orbit(point)
    found = orbit.growth_exponent(value, -exponent / point.period)
    return replace(found.times(1.0 / point.period), value=exponent / point.period)


def amplitude(point: Point, weights: Array) -> Gradient:
    """Gradient of half the peak-to-peak value of weights . y, at a constant parameter.

    Parameters
    ----------
    point
        A periodic orbit.
    weights : ndarray, shape (n,)
        Weights of the components.
    """
    orbit = _Orbit(point)
    value, by_nodes = _half_range(orbit.equations, point.x, weights)
    return orbit.adjoint(value, by_nodes, 0.0)


def extreme_states(point: Point, weights: Array) -> tuple[Array, Array]:
    """States (n,) of an orbit in which weights . y is least and largest."""
    equations = point.equations
    assert isinstance(equations, OrbitEquations)
    low, high = _extreme_rows(equations, point.x, weights)
    return low @ point.states, high @ point.states


def period(point: Point) -> Gradient:
    """Gradient of the period of an orbit, at a constant parameter."""
    orbit = _Orbit(point)
    return orbit.adjoint(point.period, np.zeros(len(point.x) - 2), 1.0)


def _directional(
    problem: Problem, states: Array, parameter: float, direction: ComplexArray
) -> tuple[ComplexArray, ComplexArray]:
    """Derivatives of f_y (state, n, n) and of f_p (state, n) in a direction (state, n)."""
    by_state = np.zeros((*states.shape, states.shape[1]), dtype=complex)
    by_parameter = np.zeros(states.shape, dtype=complex)
    for unit, part in ((1.0, direction.real), (1.0j, direction.imag)):
        size = float(np.max(np.abs(part / problem.scale)))
        if size == 0.0:
            continue
        step = DIRECTION_STEP / size
        ahead = problem.rates(states + step * part, parameter)
        back = problem.rates(states - step * part, parameter)
        by_state += unit * (ahead.by_state - back.by_state) / (2.0 * step)
        by_parameter += unit * (ahead.by_parameter - back.by_parameter) / (2.0 * step)
    return by_state, by_parameter


def _of_eigenvalue(point: Point, value: complex) -> Gradient:
    """Gradient of the real part of an eigenvalue of an equilibrium."""
    problem = point.equations.problem
    jacobian = problem.rates(point.states, point.parameter).by_state[0]
    values, vectors = np.linalg.eig(jacobian)
    number = int(np.argmin(np.abs(values - value)))
    right = vectors[:, number]
    left = np.linalg.inv(vectors)[number]  # left . right = 1
    bend = _directional(problem, point.states, point.parameter, right[None])[0][0]
    by_state = (bend.T @ left).real
    weight = -np.linalg.solve(jacobian.T, by_state)
    return Gradient(
        float(values[number].real), point.parameter, point.states, weight[None], left[None],
        right[None],
    )  # fmt: skip


def _of_fold(point: Point) -> Gradient:
    """Gradient of a function that is zero at a fold: the left null vector times F."""
    if point.equations.kind == "orbit":
        return _Orbit(point).fold()
    jacobian = point.equations.problem.rates(point.states, point.parameter).by_state[0]
    left = np.linalg.svd(jacobian / point.equations.problem.scale[:, None])[0][:, -1]
    left = left / point.equations.problem.scale
    nothing = np.zeros_like(point.states, dtype=complex)
    return Gradient(0.0, point.parameter, point.states, left[None], nothing, nothing)


class _Orbit:
    """Linearised equations of an orbit at a constant parameter: F_x = [[C, t], [phase, 0]]."""

    def __init__(self, point: Point) -> None:
        equations = point.equations
        assert isinstance(equations, OrbitEquations)
        self.point, self.equations = point, equations
        n, m, count = equations.problem.size, co.DEGREE, equations.intervals
        self.shape = (count, m, n)
        self.length = np.diff(equations.mesh)[:, None, None]
        nodes = co.blocks(equations.states(point.x))
        self.states = np.einsum("ik,jkn->jin", co.VALUE, nodes).reshape(-1, n)
        self.velocity = np.einsum("ik,jkn->jin", co.SLOPE, nodes)
        self.rates = equations.problem.rates(self.states, point.parameter)
        # h T: the residual of an interval is  slope - h T f
        self.time = np.broadcast_to(point.period * self.length, (count, m, 1)).reshape(-1, 1)

    def _collocation(self, multiplier: complex = 1.0) -> Any:
        """Sparse matrix C of the collocation equations, with y(1) = multiplier y(0)."""
        from scipy.sparse import coo_array

        count, m, n = self.shape
        jacobian = (self.time[:, :, None] * self.rates.by_state).reshape(count, m, n, n)
        block = -jacobian[:, :, :, None, :] * co.VALUE[:, None, :, None]
        diagonal = np.arange(n)
        block[:, :, diagonal, :, diagonal] += co.SLOPE  # (interval, gauss, row, node, column)
        values: NDArray[Any] = block.astype(complex) if np.imag(multiplier) else block
        values[-1, :, :, -1] *= multiplier if np.imag(multiplier) else np.real(multiplier)
        rows = np.arange(count * m * n).reshape(count, m, n)
        columns = co.block_index(count)[:, :, None] * n + diagonal
        shape = values.shape
        return coo_array(
            (
                values.ravel(),
                (
                    np.broadcast_to(rows[:, :, :, None, None], shape).ravel(),
                    np.broadcast_to(columns[:, None, None], shape).ravel(),
                ),
            ),
            shape=(count * m * n, count * m * n),
        )

    def _matrix(self) -> Any:
        """Sparse matrix F_x, with the states first and the period last."""
        from scipy.sparse import block_array

        by_period = -(self.length * self.rates.value.reshape(self.shape)).reshape(-1, 1)
        phase = self.spread(self.velocity)
        return block_array(
            [[self._collocation(), by_period], [phase[None] / np.linalg.norm(phase), None]]
        )

    def spread(self, at_gauss: NDArray[Any]) -> NDArray[Any]:
        """Row of nodal weights of a row that weights the values at the Gauss points."""
        return self.equations._spread(at_gauss.reshape(self.shape))

    def adjoint(
        self,
        value: float,
        by_nodes: Array,
        by_period: float,
        left: ComplexArray | None = None,
        right: ComplexArray | None = None,
    ) -> Gradient:
        """Gradient of a quantity with the derivatives by the nodal states and by the period."""
        from scipy.sparse.linalg import splu

        adjoint = splu(self._matrix().tocsc()).solve(np.append(by_nodes, by_period), trans="T")
        nothing = np.zeros_like(self.states, dtype=complex)
        return Gradient(
            value,
            self.point.parameter,
            self.states,
            self.time * adjoint[:-1].reshape(self.states.shape),
            nothing if left is None else left,
            nothing if right is None else right,
        )

    def fold(self) -> Gradient:
        """Left null vector of F_x times the change of F."""
        left = _null_vectors(self._matrix())[0].real
        nothing = np.zeros_like(self.states, dtype=complex)
        weight = self.time * left[:-1].reshape(self.states.shape)
        return Gradient(0.0, self.point.parameter, self.states, weight, nothing, nothing)

    def growth_exponent(self, multiplier: complex, by_period: float) -> Gradient:
        """Gradient of ln|mu|, plus a given derivative by the period."""
        count, m, n = self.shape
        parameter = self.point.parameter
        left, nodes = _null_vectors(self._collocation(multiplier))
        left, nodes = left.reshape(-1, n), nodes.reshape(-1, n)
        values = np.array(co.blocks(nodes.real) + 1j * co.blocks(nodes.imag))
        values[-1, -1] *= multiplier
        right = np.einsum("ik,jkn->jin", co.VALUE, values).reshape(-1, n)
        by_multiplier = co.SLOPE[:, -1, None] * nodes[0]
        by_multiplier = by_multiplier - self.time[-m:] * co.VALUE[:, -1, None] * (
            self.rates.by_state[-m:] @ nodes[0]
        )
        left = left / (np.sum(left[-m:] * by_multiplier) * multiplier)  # now  d ln mu = -w . dB v
        bend = _directional(self.equations.problem, self.states, parameter, right)[0]
        by_gauss = self.time * np.einsum("kab,ka->kb", bend, left).real
        along = np.einsum("ka,kab,kb->k", left, self.rates.by_state, right).real
        by_period += float(along.reshape(count, m).sum(axis=1) @ self.length.ravel())
        return self.adjoint(
            float(np.log(np.abs(multiplier))),
            self.spread(by_gauss),
            by_period,
            self.time * left,
            right,
        )


def _null_vectors(matrix: Any) -> tuple[ComplexArray, ComplexArray]:
    """Left and right null vectors of a singular sparse matrix, from a bordered system.

    The border is random, which makes the bordered matrix regular; a second border of the null
    vectors improves its condition.
    """
    from scipy.sparse import block_array
    from scipy.sparse.linalg import splu

    size = matrix.shape[0]
    left, right = np.random.default_rng(0).standard_normal((2, size))
    unit = np.append(np.zeros(size), 1.0)
    for _ in range(2):
        left, right = left / np.linalg.norm(left), right / np.linalg.norm(right)
        factors: SuperLU = splu(
            block_array([[matrix, left.conj()[:, None]], [right.conj()[None], None]]).tocsc()
        )
        unit = unit.astype(factors.L.dtype)
        left, right = factors.solve(unit, trans="T")[:-1], factors.solve(unit)[:-1]
    return left, right


def _half_range(equations: OrbitEquations, x: Array, weights: Array) -> tuple[float, Array]:
    """Half peak-to-peak value of weights . y, and its derivative by the nodal states."""
    low, high = _extreme_rows(equations, x, weights)
    row = 0.5 * (high - low)
    return float(row @ equations.states(x) @ weights), np.outer(row, weights).ravel()


def _extreme_rows(equations: OrbitEquations, x: Array, weights: Array) -> Sequence[Array]:
    """Weights of the nodes that give the states at the least and the largest value of weights . y.

    In each interval, the extremes of its polynomial are at zeros of the derivative or at the ends.
    """
    values = co.blocks((equations.states(x) @ weights)[:, None])[:, :, 0]
    index = co.block_index(equations.intervals)
    best = [(np.inf, np.zeros(0)), (-np.inf, np.zeros(0))]
    for nodal, nodes in zip(values, index, strict=True):
        coefficients = _ALL_POWERS @ nodal
        zeros = polynomial.polyroots(polynomial.polyder(coefficients))
        inner = zeros.real[(np.abs(zeros.imag) < 1e-9) & (zeros.real > 0.0) & (zeros.real < 1.0)]
        for place in (0.0, 1.0, *inner):
            basis = place ** np.arange(co.DEGREE + 1) @ _ALL_POWERS
            value = float(basis @ nodal)
            for k, is_better in enumerate((value < best[0][0], value > best[1][0])):
                if is_better:
                    row = np.zeros(equations.intervals * co.DEGREE)
                    np.add.at(row, nodes, basis)
                    best[k] = (value, row)
    return [row for _, row in best]
