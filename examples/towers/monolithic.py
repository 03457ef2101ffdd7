"""Cable and towers as one system of equations: the reference for the co-simulation.

The ends of the cable, or of a line of several spans, are no unknowns of their own: they move by
the towers' modes, ``u = T y`` with ``y`` the free unknowns of the cable and the modal coordinates.
Virtual work gives ``T' R(T y) + m (q'' + 2 zeta omega q' + omega^2 q) = 0``, with R the forces of
elements and devices that the kernel offers for tests; the forces between cable and towers drop out.
Newmark (beta 1/4, gamma 1/2) and Newton act on all unknowns at once, so there is no communication
step and nothing lags.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, diags_array, hstack
from scipy.sparse.linalg import splu

import gallop_fmu as gf
from gallop_fmu.engine.mesh import Mesh

Array = NDArray[np.float64]
DOFS = 4
BETA, GAMMA = 0.25, 0.5
TOLERANCE = 1e-11
"""Correction [m, rad] at which Newton's iteration ends; what is left after it is smaller still."""


class Monolith:
    """A cable or line between two equal towers.

    Parameters
    ----------
    scene
        The cable, or a line with rigid ends; what it says about its ends is replaced by the towers.
    modes
        Of a tower, by axis x1 and x3: modal mass [kg], frequency [Hz], damping ratio, value of the
        mode at the cable.
    step
        Time step [s].
    """

    def __init__(
        self,
        scene: gf.Scene | gf.LineScene,
        modes: Mapping[str, Sequence[tuple[float, ...]]],
        step: float,
    ) -> None:
        self.model, self.step = gf.Model(scene), step
        self.mesh = Mesh(self.model)
        rows = [(int(axis[1]), *numbers) for axis, of_axis in modes.items() for numbers in of_axis]
        direction, mass, frequency, ratio, shape = (
            np.array(2 * column) for column in zip(*rows, strict=True)
        )
        omega = 2.0 * np.pi * frequency
        self.mass, self.damping, self.stiffness = mass, 2.0 * ratio * omega * mass, omega**2 * mass
        self.free = np.flatnonzero(self.mesh.free)
        self.inner = len(self.free)
        junctions, leader = self.model.junction_nodes()
        self.junctions = junctions
        # A node moves as its leader, which is itself unless several spans end there.
        unknowns = np.arange(DOFS * self.model.nodes).reshape(-1, DOFS)
        follows = unknowns[leader].ravel()
        moves = csc_array(
            (np.ones(len(follows)), (np.arange(len(follows)), follows)), shape=2 * (len(follows),)
        )
        ends = np.repeat([junctions[0], junctions[-1]], len(rows))
        modal = csc_array(
            (shape, (DOFS * ends + direction - 1, np.arange(len(shape)))),
            shape=(len(follows), len(shape)),
        )
        self.T = csc_array(hstack([moves[:, self.free], modal]))
        self._factors: Any = None
        still = np.zeros(self.T.shape[1])
        self.preload = self._forces(still, still, still, inputs=gf.Inputs.still(scene))[
            self.inner :
        ]

    def _forces(self, y: Array, v: Array, a: Array, **options: Any) -> Array:
        """Forces of elements and devices on the unknowns."""
        motion = [(self.T @ part).reshape(-1, DOFS) for part in (y, v, a)]
        forces = self.model.residual(*motion, **options)
        for device, of in enumerate(self.model.devices):
            force, _, _ = self.model.device_force(device, *motion, **options)
            forces[self.junctions[list(of)]] += force
        gathered: Array = self.T.T @ forces.ravel()
        return gathered

    def _residual(self, y: Array, v: Array, a: Array, time: float) -> Array:
        r = self._forces(y, v, a, time=time)
        r[self.inner :] -= self.preload
        q, rate, second = y[self.inner :], v[self.inner :], a[self.inner :]
        r[self.inner :] += self.mass * second + self.damping * rate + self.stiffness * q
        return r

    def _factorise(
        self, y: Array, v: Array, a: Array, time: float, k: float, c: float, m: float
    ) -> None:
        """Factors of k dR/dy + c dR/dv + m dR/da."""
        motion = [(self.T @ part).reshape(-1, DOFS) for part in (y, v, a)]
        whole = self.mesh.tangent(*motion, stiffness=k, damping=c, mass=m, time=time)
        own = k * self.stiffness + c * self.damping + m * self.mass
        towers = diags_array(np.concatenate([np.zeros(self.inner), own]))
        self._factors = splu(csc_array(self.T.T @ whole @ self.T + towers))

    def run(self, stop_time: float, every: int, middle: int | None = None) -> Array:
        """Mid-span u2 and the left tower's x1 [m] every `every` steps, (record, 2).

        `middle` is the node at mid-span of which u2 is meant; None: that of the first span.
        """
        h = self.step
        u2 = DOFS * (self.model.middle if middle is None else middle) + 1
        seed = self.model.start().motion()[0].ravel()
        y = np.concatenate([seed[self.free], np.zeros(len(self.mass))])
        v = np.zeros_like(y)
        self._factorise(y, v, v, 0.0, 0.0, 0.0, 1.0)
        a = -self._factors.solve(self._residual(y, v, np.zeros_like(v), 0.0))
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
                correction = self._factors.solve(-self._residual(y, v, a, n * h))
                y, v, a = y + correction, v + c * correction, a + m * correction
                if np.max(np.abs(correction)) < TOLERANCE:
                    break
                if iteration % 4 == 0:  # the old tangent has become a poor one
                    self._factorise(y, v, a, n * h, 1.0, c, m)
            else:
                raise RuntimeError(f"no convergence at {n * h:.4f} s")
            if n % every == 0:
                records.append(self.T @ y)
        return np.array(records)[:, [u2, DOFS * self.junctions[0]]]
