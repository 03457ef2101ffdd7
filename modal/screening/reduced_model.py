"""An iced span reduced to a few of its mode shapes, nonlinear and with the wind on it.

The equations are those of the simulation, written for motions ``u = shapes q`` and many instants at
once: linear mass, damping and stiffness come from the kernel; the quadratic and cubic tension
forces follow from the strain ``X'.u' + u'.u'/2`` at the kernel's Gauss points, and wind and turning
ice are read at its sections. On such motions the forces are the kernel's to the last digits.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Scene, SceneError
from modal.foundation.shape_functions import GAUSS2, Sections, nodes_of, slope
from modal.linear.mode_basis import Rest, choose, mirrored, with_stretching

Array = NDArray[np.float64]

STATIC_ITERATIONS = 30
"""Newton iterations within which an equilibrium in the wind must be found."""


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
    """

    def __init__(self, scene: Scene, rest: Rest, chosen: list[int], shapes: Array) -> None:
        if scene.aerodynamics is None:
            raise SceneError(
                "aerodynamics is not given: without a coefficient curve no wind can drive the span"
            )
        self.rest, self.scene = rest, scene
        vertical, horizontal = rest.first("vertical"), rest.first("horizontal")
        self.vertical, self.horizontal = chosen.index(vertical), chosen.index(horizontal)
        self.frequencies = (float(rest.frequencies[vertical]), float(rest.frequencies[horizontal]))
        self.shapes = shapes
        flat = self.shapes.reshape(len(self.shapes), -1)
        self.mass, self.damping, self.stiffness = (
            flat @ a @ flat.T for a in (rest.mass, rest.damping, rest.stiffness)
        )
        self.middle = self.shapes[:, rest.model.middle]
        self._geometry()
        curve = scene.aerodynamics.curve()
        self._curve = curve
        self._radius = scene.aerodynamics.reference_radius or 0.5 * scene.conductor.diameter
        self._attack = np.radians(scene.ice.attack_angle_deg)

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.shapes)

    def _geometry(self) -> None:
        x = self.rest.model.equilibrium().x
        element = nodes_of(self.rest.model.elements)
        nodes, moves = x[element], self.shapes[:, element]  # (e, 3, 3), (mode, e, 3, 4)
        by_xi = slope(GAUSS2)
        stretch = np.linalg.norm(np.einsum("pn,eni->epi", by_xi, nodes), axis=2)
        by_s = by_xi[None] / stretch[:, :, None]
        tangent = np.einsum("epn,eni->epi", by_s, nodes).reshape(-1, 3)
        self._slope = np.einsum("epn,meni->epim", by_s, moves)[:, :, :3].reshape(-1, 3, self.size)
        self._pull = np.einsum("gi,gim->gm", tangent, self._slope)
        self._axial = self.scene.conductor.axial_stiffness * stretch.ravel()
        self._pairs = np.einsum("gim,gin->gmn", self._slope, self._slope)
        sections = Sections.of(x)
        section = sections.motion(np.moveaxis(self.shapes, 0, -1))
        self._gravity = self.scene.span.gravity * sections.normal[:, 1]
        self._section = section.transpose(0, 2, 1).copy()  # (component, mode, section)
        self._weighted = section * sections.length[:, None]
        products = np.einsum("ipm,jpn->ijpmn", self._weighted, section)
        self._by_all = products.reshape(9, -1)
        self._by_twist = products[:, 2].copy()
        across = products[[0, 1], 2]
        self._by_ice = across + products[2, [0, 1]]

    def forces(self, q: Array, v: Array, a: Array, wind: float | Array) -> Forces:
        """Forces and derivatives at instants whose coordinates, velocities and accelerations are (instant, mode)."""
        u, du, ddu = (
            y @ self._section for y in (q, v, a)
        )  # (component, instant, section): along n2, x3, theta
        load, by_u, by_v, by_a, by_wind = self._sections(u, du, ddu, wind)
        stretching, stiffness = self.stretching(q)
        return Forces(
            q @ self.stiffness
            + v @ self.damping
            + a @ self.mass
            + stretching
            + self._projected(load),
            self.stiffness + stiffness + self._product(by_u, self._by_twist),
            self.damping + self._product(by_v, self._by_all),
            self.mass + self._product(by_a, self._by_ice),
            self._projected(by_wind),
        )

    def unstretched(self, q: Array, v: Array, a: Array, wind: float | Array) -> Array:
        """The residual of `forces` without the quadratic and cubic tension forces."""
        u, du, ddu = (y @ self._section for y in (q, v, a))
        load = self._sections(u, du, ddu, wind, slopes=False)[0]
        return np.asarray(
            q @ self.stiffness + v @ self.damping + a @ self.mass + self._projected(load)
        )

    def _projected(self, load: Array) -> Array:
        """Modal forces (instant, mode) of loads per unit length (component, instant, section)."""
        return np.asarray(np.einsum("itm->tm", load @ self._weighted))

    def _product(self, slopes: Array, products: Array) -> Array:
        """Modal matrices of slopes (entry, instant, section), whose shape products are (entry, section, mode mode)."""
        flat = np.moveaxis(slopes, 0, 1).reshape(slopes.shape[1], -1) @ products.reshape(
            -1, self.size**2
        )
        return np.asarray(flat.reshape(-1, self.size, self.size))

    def stretching(self, q: Array) -> tuple[Array, Array]:
        """Quadratic and cubic part of the internal force and its derivative."""
        count, size = q.shape
        along = (q @ self._pairs.reshape(-1, size).T).reshape(count, -1, size)  # u'.shape'
        linear = q @ self._pull.T  # X'.u'
        square = 0.5 * (along @ q[:, :, None])[:, :, 0]
        stress = self._axial * (linear + square)
        force = (self._axial * square) @ self._pull + (stress[:, None] @ along)[:, 0]
        weighted = along * self._axial[:, None]
        mixed = self._pull.T @ weighted
        stiffness = mixed + mixed.transpose(0, 2, 1) + along.transpose(0, 2, 1) @ weighted
        stiffness += (stress @ self._pairs.reshape(len(self._pull), -1)).reshape(count, size, size)
        return force, stiffness

    def _sections(
        self, u: Array, v: Array, a: Array, wind: float | Array, slopes: bool = True
    ) -> tuple[Array, ...]:
        """Turning ice minus aerodynamics per unit length (row, instant, section), and its derivatives.

        By the twist (row, ...), by the velocities (row and column, ...), by the accelerations: the
        factors of twist in u2 and u3, which are those of u2 and u3 in twist (2, ...), and by the
        wind speed (row, ...).
        """
        m2, m3 = self.scene.ice.first_moments()
        gravity = self._gravity
        theta, omega, rate, a2, a3 = u[2], v[2], a[2], a[0], a[1]
        sine, cosine = np.sin(theta), np.cos(theta)
        c2, c3 = m2 * cosine - m3 * sine, m2 * sine + m3 * cosine
        d2, d3, square = c2 - m2, c3 - m3, omega**2
        load = np.stack(
            [
                -d3 * rate - c2 * square,
                d2 * rate - c3 * square,
                d2 * a3 - d3 * a2 - gravity * (d3 - m2 * theta),
            ]
        )
        if not slopes:
            return (load - self._aerodynamics(theta, v[0], v[1], omega, wind, slopes)[0],)
        wind_load, slope = self._aerodynamics(theta, v[0], v[1], omega, wind)
        load -= wind_load
        by_u = -slope[:, 0]
        by_u += np.stack(
            [
                -c2 * rate + c3 * square,
                -c3 * rate - c2 * square,
                -c3 * a3 - c2 * a2 - gravity * (c2 - m2),
            ]
        )
        by_v = -np.stack(
            [slope[:, 1], slope[:, 2], self._radius * slope[:, 1]], axis=1
        )  # (row, column, ...)
        by_v[0, 2] -= 2.0 * c2 * omega
        by_v[1, 2] -= 2.0 * c3 * omega
        by_a = np.stack([-d3, d2])
        return (
            load,
            by_u,
            by_v.reshape(9, *theta.shape),
            by_a,
            slope[:, 2],
        )  # the wind enters as U - v3

    def _aerodynamics(
        self,
        theta: Array,
        v2: Array,
        v3: Array,
        omega: Array,
        wind: float | Array,
        slopes: bool = True,
    ) -> tuple[Array, Array]:
        """F2, F3, M per unit length, and their derivatives (row, by theta v2 v3, instant, section)."""
        scene, curve = self.scene, self._curve
        d = scene.conductor.diameter
        k = 0.5 * scene.wind.air_density * d
        w2, w3 = -v2 - self._radius * omega, wind - v3
        square = w2**2 + w3**2
        ur = np.sqrt(square)
        first, last = curve.breakpoint[0], curve.breakpoint[-1]
        alpha = reduced_angle(self._attack + theta + np.arctan2(w2, w3), first, last)
        held = np.clip(alpha, first, last)
        if len(curve.coefficient) == 1:
            s, c = held - curve.origin[0], curve.coefficient[0]
        else:
            piece = np.clip(
                np.searchsorted(curve.breakpoint, held, side="right") - 1,
                0,
                len(curve.coefficient) - 1,
            )
            s, c = (
                held - curve.origin[piece],
                np.moveaxis(curve.coefficient[piece], (-2, -1), (0, 1)),
            )
        cl, cd, cm = (c[i, 0] + s * (c[i, 1] + s * (c[i, 2] + s * c[i, 3])) for i in range(3))
        load = np.stack(
            [k * ur * (cl * w3 + cd * w2), k * ur * (cd * w3 - cl * w2), k * d * square * cm]
        )
        if not slopes:
            return load, load
        inside = alpha == held
        sl, sd, sm = (
            inside * (c[i, 1] + s * (2.0 * c[i, 2] + 3.0 * s * c[i, 3])) for i in range(3)
        )
        a2, a3 = cl * w3 + cd * w2, cd * w3 - cl * w2
        s2, s3 = sl * w3 + sd * w2, sd * w3 - sl * w2
        per = 1.0 / np.maximum(ur, 1e-300)
        w2_per, w3_per = w2 * per, w3 * per
        by_theta = [k * ur * s2, k * ur * s3, k * d * square * sm]
        by_v2 = [
            -k * (w2_per * a2 + ur * cd + s2 * w3_per),
            -k * (w2_per * a3 - ur * cl + s3 * w3_per),
            -k * d * (2.0 * w2 * cm + sm * w3),
        ]
        by_v3 = [
            -k * (w3_per * a2 + ur * cl - s2 * w2_per),
            -k * (w3_per * a3 + ur * cd - s3 * w2_per),
            -k * d * (2.0 * w3 * cm - sm * w2),
        ]
        slope = np.array([by_theta, by_v2, by_v3]).swapaxes(0, 1)
        return load, slope

    def angle_excess(self, q: Array, v: Array, wind: float) -> float:
        """How far [rad] the attack angle leaves the curve's range at any section and instant; 0 inside."""
        theta, (v2, v3, omega) = q @ self._section[2], v @ self._section
        first, last = self._curve.breakpoint[0], self._curve.breakpoint[-1]
        alpha = reduced_angle(
            self._attack + theta + np.arctan2(-v2 - self._radius * omega, wind - v3), first, last
        )
        return max(0.0, float(np.max(alpha - last)), float(np.max(first - alpha)))


