"""General solvers of ordinary differential equations on the chain: scipy's Radau, SUNDIALS' CVODE.

Right-hand side and analytic Jacobian are compiled by numba; lumped mass; six unknowns a node
interleaved, so that the Jacobian has a band of 11 below and 5 above.  Radau takes it as a sparse
matrix, CVODE as a band.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from cases import Case, NotReachedError
from chain import Chain, chain, compiled, jacobian, right_hand_side
from scenes import LOADED_POINTS, Array, Problem
from scipy.integrate import solve_ivp
from scipy.sparse import csc_matrix
from sksundae.cvode import CVODE

BELOW, ABOVE = 11, 5

TOLERANCES = (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7)
"""Relative; absolute ones [m, m/s] are a hundredth of them, as u2 is about a hundredth of a metre.

Below 1e-7 the round-off of the forces in a stiff chain keeps the solvers from converging."""

CVODE_METHODS: dict[str, tuple[dict[str, Any], tuple[float, ...]]] = {
    "BDF to order 2": ({"method": "BDF", "max_order": 2}, (*TOLERANCES[2:], 1e-8)),
    "BDF to order 5": ({"method": "BDF"}, TOLERANCES[3:]),
    "Adams": ({"method": "Adams"}, TOLERANCES[3:]),
}
"""Above order 2, BDF is unstable on part of the imaginary axis: undamped spans are there."""


class FirstOrder:
    """The chain as y' = f(t, y), with its Jacobian."""

    def __init__(self, problem: Problem, elements: int = LOADED_POINTS + 1) -> None:
        self.chain = span = chain(problem, elements)
        nodes = span.position.shape[1]
        self.size = 6 * (nodes - 2)
        self.middle = 6 * (nodes // 2 - 1)
        self._work = [np.zeros((3, nodes)) for _ in range(3)] + [np.empty((3, nodes - 1))]
        rows, columns = np.empty(39 * nodes, np.int64), np.empty(39 * nodes, np.int64)
        self._values = np.empty(39 * nodes)
        self.none = np.empty(0, np.int64)
        self.count = jacobian(np.zeros(self.size), span, rows, columns, self._values)
        self.rows, self.columns = rows[: self.count], columns[: self.count]
        self._sparse = csc_matrix(
            (np.arange(self.count), (self.rows, self.columns)), (self.size, self.size)
        )
        self._order = self._sparse.data.copy()
        # compiled, or read from the cache, before the clock runs
        self.into(0.0, np.zeros(self.size), np.empty(self.size))
        self.band(np.zeros(self.size), np.zeros((self.size, self.size)))

    def slope(self, time: float, y: Array) -> Array:
        out = np.empty(self.size)
        right_hand_side(time, y, self.chain, out, *self._work)
        return out

    def into(self, time: float, y: Array, out: Array) -> None:
        right_hand_side(time, y, self.chain, out, *self._work)

    def sparse(self, y: Array) -> csc_matrix:
        jacobian(y, self.chain, self.none, self.none, self._values)
        return csc_matrix(
            (self._values[self._order], self._sparse.indices, self._sparse.indptr),
            self._sparse.shape,
        )

    def band(self, y: Array, out: Array) -> None:
        _fill(y, self.chain, self.rows, self.columns, self.none, self._values, out)


@compiled
def _fill(
    y: Array, c: Chain, rows: Array, columns: Array, none: Array, values: Array, out: Array
) -> None:
    jacobian(y, c, none, none, values)
    for k in range(rows.shape[0]):
        out[rows[k], columns[k]] = values[k]


def cases(problem: Problem) -> list[Case]:
    by_radau = [
        Case("Radau", "scipy, Radau", f"tolerance {rtol:g}", ("chain", False), radau(problem, rtol))
        for rtol in TOLERANCES
    ]
    by_cvode = [
        Case(
            "CVODE",
            f"CVODE, {name}",
            f"tolerance {rtol:g}",
            ("chain", False),
            cvode(problem, rtol, options),
        )
        for name, (options, tolerances) in CVODE_METHODS.items()
        for rtol in tolerances
    ]
    return by_radau + by_cvode


def radau(
    problem: Problem, rtol: float, elements: int = LOADED_POINTS + 1
) -> Callable[[], Callable[[], Array]]:
    def prepare() -> Callable[[], Array]:
        system = FirstOrder(problem, elements)

        def advance() -> Array:
            found = solve_ivp(
                system.slope,
                (0.0, problem.stop_time),
                np.zeros(system.size),
                "Radau",
                problem.times,
                rtol=rtol,
                atol=1e-2 * rtol,
                jac=lambda time, y: system.sparse(y),
            )
            if not found.success:
                raise NotReachedError(found.message)
            return found.y[[system.middle + 1, system.middle + 2]].T

        return advance

    return prepare


def cvode(
    problem: Problem, rtol: float, options: dict[str, Any], elements: int = LOADED_POINTS + 1
) -> Callable[[], Callable[[], Array]]:
    def prepare() -> Callable[[], Array]:
        system = FirstOrder(problem, elements)
        solver = CVODE(
            system.into,
            linsolver="band",
            lband=BELOW,
            uband=ABOVE,
            jacfn=lambda time, y, slope, out: system.band(y, out),
            rtol=rtol,
            atol=1e-2 * rtol,
            max_num_steps=10**6,
            **options,
        )

        def advance() -> Array:
            found = solver.solve(np.concatenate([[0.0], problem.times]), np.zeros(system.size))
            if not found.success:
                raise NotReachedError(found.message)
            return found.y[1:, [system.middle + 1, system.middle + 2]]

        return advance

    return prepare
