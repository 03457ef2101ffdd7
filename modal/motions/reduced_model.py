"""An iced span reduced to a few of its mode shapes, with wind and ice, and linear tension forces.

The equations are those of the simulation, written for motions ``u = shapes q`` and many instants at
once. Mass, damping, stiffness and wind load come from the kernel; forces of the rotating ice are
evaluated at the kernel's Gauss points. The forces are those of the kernel up to round-off, but for
the part of the tension that is not linear in q, which `modal.motions.span_model` adds.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Scene, SceneError
from gallop_fmu.engine.mesh import AeroLoad
from gallop_fmu.engine.shape_load import ATTACK, GRAVITY, MOMENTS, ROWS, WIND, ShapeLoad
from modal.linear.mode_basis import StillAirModes
from modal.linear.projection import Projection

Array = NDArray[np.float64]

STATIC_ITERATIONS = 30
"""Most Newton iterations for an equilibrium in the wind."""

STATIC_TOLERANCE = 1e-10
"""Largest last correction of the coordinates, relative to the largest of them or to 1."""

MAX_ASYMMETRY = 1e-9
"""Largest difference of a number at sections that mirror each other, relative to the largest
number, up to which a span is symmetric."""


ALL, SHIFTS, TWIST = slice(0, 3), slice(0, 2), slice(2, 3)
"""Components of load and motion of a section: along n2 and x3, and about the conductor."""


class Forces(NamedTuple):
    """Out-of-balance forces and their derivatives, at each instant.

    Attributes
    ----------
    residual : ndarray, shape (instant, mode)
        Internal + inertia + damping - aerodynamic forces.
    stiffness, damping, mass : ndarray, shape (instant, mode, mode)
        Derivatives by displacement, velocity and acceleration.
    by_wind : ndarray, shape (instant, mode)
        Derivative by the wind speed.
    """

    residual: Array
    stiffness: Array
    damping: Array
    mass: Array
    by_wind: Array


class ReducedModel:
    """The span in the coordinates of a few mode shapes.

    Attributes
    ----------
    shapes : ndarray, shape (mode, node, 4)
        Displacements per unit coordinate; orthonormal in the mass.
    vertical, horizontal : int
        Which of them are the first symmetric vertical and horizontal modes.
    frequencies : tuple of float
        Natural frequency [rad/s] of these two.
    mass, damping, stiffness : ndarray, shape (mode, mode)
        Matrices at the initial equilibrium in still air.
    middle : ndarray, shape (mode, 4)
        The shapes at mid-span.
    """

    def __init__(
        self, scene: Scene, modes: StillAirModes, chosen: list[int], shapes: Array
    ) -> None:
        if scene.aerodynamics is None:
            raise SceneError(
                "aerodynamics is not given: without a coefficient curve no wind can drive the span"
            )
        self.modes, self.scene = modes, scene
        vertical, horizontal = modes.first("vertical"), modes.first("horizontal")
        self.vertical, self.horizontal = chosen.index(vertical), chosen.index(horizontal)
        self.frequencies = (
            float(modes.frequencies[vertical]),
            float(modes.frequencies[horizontal]),
        )
        self.shapes = shapes
        self._projection = Projection(modes.mesh, shapes)
        self.mass, self.damping, self.stiffness = (
            self._projection.matrix(a) for a in (modes.mass, modes.damping, modes.stiffness)
        )
        self.middle = self.shapes[:, modes.model.middle]
        self._prepare_sections()

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.shapes)

    def _prepare_sections(self) -> None:
        """Compute gravity, ice and wind at the sections, and products of the shapes there."""
        sections = self.modes.mesh.sections
        self._gravity = self.scene.span.gravity * sections.normal[:, 1]
        self._first_moments = self.scene.ice.first_moments()
        # Per m/s along n2 and x3; None: along x3 alone, everywhere the same
        self._wind = self.modes.mesh.steady_wind if self.scene.wind.is_varied else None
        if self._is_symmetric():
            self._projection.keep_left_half()
            kept = self._projection.section.shape[2]
            self._gravity = self._gravity[:kept]
            self._wind = None if self._wind is None else self._wind[:, :kept]
        self._prepare_products()

    def _is_symmetric(self) -> bool:
        """True if shapes, ice and wind are the same at sections at equal distances of mid-span."""
        at_sections = [self._projection.section, self.modes.mesh.sections.length, self._gravity]
        if self._wind is not None:
            at_sections.append(self._wind)
        return all(
            float(np.max(np.abs(values - values[..., ::-1])))
            <= MAX_ASYMMETRY * np.max(np.abs(values))
            for values in at_sections
        )

    def _prepare_products(self) -> None:
        """Put the shapes in the order in which slopes at the sections become matrices."""
        self._load = self._shape_load()
        self._rows = np.ascontiguousarray(self._projection.weighted.swapaxes(0, 1))
        self._columns = np.ascontiguousarray(self._projection.section.transpose(2, 0, 1))

    def _shape_load(self) -> ShapeLoad:
        """Nonlinear load on the sections, from the kernel."""
        shape = self._projection.section
        table = np.zeros((ROWS, shape.shape[2]))
        attack, element = self._conductors()
        table[ATTACK], table[GRAVITY] = attack, self._gravity
        table[MOMENTS] = np.array(self._first_moments).reshape(2, -1)
        table[WIND] = np.array([[0.0], [1.0]]) if self._wind is None else self._wind
        model = self._projection.mesh.model
        return ShapeLoad(model, shape, self._projection.weighted, table, element)

    def _conductors(self) -> tuple[float | Array, NDArray[np.intp]]:
        """Attack angle [rad] at the sections, and an element with their conductor and curve."""
        sections = self._projection.section.shape[2]
        return self.modes.mesh.still.attack_angle, np.zeros(sections, dtype=np.intp)

    def forces(self, q: Array, v: Array, a: Array, wind: float | Array) -> Forces:
        """Forces and derivatives at instants, without the quadratic and cubic tension forces.

        Parameters
        ----------
        q, v, a : ndarray, shape (instant, mode)
            Coordinates, velocities and accelerations.
        wind : float or ndarray, shape (instant, 1)
            Wind speed [m/s].
        """
        u, du, ddu = (self._projection.at_sections(y) for y in (q, v, a))
        load, by_u, by_v, by_a = self._ice(u, du, ddu)
        air = self._air(u, du, wind, slopes=True)
        load -= air.force
        assert air.slopes is not None
        by_u -= air.slopes[0]
        by_v -= air.slopes[1:].swapaxes(0, 1)
        return Forces(
            q @ self.stiffness + v @ self.damping + a @ self.mass + self._projection.collect(load),
            self.stiffness + self._product(by_u[:, None], ALL, TWIST),
            self.damping + self._product(by_v, ALL, ALL),
            self.mass + self._by_ice(by_a),
            self._projection.collect(self._by_speed(air.slopes)),
        )

    def unstretched(self, q: Array, v: Array, a: Array, wind: float | Array) -> Array:
        """Residual of `ReducedModel.forces` alone."""
        linear = q @ self.stiffness + v @ self.damping + a @ self.mass
        return np.asarray(linear + self._load(q, v, a, wind))

    def _product(self, slopes: Array, rows: slice, columns: slice) -> Array:
        """Modal matrices (instant, mode, mode) of slopes of the section forces.

        Parameters
        ----------
        slopes : ndarray, shape (row, column, instant, section)
            Derivatives of the load per unit length.
        rows, columns
            Components of the load and of the motion.
        """
        count, n = slopes.shape[2], self.size
        by_section = slopes.transpose(3, 1, 2, 0).reshape(slopes.shape[3], -1, len(slopes))
        weighted = by_section @ self._rows[:, rows]  # (section, column instant, mode)
        flat = weighted.reshape(-1, count * n).T @ self._columns[:, columns].reshape(-1, n)
        return np.asarray(flat.reshape(count, n, n))

    def _by_ice(self, slopes: Array) -> Array:
        """Modal mass matrices of the ice.

        Parameters
        ----------
        slopes : ndarray, shape (2, instant, section)
            Derivatives of f2 and f3 by omega', which are those of M by a2 and a3.
        """
        one = self._product(slopes[:, None], SHIFTS, TWIST)
        return one + one.swapaxes(1, 2)

    def _ice_load(self, u: Array, v: Array, a: Array, moments: tuple[Array, Array]) -> Array:
        """Force per unit length of the rotation of the ice, less its linear part.

        The first moments rotate with the section, c2 = m2 cos theta - m3 sin theta, c3 = m2 sin
        theta + m3 cos theta. Inertia and weight are (Liu et al. 2009, eq. 8 and 17, with the
        centrifugal terms in omega^2, missing there, which conserve energy)

            f2 = -c3 omega' - c2 omega^2,
            f3 = c2 omega' - c3 omega^2,
            M  = c2 a3 - c3 a2 - g2 (c3 - m3).

        Their part linear about u = 0, f2 = -m3 omega', f3 = m2 omega', M = m2 a3 - m3 a2 - g2 m2
        theta, is in the mass and stiffness matrices.

        Parameters
        ----------
        u, v, a : ndarray, shape (3, instant, section)
            Motion of the sections: along n2, along x3, twist.
        moments
            c2 and c3.

        Returns
        -------
        ndarray, shape (3, instant, section)
        """
        m2, m3 = self._first_moments
        c2, c3 = moments
        d2, d3, square = c2 - m2, c3 - m3, v[2] ** 2
        return np.stack(
            [
                -d3 * a[2] - c2 * square,
                d2 * a[2] - c3 * square,
                d2 * a[1] - d3 * a[0] - self._gravity * (d3 - m2 * u[2]),
            ]
        )

    def _moments(self, theta: Array) -> tuple[Array, Array]:
        """First moments [kg] of ice rotated by theta: c2 and c3 of `_ice_load`."""
        m2, m3 = self._first_moments
        sine, cosine = np.sin(theta), np.cos(theta)
        return m2 * cosine - m3 * sine, m2 * sine + m3 * cosine

    def _ice(self, u: Array, v: Array, a: Array) -> tuple[Array, Array, Array, Array]:
        """Force of `_ice_load` and its derivatives, by dc2/dtheta = -c3 and dc3/dtheta = c2.

        Returns
        -------
        tuple of ndarray
            The force (row, instant, section); its derivatives by the twist (row, instant, section),
            by the velocities (row, column, instant, section), and by the accelerations: of f2 and
            f3 by omega', which are those of M by a2 and a3 (2, instant, section).
        """
        m2, m3 = self._first_moments
        c2, c3 = moments = self._moments(u[2])
        omega, rate, square = v[2], a[2], v[2] ** 2
        by_theta = np.stack(
            [
                -c2 * rate + c3 * square,
                -c3 * rate - c2 * square,
                -c3 * a[1] - c2 * a[0] - self._gravity * (c2 - m2),
            ]
        )
        by_velocity = np.zeros((3, *u.shape))
        by_velocity[0, 2] = -2.0 * c2 * omega
        by_velocity[1, 2] = -2.0 * c3 * omega
        return self._ice_load(u, v, a, moments), by_theta, by_velocity, np.stack([m3 - c3, c2 - m2])

    def _air(self, u: Array, v: Array, wind: float | Array, slopes: bool = False) -> AeroLoad:
        """Aerodynamic load on the sections, from the kernel."""
        if self._wind is None:
            return self.modes.mesh.aero_load(u[2], v[0], v[1], v[2], wind, slopes=slopes)
        along, across = wind * self._wind[0], wind * self._wind[1]
        return self.modes.mesh.aero_load(u[2], v[0] - along, v[1], v[2], across, slopes=slopes)

    def _by_speed(self, slopes: Array) -> Array:
        """-dF/dU at the sections: the load depends on the wind less the velocity alone."""
        if self._wind is None:
            return np.asarray(slopes[2])
        return np.asarray(self._wind[0] * slopes[1] + self._wind[1] * slopes[2])

    def angle_excess(self, q: Array, v: Array, wind: float) -> float:
        """Largest excess [rad] of the attack angle beyond the curve's range; 0 inside.

        It is that at which a simulation would end, over all sections and instants.
        """
        u, du = self._projection.at_sections(q), self._projection.at_sections(v)
        return float(np.abs(self._air(u, du, wind).excess).max())


def static_equilibrium(
    model: ReducedModel, wind: float, guess: Array | None = None
) -> tuple[Array, Forces]:
    """Coordinates (1, mode) of an equilibrium in a steady wind, and the forces there.

    Newton's iteration begins at a guess (mode,), or at the equilibrium in still air.

    Raises
    ------
    SceneError
        If Newton's iteration finds none.
    """
    still = np.zeros((1, model.size))
    q = still if guess is None else guess[None, :]
    for _ in range(STATIC_ITERATIONS):
        forces = model.forces(q, still, still, wind)
        change = np.linalg.solve(forces.stiffness[0], -forces.residual[0])
        q = q + change
        if not np.all(np.isfinite(q)):
            break
        if np.max(np.abs(change)) < STATIC_TOLERANCE * max(1.0, float(np.max(np.abs(q)))):
            return q, forces
    raise SceneError(
        f"the span finds no static equilibrium in a wind of {wind:.4g} m/s; lower wind.speed"
    )