def reduced_angle(alpha: Array, first: float, last: float) -> Array:
    """Attack angles [rad] moved by whole turns into the turn centred on the curve's range."""
    return np.asarray(
        alpha - 2.0 * np.pi * np.round((alpha - 0.5 * (first + last)) / (2.0 * np.pi))
    )


@dataclass(frozen=True)
class MeanState:
    """Static equilibrium in a steady wind, and the small vertical motion about it.

    Attributes
    ----------
    displacement : ndarray, shape (mode,)
        Coordinates of the equilibrium.
    vertical : complex
        Growth rate and angular frequency [1/s] of the first vertical mode in the wind.
    shape : ndarray, shape (mode,)
        Its complex shape.
    """

    displacement: Array
    vertical: complex
    shape: NDArray[np.complex128]


def mean_state(model: ReducedModel, wind: float) -> MeanState:
    """Equilibrium of a reduced span in a steady wind.

    Raises
    ------
    SceneError
        If there is none, it is not stable (divergence), or the attack angle there lies outside the
        curve's range.
    """
    n = model.size
    q, still = np.zeros((1, n)), np.zeros((1, n))
    for _ in range(STATIC_ITERATIONS):
        forces = model.forces(q, still, still, wind)
        change = np.linalg.solve(forces.stiffness[0], -forces.residual[0])
        q = q + change
        if np.max(np.abs(change)) < 1e-10 * max(1.0, float(np.max(np.abs(q)))):
            break
    else:
        raise SceneError(
            f"the span finds no static equilibrium in a wind of {wind:.4g} m/s; lower wind.speed"
        )
    stiffness, damping, mass = forces.stiffness[0], forces.damping[0], forces.mass[0]
    curve = model.scene.aerodynamics
    if curve is not None and curve.beyond == "error" and model.angle_excess(q, still, wind) > 0.0:
        first, last = curve.range_deg
        raise SceneError(
            f"in a wind of {wind:.4g} m/s the span is turned out of the coefficient curve, which is"
            f" valid from {first:g} to {last:g} deg; lower wind.speed or give a longer curve"
        )
    inverse = np.linalg.inv(mass)
    rates, vectors = np.linalg.eig(
        np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ stiffness, -inverse @ damping]])
    )
    if np.any((np.abs(rates.imag) < 1e-9) & (rates.real > 0.0)):
        raise SceneError(
            f"the span is statically unstable in a wind of {wind:.4g} m/s (divergence); lower"
            " wind.speed"
        )
    moving = np.flatnonzero(rates.imag > 0.0)
    size = np.abs(vectors[:n, moving]) ** 2
    best = moving[int(np.argmax(size[model.vertical] / size.sum(axis=0)))]
    return MeanState(q[0], complex(rates[best]), vectors[:n, best])


def reduced_model(scene: Scene, rest: Rest) -> ReducedModel:
    """The lowest modes of each family and the stretching that the first symmetric pair sets up.

    Only the symmetric ones of a span with mirror symmetry: from symmetric motions no force leads to
    others.
    """
    chosen = choose(rest, (True,) if mirrored(scene) else (True, False))
    return ReducedModel(scene, rest, chosen, with_stretching(rest, chosen))


def with_antisymmetric_modes(model: ReducedModel) -> ReducedModel:
    """The antisymmetric modes of a span with mirror symmetry added behind the symmetric ones of its model."""
    chosen = choose(model.rest, (False,))
    shapes = np.concatenate([model.shapes, with_stretching(model.rest, chosen)])
    return ReducedModel(model.scene, model.rest, choose(model.rest, (True,)), shapes)
