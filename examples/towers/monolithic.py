"""Cable and towers as one system of equations: the reference for the co-simulation.

The ends of the cable are no unknowns of their own: they move by the towers' modes, ``u = T y`` with
``y`` the inner unknowns of the cable and the modal coordinates. Virtual work gives ``T' R(T y) + m
(q'' + 2 zeta omega q' + omega^2 q) = 0``, with R the residual that the kernel offers for tests; the
forces between cable and towers drop out. Newmark (beta 1/4, gamma 1/2) and Newton act on all
unknowns at once, so there is no communication step and nothing lags.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lu_factor, lu_solve

import gallop_fmu as gf

Array = NDArray[np.float64]
DOFS = 4
BETA, GAMMA = 0.25, 0.5
TOLERANCE = 1e-11
"""Correction [m, rad] at which Newton's iteration ends; what is left after it is smaller still."""


class Monolith:
    """A cable between two equal towers.

    Parameters
    ----------
    scene
        The cable; what it says about supports is replaced by the towers.
    modes
        Of a tower, by axis x1 and x3: modal mass [kg], frequency [Hz], damping ratio, value of the
        mode at the cable.
    step
        Time step [s].
    """

    def __init__(
        self, scene: gf.Scene, modes: Mapping[str, Sequence[tuple[float, ...]]], step: float
    ) -> None:
        self.model, self.step = gf.Model(scene), step
        unknowns, inner = DOFS * self.model.nodes, DOFS * (self.model.nodes - 2)
        rows = [(int(axis[1]), *numbers) for axis, of_axis in modes.items() for numbers in of_axis]
        direction, mass, frequency, ratio, shape = (
            np.array(2 * column) for column in zip(*rows, strict=True)
        )
        omega = 2.0 * np.pi * frequency
        self.mass, self.damping, self.stiffness = mass, 2.0 * ratio * omega * mass, omega**2 * mass
        self.inner = inner
        self.T = np.zeros((unknowns, inner + len(shape)))
        self.T[DOFS : DOFS + inner, :inner] = np.eye(inner)
        for k, (along, value) in enumerate(zip(direction, shape, strict=True)):
            end = 0 if k < len(rows) else unknowns - DOFS
            self.T[end + along - 1, inner + k] = value
        self._factors: Any = None

    def _residual(self, y: Array, v: Array, a: Array, time: float) -> Array:
        r: Array = (
            self.T.T @ self.model.residual(self.T @ y, self.T @ v, self.T @ a, time=time).ravel()
        )
        q, rate, second = y[self.inner :], v[self.inner :], a[self.inner :]
        r[self.inner :] += self.mass * second + self.damping * rate + self.stiffness * q
        return r

    def _factorise(
        self, y: Array, v: Array, a: Array, time: float, k: float, c: float, m: float
    ) -> None:
        """Factors of k dR/dy + c dR/dv + m dR/da."""
        motion = self.T @ y, self.T @ v, self.T @ a
        blocks = self.model.tangent(*motion, stiffness=k, damping=c, mass=m, time=time)
        whole = np.zeros((len(self.T), len(self.T)))
        for element, block in enumerate(blocks):
            at = slice(2 * DOFS * element, 2 * DOFS * element + 3 * DOFS)
            whole[at, at] += block
        matrix = self.T.T @ whole @ self.T
        matrix[self.inner :, self.inner :] += np.diag(
            k * self.stiffness + c * self.damping + m * self.mass
        )
        self._factors = lu_factor(matrix)

    def run(self, stop_time: float, every: int) -> Array:
        """Mid-span u2 and the left tower's x1 [m] every `every` steps, (record, 2)."""
        h, middle = self.step, DOFS * self.model.middle
        seed = self.model.start().motion()[0].ravel()
        y, v = np.linalg.lstsq(self.T, seed, rcond=None)[0], np.zeros(self.T.shape[1])
        self._factorise(y, v, v, 0.0, 0.0, 0.0, 1.0)
        a = -lu_solve(self._factors, self._residual(y, v, np.zeros_like(v), 0.0))
        c, m = GAMMA / (BETA * h), 1.0 / (BETA * h * h)
        self._factorise(y, v, a, 0.0, 1.0, c, m)
        before, records = a, [self.T @ y]
        for n in range(1, round(stop_time / h) + 1):
            guess = 2.0 * a - before
            before = a
            y = y + h * v + h * h * ((0.5 - BETA) * a + BETA * guess)
            v = v + h * ((1.0 - GAMMA) * a + GAMMA * guess)
            a = guess
            for iteration in range(1, 31):
                correction = lu_solve(self._factors, -self._residual(y, v, a, n * h))
                y, v, a = y + correction, v + c * correction, a + m * correction
                if np.max(np.abs(correction)) < TOLERANCE:
                    break
                if iteration % 4 == 0:  # the old tangent has become a poor one
                    self._factorise(y, v, a, n * h, 1.0, c, m)
            else:
                raise RuntimeError(f"no convergence at {n * h:.4f} s")
            if n % every == 0:
                records.append(self.T @ y)
        return np.array(records)[:, [middle + 1, 0]]
