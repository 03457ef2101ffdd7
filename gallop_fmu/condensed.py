"""The condensed span: a few modes, quasi-static tension, for screening and sweeps."""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass, replace
from importlib.metadata import version
from typing import TYPE_CHECKING, Literal

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.channels import NODE_CHANNELS, SPAN_CHANNELS
from gallop_fmu.engine import Array, Condensed, Inputs, Model, build
from gallop_fmu.errors import SceneError
from gallop_fmu.outcome import Outcome, Report, SimulationError
from gallop_fmu.result import Result
from gallop_fmu.scene import Scene

MESH = 16


@dataclass(frozen=True)
class CondensedSpan:
    model: Model
    frequency: Array
    damping: Array
    shapes: Array   # (mode, node, 4)
    elongation: Array
    stretch: Array
    stiffness: float
    mass: Array
    arrays: dict


def assemble(elements):
    size = 8 * len(elements) + 4
    total = np.zeros((size, size))
    for e, element in enumerate(elements):
        total[8 * e : 8 * e + 12, 8 * e : 8 * e + 12] += element
    return total


def lowest(stiffness, mass, count):
    inverse = np.linalg.inv(np.linalg.cholesky(mass))
    squares, vectors = np.linalg.eigh(inverse @ stiffness @ inverse.T)
    return squares[:count], (inverse.T @ vectors)[:, :count]


def condense(scene, counts=(4, 4, 4), sections=8):
    if scene.numerics.elements > MESH:
        scene = scene.model_copy(update={"numerics": scene.numerics.model_copy(update={"elements": MESH})})
    model = Model(scene)
    eq = model.equilibrium()
    air = Inputs(time=0.0, wind_speed=0.0, attack_angle=0.0, support=np.zeros((2, 3)))
    K, C, M = (assemble(model.tangent(**{k: 1.0}, inputs=air)) for k in ("stiffness", "damping", "mass"))
    n = model.nodes
    free = np.ones((n, 4), bool)
    for end in (0, -1):
        s = eq.support_stiffness[end]
        free[end] = (s[0] > 0, False, s[1] > 0, False)
        i = 0 if end == 0 else 4 * n - 4
        K[i, i] += s[0]
        K[i + 2, i + 2] += s[1]
    free = free.ravel()
    dof = np.arange(4 * n) % 4
    axial = np.flatnonzero(free & (dof == 0))
    kept = np.flatnonzero(free & (dof > 0))
    T = np.zeros((4 * n, len(kept)))
    T[kept, np.arange(len(kept))] = 1.0
    T[axial] = -np.linalg.solve(K[np.ix_(axial, axial)], K[np.ix_(axial, kept)])
    Kc, Cc, Mc = (T.T @ A @ T for A in (K, C, M))
    basis = []
    for d, count in zip((1, 2, 3), counts):
        part = np.flatnonzero(dof[kept] == d)
        _, vec = lowest(Kc[np.ix_(part, part)], Mc[np.ix_(part, part)], count)
        full = np.zeros((len(kept), vec.shape[1]))
        full[part] = vec
        basis.append(full)
    B = np.hstack(basis)
    squares, vec = lowest(B.T @ Kc @ B, B.T @ Mc @ B, B.shape[1])
    flat = (T @ B @ vec)
    damping_matrix = flat.T @ C @ flat
    shapes = flat.T.reshape(-1, n, 4)
    # geometry at stiffness gauss points
    element = 2 * np.arange(model.elements)[:, None] + np.arange(3)
    X = eq.x[element]
    U = shapes[:, element]
    at = np.array([-1, 1]) / np.sqrt(3)
    def slope_rows(at):
        return np.stack([at - 0.5, -2 * at, at + 0.5], axis=-1)
    dX = np.einsum("pn,eni->epi", slope_rows(at), X)
    w = np.linalg.norm(dX, axis=2)
    p0 = dX / w[..., None]
    dU = np.einsum("pn,meni->mepi", slope_rows(at), U) / w[None, :, :, None]
    cosine = p0[..., 0]
    elongation = np.einsum("ep,mep->m", w * p0[..., 1] / cosine, dU[..., 1])
    stretch = np.einsum("ep,mep,kep->mk", w / cosine**3, dU[..., 1], dU[..., 1]) + np.einsum("ep,mep,kep->mk", w / cosine, dU[..., 2], dU[..., 2])
    flexibility = np.sum(w / cosine**2) / scene.conductor.axial_stiffness
    for s in eq.support_stiffness[:, 0]:
        if s > 0:
            flexibility += 1 / s
    # sections
    point, weight = np.polynomial.legendre.leggauss(sections)
    where = 0.5 * (point + 1) * model.elements
    e = np.minimum(where.astype(int), model.elements - 1)
    xi = 2 * (where - e) - 1
    N = np.stack([0.5 * xi * (xi - 1), 1 - xi**2, 0.5 * xi * (xi + 1)], axis=1)
    shape = np.einsum("sn,msni->ims", N, U[:, e])[1:]
    length = np.linalg.norm(np.einsum("sn,sni->si", slope_rows(xi), X[e]), axis=1) * model.elements * weight
    arrays = dict(frequency=np.sqrt(squares), damping=np.diag(damping_matrix).copy(), shape=shape,
                  weighted=np.swapaxes(shape, 1, 2) * length[None, :, None], elongation=elongation, stretch=stretch,
                  coupling=damping_matrix - np.diag(np.diag(damping_matrix)), load=loads(scene, shapes, w))
    stretch_at = np.linalg.norm(np.einsum("sn,sni->si", slope_rows(xi), X[e]), axis=1)
    c_at = np.einsum("sn,sn->s", slope_rows(xi), X[e][:, :, 0]) / stretch_at
    slope = np.einsum("sn,msni->ims", slope_rows(xi), U[:, e])[1:3] / stretch_at
    slope[0] /= c_at
    b2 = eq.translation_damping[1]
    arrays.update(slope=slope, slope_weighted=np.swapaxes(slope, 1, 2) * (b2 * scene.conductor.axial_stiffness * length)[None, :, None])
    arrays_b2 = b2
    kappa = (1 / flexibility) / (scene.conductor.axial_stiffness / np.sum(w / cosine**2))
    span = CondensedSpan(model, np.sqrt(squares), np.diag(damping_matrix), shapes, elongation, stretch, 1 / flexibility, M, arrays)
    arrays['b2']=b2; arrays['kappa']=kappa
    span_extra = dict(C=damping_matrix)
    return span, span_extra


def loads(scene, shapes, w):
    rows = np.zeros((len(scene.loads), len(shapes)))
    cum = np.concatenate([[0], np.cumsum(w.sum(axis=1))])
    for l, load in enumerate(scene.loads):
        frac = [load.position] if load.position is not None else np.arange(1, load.evenly_spaced + 1) / (load.evenly_spaced + 1)
        for f in frac:
            s = f * cum[-1]
            e = min(int(np.searchsorted(cum, s, side="right")) - 1, len(w) - 1)
            xi = 2 * (s - cum[e]) / (cum[e + 1] - cum[e]) - 1
            N = np.array([0.5 * xi * (xi - 1), 1 - xi**2, 0.5 * xi * (xi + 1)])
            at = np.einsum("n,mni->mi", N, shapes[:, 2 * e : 2 * e + 3])
            rows[l] += at @ np.array([*load.force, load.torque])
    return rows
