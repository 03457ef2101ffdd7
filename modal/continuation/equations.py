"""The equations that are followed: equilibria f(y, p) = 0 and periodic orbits y' = T f(y, p).

Both have unknowns x (states, for orbits the period T, and last the parameter p), one equation less
than unknowns, and a condition that fixes the position along the branch,

    <d, x - x0> = s,                                                                             (1)

with the scalar product of two changes of x

    <a, b> = mean over the period of sum over i of a_i b_i / scale_i^2
             + a_T b_T / T_scale^2 + a_p b_p / p_scale^2.                                        (2)

Orbits have the phase condition  mean of <y - y_0, y_0'> = 0  with a nearby orbit y_0 (Doedel 1981).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from modal.continuation import collocation as co
from modal.continuation.condensation import Condensed, solve_regularised
from modal.continuation.elimination import Factors, eliminate, eliminate_second_order
from modal.continuation.problem import Problem

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

MIN_MULTIPLIER = 1e-16
"""Lower bound of a multiplier whose logarithm is taken."""

GRID = np.arange(64) / 64.0
"""Phases of a period at which orbits are compared with their mirror images."""


class Linear(NamedTuple):
    """Linearised equations at x.

    Attributes
    ----------
    change : ndarray
        Newton's correction.
    tangent : ndarray
        Direction of the branch: solution for a unit right-hand side of condition (1).
    determinant : float
        Sign of the determinant with condition (1) as the last row.
    matrix : object
        What `Equations.spectrum` and `Equations.null_vector` need.
    """

    change: Array
    tangent: Array
    determinant: float
    matrix: Any


class Equations(Protocol):
    """Discretised equations of a kind of solution; see the module."""

    @property
    def kind(self) -> str:
        """Either "equilibrium" or "orbit"."""

    @property
    def problem(self) -> Problem:
        """The system."""

    def dual(self, change: Array) -> Array:
        """Row r with r @ b = <change, b>."""

    def linearise(
        self, x: Array, base: Array, row: Array, excess: float, cutoff: float = 0.0
    ) -> Linear:
        """Linearise at x, with the row of condition (1) and its residual; base is y_0.

        With a cutoff, nothing moves in the direction of a smaller singular value.
        """

    def correction(
        self, x: Array, base: Array, row: Array, excess: float, near: Linear
    ) -> Array | None:
        """Correction with the matrix of a linearisation nearby; None: no cheaper than Newton's."""

    def spectrum(self, x: Array, linear: Linear) -> tuple[ComplexArray, float]:
        """Eigenvalues or multipliers that decide on stability, and the error of the trivial one."""

    def levels(self, spectrum: ComplexArray) -> Array:
        """Growth of each: positive if unstable."""

    def null_vector(self, linear: Linear) -> Array:
        """Direction in which the linearised equations with (1) are singular."""

    def states(self, x: Array) -> Array:
        """States at the nodes: (node, n)."""

    def error(self, x: Array) -> float:
        """Estimated error of the discretisation, relative to the size of the motion."""

    def breaks_symmetry(self, x: Array, change: Array) -> bool:
        """True if x has the symmetry of the problem, and a change of it does not."""


@dataclass(frozen=True)
class EquilibriumEquations:
    """Equations of equilibria: x = (y, p).

    Attributes
    ----------
    problem : Problem
        The system.
    parameter_scale : float
        p_scale of (2).
    """

    problem: Problem
    parameter_scale: float
    kind: str = field(default="equilibrium", init=False)

    def dual(self, change: Array) -> Array:
        """Row of the scalar product."""
        return np.asarray(change / np.append(self.problem.scale, self.parameter_scale) ** 2)

    def linearise(
        self, x: Array, base: Array, row: Array, excess: float, cutoff: float = 0.0
    ) -> Linear:
        """Linearise f(y, p) = 0 and condition (1)."""
        rates = self.problem.rates(x[None, :-1], float(x[-1]))
        matrix = np.vstack([np.hstack([rates.by_state[0], rates.by_parameter.T]), row])
        right = np.zeros((len(x), 2))
        right[:-1, 0], right[-1] = -rates.value[0], (-excess, 1.0)
        found = solve_regularised(matrix, right, cutoff)
        sign = float(np.linalg.slogdet(matrix)[0])
        return Linear(found[:, 0], found[:, 1], sign, matrix)

    def correction(
        self, x: Array, base: Array, row: Array, excess: float, near: Linear
    ) -> Array | None:
        """Return None: one state is linearised fast."""
        return None

    def spectrum(self, x: Array, linear: Linear) -> tuple[ComplexArray, float]:
        """Eigenvalues [1/time] of the Jacobian, the fastest growing first."""
        values = np.linalg.eigvals(linear.matrix[:-1, :-1]).astype(complex)
        return values[np.argsort(-values.real, kind="stable")], 0.0

    def levels(self, spectrum: ComplexArray) -> Array:
        """Real parts."""
        return np.asarray(spectrum.real)

    def null_vector(self, linear: Linear) -> Array:
        """Right singular vector of the least singular value."""
        scale = np.append(self.problem.scale, self.parameter_scale)
        return np.asarray(np.linalg.svd(linear.matrix * scale)[2][-1] * scale)

    def states(self, x: Array) -> Array:
        """Return the one state."""
        return x[None, :-1]

    def error(self, x: Array) -> float:
        """Return 0: nothing is discretised."""
        return 0.0

    def breaks_symmetry(self, x: Array, change: Array) -> bool:
        """Compare the state and the change with their mirror images."""
        mirror = self.problem.symmetry
        if mirror is None:
            return False
        return _is_alike(x[:-1], mirror @ x[:-1], self.problem.scale) and _is_alike(
            change[:-1], -mirror @ change[:-1], self.problem.scale
        )


