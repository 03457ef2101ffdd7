"""An iced span in its lowest modes of all families and both symmetries, with condensed stretching.

The motion is u = sum of shape_i q_i + w. The modes i are the lowest natural modes in still air;
w are the quasi-static displacements of all other modes, such as the stretching of the conductor
along itself. The Green strain is l + s with l = X'.u' and s = u'.u'/2 (Liu et al. 2009), and the
tension T0 + EA (l + s), so that the strain energy of third and fourth order is

    V3 = sum of EA l s,    V4 = sum of EA s^2 / 2.                                               (1)

V3 exerts the force C(q, q)/2 on the modes r that are not kept, C being its third derivatives. With
their static answer w_r = -C_r(q, q)/(2 omega_r^2), the energy up to the fourth order is

    V = q K q/2 + C(q, q, q)/6 + sum of EA s^2/2
        - sum over r of (C_r(q, q)/2)^2 / (2 omega_r^2).                                         (2)

The other modes follow without inertia and damping of their own in this; both are added to first
order. With g_r = C_r q/omega_r^2, the velocity w_r' = -g_r.q' dissipates c_r w_r'^2 and has the
kinetic energy w_r'^2/2, so that the forces on the kept modes are

    sum over r of g_r (c_r g_r.q' + g_r.q'' + C_r(q', q')/omega_r^2).                            (3)

Without the damping c_r, which is proportional to the stiffness, example 3 would swing from 5.03 m/s
instead of 5.04 m/s.

(Static condensation is a method of nonlinear vibration theory; Touze, Vizzaccaro and Thomas 2021,
Nonlinear Dyn. 105, 1141-1190, section 4, call it static modal derivatives of all pairs.) Because
the tension is almost uniform along the span, these sums over all modes are sums of few squares of
quadratic forms, which makes them cheap.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Scene, SceneError
from modal.linear.mode_basis import MODES_PER_FAMILY, StillAirModes, choose, mirrored
from modal.linear.modes import FAMILIES, Family, by_family
from modal.linear.wave import half_waves
from modal.motions.reduced_model import ALL, TWIST, Forces, ReducedModel

Array = NDArray[np.float64]

MIN_LIKENESS = 0.7
"""Least likeness of the modes of two scenes between which coordinates are continuous."""

MIN_FORM = 1e-9
"""Square of a quadratic form, relative to the largest, below which it is dropped."""

FIRST_RANK, PROBES, MAX_OUTSIDE = 128, 8, 1e-12
"""First guess of the rank of such a form, number of products that test it, and their largest part
outside."""


class Motion(NamedTuple):
    """Accelerations and their derivatives, at each instant.

    Attributes
    ----------
    acceleration : ndarray, shape (instant, mode)
        Accelerations of the coordinates.
    by_displacement, by_velocity : ndarray, shape (instant, mode, mode)
        Their derivatives.
    by_wind : ndarray, shape (instant, mode)
        Derivative by the wind speed.
    """

    acceleration: Array
    by_displacement: Array
    by_velocity: Array
    by_wind: Array


class Watched(NamedTuple):
    """Displacements at mid-span and elsewhere over time.

    Attributes
    ----------
    u2, u3, theta : ndarray, shape (time, span)
        Vertical and horizontal displacement [m] and twist [rad] at mid-span: of a bundle those of
        its centre, and the mean twist of its conductors.
    quarter : ndarray, shape (time, span)
        Antisymmetric part of the vertical displacement at the quarter points [m].
    clamp : ndarray, shape (time, tower)
        Displacement [m] of the clamps of strings across the line.
    """

    u2: Array
    u3: Array
    theta: Array
    quarter: Array
    clamp: Array


class SpanModel(ReducedModel):
    """The span in the coordinates of its lowest modes.

    Parameters
    ----------
    scene
        The span.
    modes
        Its modes in still air.
    like
        Model of a similar scene. The shapes are the combinations of the modes that are closest to
        its shapes, so that coordinates mean the same in both; None: the modes themselves.
    counts
        Number of modes of each family and symmetry.

    Attributes
    ----------
    chosen : list of int
        Numbers of the modes: the lowest of each family and symmetry.
    is_symmetric : ndarray of bool, shape (mode,)
        True for modes that are symmetric about mid-span.
    family : list of str
        Family of each mode.
    highest_hz : float
        Frequency [Hz] below which all vertical and horizontal modes are kept.

    Raises
    ------
    SceneError
        If the modes are not those of the similar scene.
    """

    _coupling: Array | None = None
    """Products V'M W of shapes and the displacements w that follow, (mode, mode, mode); None: 0, as
    for natural modes."""

    def __init__(
        self,
        scene: Scene,
        modes: StillAirModes,
        like: SpanModel | None = None,
        counts: Mapping[Family, int] = MODES_PER_FAMILY,
    ) -> None:
        self.chosen = choose(modes, (True, False), counts)
        self.is_symmetric = modes.symmetric[self.chosen]
        self.family: list[str] = [modes.family[i] for i in self.chosen]
        shapes = modes.shapes[self.chosen]
        if like is not None:
            shapes = closest(shapes, like.shapes, modes.mass, scene.title)
        super().__init__(scene, modes, self.chosen, shapes)
        self._prepare_stretching()

    @property
    def highest_hz(self) -> float:
        """Frequency [Hz] below which all vertical and horizontal modes are kept."""
        modes = self.modes
        left_out = [
            frequency
            for i, frequency in enumerate(modes.frequencies.tolist())
            if modes.family[i] in ("vertical", "horizontal") and i not in self.chosen
        ]
        return float(min(left_out) / (2.0 * np.pi)) if left_out else float("inf")

    @property
    def elements(self) -> int:
        """Number of elements of a span."""
        return self.modes.model.elements

    @property
    def bundles(self) -> int:
        """Number of conductors or bundles: one."""
        return 1

    def where(self, moves: Watched) -> str:
        """Spans in which a motion is, in words; empty if it is in all."""
        return ""

    @property
    def symmetry(self) -> Array | None:
        """Matrix that turns coordinates into those of the mirror image; None: no symmetry."""
        if not mirrored(self.scene):
            return None
        return np.diag(np.where(self.is_symmetric, 1.0, -1.0))

    @property
    def watched_nodes(self) -> NDArray[np.intp]:
        """Nodes whose motion is watched: at a quarter, at mid-span, at three quarters."""
        middle = self.modes.model.middle
        return np.array([middle // 2, middle, self.shapes.shape[1] - 1 - middle // 2])

    def watched(self, values: Array) -> Watched:
        """Put the motion of `watched_nodes` in order.

        Parameters
        ----------
        values : ndarray, shape (time, 3, node)
            u2, u3 and theta.
        """
        u2, u3, theta = values[:, :, 1].T[:, :, None]
        quarter = 0.5 * (values[:, 0, [0]] - values[:, 0, [2]])
        return Watched(u2, u3, theta, quarter, np.zeros((len(values), 0)))

    def watched_at(self, q: Array) -> Watched:
        """Motion of `watched_nodes` of coordinates (time, mode), linear in them."""
        at = self.shapes[:, self.watched_nodes, 1:]
        return self.watched(np.tensordot(q, at, axes=(1, 0)).swapaxes(1, 2))

    def groups(self) -> list[tuple[str, list[int]]]:
        """Modes that are parts of the same motion, by family and symmetry."""
        found = []
        for family in FAMILIES:
            for symmetric in (True, False):
                alike = [
                    i
                    for i, known in enumerate(self.family)
                    if known == family and self.is_symmetric[i] == symmetric
                ]
                if alike:
                    found.append((str(family), alike))
        return found

    def loops(self, mode: int) -> int:
        """Half-waves of a mode along the span."""
        moved = by_family(self.scene, self.shapes[mode])
        return half_waves(moved[:, [str(one) for one in FAMILIES].index(self.family[mode])])

    def rotated(self, twist: float) -> Array | None:
        """Coordinates in which the conductor is twisted at mid-span [rad]; None: it cannot be."""
        for mode, family in enumerate(self.family):
            if family == "torsional" and self.is_symmetric[mode]:
                q = np.zeros(self.size)
                q[mode] = twist / self.middle[mode, 3]
                return q
        return None

    def _prepare_stretching(self) -> None:
        """Compute the cubic form and the quadratic forms of (2)."""
        points = self.modes.mesh.strain_points
        axial = self.scene.conductor.axial_stiffness * points.length
        n = len(self.chosen)
        others = np.setdiff1d(np.arange(len(self.modes.shapes)), self.chosen)
        every = np.concatenate([self.shapes, self.modes.shapes[others]])
        slope = points.slope(np.moveaxis(every, 0, -1))[:, :3]  # (point, 3, all), the kept first
        pull = np.einsum("gi,gim->gm", points.tangent, slope)
        products = np.einsum("gim,gin->gmn", slope[:, :, :n], slope)
        # third derivatives of V3: C_abr = EA (l_r P_ab + l_a P_br + l_b P_ar)
        pairs = products[:, :, :n]
        third = np.einsum("g,gr,gab->abr", axial, pull, pairs)
        mixed = np.einsum("g,ga,gbr->abr", axial, pull[:, :n], products)
        third += mixed + mixed.swapaxes(0, 1)
        self._cubic = np.ascontiguousarray(third[:, :, :n])
        stretch = np.sqrt(axial)[:, None, None] * pairs  # 2 s: its square is 4 EA s^2
        frequencies = self.modes.frequencies[others]
        relaxed = np.moveaxis(third[:, :, n:] / frequencies, -1, 0)
        self._following = np.einsum("abr,rni->abni", third[:, :, n:] / -(frequencies**2), every[n:])
        self._tension = _few_squares(stretch, relaxed)
        following = np.moveaxis(third[:, :, n:] / frequencies**2, -1, 0)
        damping = self.modes.damping
        flat = every[n:].reshape(len(others), -1)
        of_each = np.maximum(np.einsum("ri,ri->r", flat @ damping, flat), 0.0)
        nothing = np.zeros((0, n, n))
        self._lag = _few_squares(np.sqrt(of_each)[:, None, None] * following, nothing)
        self._inertia = _few_squares(following, nothing)

    def forces(self, q: Array, v: Array, a: Array, wind: float | Array) -> Forces:
        """Add the tension forces of second and third order to those of `ReducedModel.forces`.

        Without inertia and damping of w.
        """
        found = super().forces(q, v, a, wind)
        force, stiffness = self.stretching(q)
        return found._replace(
            residual=found.residual + force, stiffness=found.stiffness + stiffness
        )

    def stretching(self, q: Array) -> tuple[Array, Array]:
        """Force of second and third order of (2), and its derivative.

        Parameters
        ----------
        q : ndarray, shape (instant, mode)
            Coordinates.

        Returns
        -------
        ndarray, ndarray, shape (instant, mode) and (instant, mode, mode)
        """
        count, n = q.shape
        by_cubic = (q @ self._cubic.reshape(n, -1)).reshape(count, n, n)  # C q
        tension = self._tension
        along = tension.times(q)
        weighted = along * tension.signs[:, None]
        square = 0.5 * (along @ q[:, :, None])[:, :, 0] * tension.signs  # q Q_k q/2
        force = 0.5 * (by_cubic @ q[:, :, None])[:, :, 0] + (square[:, None] @ along)[:, 0]
        stiffness = by_cubic + along.transpose(0, 2, 1) @ weighted + tension.summed(square)
        return force, stiffness

    def residual(self, q: Array, v: Array, a: Array, wind: float) -> Array:
        """Out-of-balance forces with inertia and damping of w: zero for the motion of `motion`.

        Parameters
        ----------
        q, v, a : ndarray, shape (instant, mode)
            Coordinates, velocities and accelerations.
        wind
            Wind speed [m/s].
        """
        found = self.unstretched(q, v, a, wind) + self._stretching_force(q)
        damped, moved = self._lag.times(q), self._inertia.times(q)
        rate = (damped @ v[:, :, None])[:, :, 0]
        found += (rate[:, None] @ damped)[:, 0]
        drift = (moved @ a[:, :, None])[:, :, 0]
        drift += (self._inertia.times(v) @ v[:, :, None])[:, :, 0]
        found += (drift[:, None] @ moved)[:, 0]
        if self._coupling is not None:
            of_q, of_v = (np.tensordot(y, self._coupling, axes=(1, 1)) for y in (q, v))
            found += (of_q @ a[:, :, None])[:, :, 0] + (a[:, None] @ of_q)[:, 0]
            found += (of_v @ v[:, :, None])[:, :, 0]
        return found

    def _stretching_force(self, q: Array) -> Array:
        """Return the force of `stretching` alone."""
        count, n = q.shape
        by_cubic = (q @ self._cubic.reshape(n, -1)).reshape(count, n, n)
        along = self._tension.times(q)
        square = 0.5 * (along @ q[:, :, None])[:, :, 0] * self._tension.signs
        force: Array = 0.5 * (by_cubic @ q[:, :, None])[:, :, 0] + (square[:, None] @ along)[:, 0]
        return force

    def nodal(self, q: Array, v: Array) -> tuple[Array, Array]:
        """Displacements and velocities (instant, node, 4) of coordinates, with those of w."""
        count, n = q.shape
        following = (q @ self._following.reshape(n, -1)).reshape(count, n, -1)  # w = this q/2
        flat = self.shapes.reshape(n, -1)
        u = q @ flat + 0.5 * (q[:, None] @ following)[:, 0]
        rates = v @ flat + (v[:, None] @ following)[:, 0]
        shape = (count, *self.shapes.shape[1:])
        return u.reshape(shape), rates.reshape(shape)

    def attack_angle(self, q: Array, v: Array, wind: float) -> Array:
        """Attack angle [rad] at the sections, shape (instant, section)."""
        u, du = self._projection.at_sections(q), self._projection.at_sections(v)
        return self._air(u, du, wind).angle

    def motion(self, q: Array, v: Array, wind: float) -> Motion:
        """Accelerations in a steady wind [m/s] of coordinates and velocities (instant, mode)."""
        u, du = self._projection.at_sections(q), self._projection.at_sections(v)
        air = self._air(u, du, wind, slopes=True)
        assert air.slopes is not None
        moments = self._moments(u[2])
        load = self._ice_load(u, du, np.zeros_like(u), moments) - air.force
        stretching, stiffness = self.stretching(q)
        forces = q @ self.stiffness + v @ self.damping + stretching + self._projection.collect(load)
        lag_by_q, lag_by_v = self._add_lag(q, v, forces)
        m2, m3 = self._first_moments
        turned = np.stack([m3 - moments[1], moments[0] - m2])
        mass = self.mass + self._by_ice(turned)
        following, moving = self._inertia.times(q), self._inertia.times(v)
        square = (moving @ v[:, :, None])[:, :, 0]  # v R_k v
        mass += following.transpose(0, 2, 1) @ following
        forces += (square[:, None] @ following)[:, 0]
        if self._coupling is not None:
            coupled = np.tensordot(q, self._coupling, axes=(1, 1))
            mass += coupled + coupled.transpose(0, 2, 1)
            turned = np.tensordot(v, self._coupling, axes=(1, 1))
            forces += (turned @ v[:, :, None])[:, :, 0]
        inverse = -np.linalg.inv(mass)  # mass is the unit matrix but for ice and w
        acceleration: Array = (inverse @ forces[:, :, None])[:, :, 0]
        drift = (following @ acceleration[:, :, None])[:, :, 0]
        inertia_by_q = self._inertia.summed(drift + square)
        inertia_by_q += following.transpose(0, 2, 1) @ self._inertia.times(acceleration)
        inertia_by_v = 2.0 * following.transpose(0, 2, 1) @ moving
        if self._coupling is not None:
            inertia_by_q += np.tensordot(acceleration, self._coupling, axes=(1, 1))
            inertia_by_q += np.tensordot(acceleration, self._coupling, axes=(1, 0))
            inertia_by_v += 2.0 * turned
        ddu = self._projection.at_sections(acceleration)
        _, by_u, by_v, _ = self._ice(u, du, ddu)
        by_u -= air.slopes[0]
        by_v -= air.slopes[1:].swapaxes(0, 1)
        n = self.size
        right = np.empty((len(q), n, 2 * n + 1))
        right[:, :, :n] = self.stiffness + stiffness
        right[:, :, :n] += self._product(by_u[:, None], ALL, TWIST)
        right[:, :, :n] += lag_by_q + inertia_by_q
        right[:, :, n : 2 * n] = self.damping + self._product(by_v, ALL, ALL)
        right[:, :, n : 2 * n] += lag_by_v + inertia_by_v
        right[:, :, -1] = self._projection.collect(self._by_speed(air.slopes))
        slopes: Array = inverse @ right
        return Motion(acceleration, slopes[:, :, :n], slopes[:, :, n:-1], slopes[:, :, -1])

    def _add_lag(self, q: Array, v: Array, forces: Array) -> tuple[Array, Array]:
        """Add the damping of (3) to forces (instant, mode); return its derivatives by q and v."""
        following, moving = self._lag.times(q), self._lag.times(v)
        rate = (following @ v[:, :, None])[:, :, 0]  # q Q_k v
        forces += (rate[:, None] @ following)[:, 0]
        by_q = self._lag.summed(rate) + following.transpose(0, 2, 1) @ moving
        return by_q, following.transpose(0, 2, 1) @ following


def closest(shapes: Array, like: Array, mass: Any, title: str) -> Array:
    """Orthogonal combinations of shapes (mode, node, 4) that are closest to others.

    With the matrix O of their products in the mass, the combination is V U' for O = U S V', the
    solution of the orthogonal Procrustes problem.
    """
    flat = shapes.reshape(len(shapes), -1)
    left, sizes, right = np.linalg.svd(like.reshape(len(like), -1) @ mass @ flat.T)
    if sizes[-1] < MIN_LIKENESS * sizes[0]:
        raise SceneError(
            f"the lowest modes change too much over the range ({title}): give a smaller range"
        )
    return np.asarray((left @ right @ flat).reshape(shapes.shape))


class _Forms:
    """Symmetric quadratic forms Q_k with signs.

    Parameters
    ----------
    forms : ndarray, shape (form, n, n)
        Q.
    signs : ndarray, shape (form,)
        Their signs.
    """

    def __init__(self, forms: Array, signs: Array) -> None:
        self.signs = signs
        count, n, _ = forms.shape
        self._size = n
        self._wide = np.ascontiguousarray(forms.transpose(1, 0, 2).reshape(n, -1))
        self._flat = forms.reshape(count, n * n)

    def times(self, vectors: Array) -> Array:
        """Products Q_k x of vectors (instant, n), shape (instant, form, n)."""
        return np.asarray((vectors @ self._wide).reshape(len(vectors), -1, self._size))

    def summed(self, weights: Array) -> Array:
        """Weighted sums of the forms with weights (instant, form), shape (instant, n, n)."""
        return np.asarray((weights @ self._flat).reshape(len(weights), self._size, self._size))


def _pairs(n: int) -> tuple[NDArray[np.intp], NDArray[np.intp], Array]:
    """Pairs of indices, and factors with which the norm of a form is that of its pairs."""
    rows, columns = np.triu_indices(n)
    return rows, columns, np.where(rows == columns, 1.0, np.sqrt(2.0))


def _few_squares(added: Array, removed: Array) -> _Forms:
    """Write sum of (q A_g q)^2 - sum of (q B_r q)^2 as a sum of few sign_k (q Q_k q)^2.

    Parameters
    ----------
    added, removed : ndarray, shape (form, n, n)
        A and B.
    """
    n = added.shape[1]
    rows, columns, _ = _pairs(n)
    a, b = (forms[:, rows, columns] for forms in (added, removed))
    return few_squares(a.T @ a - b.T @ b, n)


def few_squares(form: Array, n: int) -> _Forms:
    """Write a quadratic form of the products q_a q_b as a sum of few sign_k (q Q_k q)^2.

    Parameters
    ----------
    form : ndarray, shape (pair, pair)
        The form; pairs a <= b are in the order of `numpy.triu_indices`, and the value of each is
        that of (a, b) and of (b, a). Only its symmetric part counts.
    n
        Number of coordinates.
    """
    rows, columns, double = _pairs(n)
    values, vectors = _eigen(double[:, None] * (0.5 * (form + form.T)) * double)
    kept = np.abs(values) > MIN_FORM * np.max(np.abs(values))
    forms = np.zeros((int(kept.sum()), n, n))
    upper = (vectors[:, kept] * np.sqrt(np.abs(values[kept]))).T / double
    forms[:, rows, columns] = upper
    forms[:, columns, rows] = upper
    return _Forms(forms, np.sign(values[kept]))


def _eigen(form: Array) -> tuple[Array, Array]:
    """Eigenvalues, without those near zero, and eigenvectors of a form with a low rank.

    The rank is that of the strains of the elements, much less than the number of pairs. Products
    with random vectors span the range (Halko, Martinsson, Tropp 2011, algorithm 4.1), if further
    products have no part outside.
    """
    random = np.random.default_rng(0)
    width = FIRST_RANK
    while 2 * width < len(form):
        products = form @ random.standard_normal((len(form), width + PROBES))
        basis = np.linalg.qr(products[:, :width])[0]
        probes = products[:, width:]
        outside = probes - basis @ (basis.T @ probes)
        if np.linalg.norm(outside) <= MAX_OUTSIDE * np.linalg.norm(probes):
            values, vectors = np.linalg.eigh(basis.T @ form @ basis)
            return values, basis @ vectors
        width *= 2
    values, vectors = np.linalg.eigh(form)
    return values, vectors