@dataclass(frozen=True)
class OrbitEquations:
    """Equations of periodic orbits by orthogonal collocation: x = (nodal states, T, p).

    Attributes
    ----------
    problem : Problem
        The system.
    parameter_scale, period_scale : float
        p_scale and T_scale of (2).
    mesh : ndarray, shape (interval + 1,)
        Ends of the intervals in scaled time 0..1.
    """

    problem: Problem
    parameter_scale: float
    period_scale: float
    mesh: Array = field(repr=False)
    kind: str = field(default="orbit", init=False)

    @property
    def intervals(self) -> int:
        """Number of intervals."""
        return len(self.mesh) - 1

    def states(self, x: Array) -> Array:
        """Nodal states (node, n), without the end of the period."""
        return np.asarray(x[:-2].reshape(-1, self.problem.size))

    def _spread(self, weighted: Array) -> Array:
        """Row of nodal weights of a row that weights the values at the Gauss points."""
        local = np.einsum("ik,jin->jkn", co.VALUE, weighted)
        row = np.zeros((self.intervals, co.DEGREE, self.problem.size))
        row += local[:, :-1]
        row[:, 0] += np.roll(local[:, -1], 1, axis=0)
        return row.ravel()

    def _dual_states(self, at_gauss: Array) -> Array:
        """Nodal weights of the mean product with a function at the Gauss points."""
        weights = np.diff(self.mesh)[:, None] * co.WEIGHTS
        return self._spread(weights[:, :, None] * at_gauss / self.problem.scale**2)

    def dual(self, change: Array) -> Array:
        """Row of the scalar product."""
        at_gauss = np.einsum("ik,jkn->jin", co.VALUE, co.blocks(self.states(change)))
        scales = np.array([self.period_scale, self.parameter_scale]) ** 2
        return np.concatenate([self._dual_states(at_gauss), change[-2:] / scales])

    def linearise(
        self, x: Array, base: Array, row: Array, excess: float, cutoff: float = 0.0
    ) -> Linear:
        """Linearise the collocation equations, the phase condition and condition (1)."""
        n, m, count = self.problem.size, co.DEGREE, self.intervals
        by_interval = co.blocks(self.states(x))
        value = np.einsum("ik,jkn->jin", co.VALUE, by_interval)
        slope = np.einsum("ik,jkn->jin", co.SLOPE, by_interval)
        period, parameter = float(x[-2]), float(x[-1])
        rates = self.problem.rates(value.reshape(-1, n), parameter)
        h = np.diff(self.mesh)[:, None, None]
        f = rates.value.reshape(count, m, n)
        columns = np.empty((count, m, n, 3))
        columns[..., 0] = -h * f
        columns[..., 1] = -h * period * rates.by_parameter.reshape(count, m, n)
        columns[..., 2] = h * period * f - slope
        jacobian, time = rates.by_state.reshape(count, m, n, n), period * h.ravel()
        nodes: Factors | None = None
        if self.problem.is_second_order:
            solved, nodes = eliminate_second_order(jacobian, time, columns)
        else:
            solved = eliminate(jacobian, time, columns)
        condensed = Condensed(solved, *self._borders(x, base, row, excess), nodes)
        change, tangent = condensed.solve(cutoff)
        sign = np.linalg.slogdet(condensed.final)[0] * np.linalg.slogdet(condensed.last)[0]
        return Linear(change, tangent, float(sign), condensed)

    def _borders(self, x: Array, base: Array, row: Array, excess: float) -> tuple[Array, Array]:
        """Rows of the phase condition and of condition (1), and their last columns."""
        h = np.diff(self.mesh)[:, None, None]
        slope = np.einsum("ik,jkn->jin", co.SLOPE, co.blocks(self.states(base)))
        phase = self._dual_states(slope / h)
        phase /= max(float(np.linalg.norm(phase)), np.finfo(float).tiny)
        offset = float(phase @ (x - base)[:-2])
        rows = np.stack([phase, row[:-2]]).reshape(2, self.intervals, -1)
        return rows, np.array([[0.0, 0.0, -offset], [*row[-2:], -excess]])

    def correction(
        self, x: Array, base: Array, row: Array, excess: float, near: Linear
    ) -> Array | None:
        """Correction with the matrix of a linearisation nearby."""
        by_interval = co.blocks(self.states(x))
        value = np.einsum("ik,jkn->jin", co.VALUE, by_interval)
        slope = np.einsum("ik,jkn->jin", co.SLOPE, by_interval)
        time, n = np.diff(self.mesh)[:, None, None] * x[-2], self.problem.size
        slopes = (slope / time).reshape(-1, n)
        defect = self.problem.defect(value.reshape(-1, n), slopes, float(x[-1]))
        if defect is None:
            return None
        condensed: Condensed = near.matrix
        column = time * defect.reshape(slope.shape)
        return condensed.correction(column, *self._borders(x, base, row, excess))

    def spectrum(self, x: Array, linear: Linear) -> tuple[ComplexArray, float]:
        """Floquet multipliers without the trivial one, the largest first.

        The velocity v = f(y_0) is the eigenvector of the trivial multiplier 1. Orthogonal
        transformations whose first columns are parallel to v and to B v deflate it from the pencil
        (A, B). The first element of the pencil is the trivial multiplier.
        """
        from scipy.linalg import eigvals  # slow to import

        a, b = linear.matrix.first, linear.matrix.last
        v = self.problem.rates(self.states(x)[:1], float(x[-1])).value[0]
        moved = b @ v
        error = abs(float(moved @ (a @ v) / (moved @ moved)) + 1.0)
        right = np.linalg.qr(v[:, None], mode="complete")[0]
        left = np.linalg.qr(moved[:, None], mode="complete")[0]
        rest = (left.T @ np.stack([-a, b]) @ right)[:, 1:, 1:]
        values = eigvals(rest[0], rest[1]).astype(complex)
        return values[np.argsort(-np.abs(values), kind="stable")], error

    def levels(self, spectrum: ComplexArray) -> Array:
        """Logarithms of the absolute multipliers."""
        return np.asarray(np.log(np.maximum(np.abs(spectrum), MIN_MULTIPLIER)))

    def null_vector(self, linear: Linear) -> Array:
        """Direction of a branch that meets this one."""
        condensed: Condensed = linear.matrix
        return condensed.null_vector()

    def error(self, x: Array) -> float:
        """Largest estimated error between the nodes, relative to the largest amplitude."""
        return float(np.max(self._relative_errors(x)))

    def _relative_errors(self, x: Array) -> Array:
        states = self.states(x) / self.problem.scale
        amplitude = 0.5 * float(np.max(np.ptp(states, axis=0)))
        errors = np.max(co.interval_errors(self.mesh, states), axis=1)
        return np.asarray(errors / max(amplitude, np.finfo(float).tiny))

    def remeshed(self, x: Array, intervals: int) -> OrbitEquations:
        """Equations on a mesh of so many intervals with equal errors."""
        mesh = co.equidistributed(self.mesh, self._relative_errors(x), intervals)
        return OrbitEquations(self.problem, self.parameter_scale, self.period_scale, mesh)

    def transferred(self, x: Array, to: OrbitEquations) -> Array:
        """Write unknowns, or a change of them, on another mesh."""
        nodes = self.at(x, co.node_times(to.mesh))
        return np.concatenate([nodes.ravel(), x[-2:]])

    def at(self, x: Array, phases: Array) -> Array:
        """States (phase, n) at phases, in parts of the period."""
        return co.evaluate(self.mesh, self.states(x), phases)

    def breaks_symmetry(self, x: Array, change: Array) -> bool:
        """Compare orbit and change with their mirror images, also those half a period later."""
        mirror, scale = self.problem.symmetry, self.problem.scale
        if mirror is None:
            return False
        orbit, moved = self.at(x, GRID), self.at(change, GRID)
        for shift in (0, len(GRID) // 2):
            image = np.roll(orbit, shift, axis=0) @ mirror.T
            if _is_alike(orbit, image, scale):
                return _is_alike(moved, -np.roll(moved, shift, axis=0) @ mirror.T, scale)
        return False


def length(equations: Equations, change: Array) -> float:
    """Length of a change of x."""
    return float(np.sqrt(max(float(equations.dual(change) @ change), 0.0)))


ALIKE, NEARLY, SMALL = 1e-3, 0.02, 1e-6
"""Relative difference below which two motions are the same, that for motions whose mesh is coarse,
and the least size to which both refer."""


def _is_alike(one: Array, other: Array, scale: Array) -> bool:
    """True if two motions agree within `NEARLY` of their size (of `scale`, if they are small)."""
    size = max(float(np.max(np.abs(one / scale))), SMALL)
    return float(np.max(np.abs((one - other) / scale))) <= NEARLY * size
