"""Floquet multipliers of an orbit by the kind of disturbance: swing, antisymmetric, others."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal.continuation.path import Point
from modal.motions.motion_words import loops_in_words
from modal.motions.span_model import SpanModel

Array = NDArray[np.float64]

TRIVIAL = 1e-2
"""Distance from 1 within which the multiplier closest to 1 is that of a shift in time."""

MIN_SHARE = 0.7
"""Least share of the swing in a disturbance that is called so, relative to the largest share."""


@dataclass(frozen=True)
class Disturbance:
    """A Floquet mode of an orbit.

    Attributes
    ----------
    multiplier : complex
        Factor by which it grows in one period.
    shape : ndarray, shape (2 mode,)
        Its state at the start of the period.
    is_symmetric : bool
        True if it is symmetric about mid-span.
    """

    multiplier: complex
    shape: NDArray[np.complex128]
    is_symmetric: bool


def monodromy(point: Point) -> Array:
    """Matrix by which a small disturbance is multiplied in one period, shape (2 mode, 2 mode).

    The point has its linearised equations: it is an event or a point of `Settings.on_point`.
    """
    condensed = point.linear.matrix
    return np.asarray(-np.linalg.solve(condensed.last, condensed.first))


def disturbances(point: Point, model: SpanModel) -> list[Disturbance]:
    """All Floquet modes of an orbit but the shift in time, the fastest growing first."""
    values, vectors = np.linalg.eig(monodromy(point))
    velocity = point.equations.problem.rates(point.states[:1], point.parameter).value[0]
    scale = point.equations.problem.scale
    alike = np.abs((vectors / scale[:, None]).conj().T @ (velocity / scale))
    alike /= np.linalg.norm(vectors / scale[:, None], axis=0)
    near = np.abs(values - 1.0) < TRIVIAL
    trivial = int(np.argmax(np.where(near, alike, -1.0))) if near.any() else -1
    symmetric = np.tile(model.is_symmetric, 2)
    found = []
    for k in np.argsort(-np.abs(values)):
        if k != trivial:
            share = _share(vectors[:, k], symmetric, scale)
            found.append(Disturbance(complex(values[k]), vectors[:, k], share > 0.5))
    return found


def _share(vector: NDArray[np.complex128], chosen: NDArray[np.bool_], scale: Array) -> float:
    """Share of some coordinates in a state, in squares of typical sizes."""
    squares = np.abs(vector / scale) ** 2
    return float(squares[chosen].sum() / squares.sum())


def swing_multiplier(point: Point, model: SpanModel) -> complex:
    """Largest multiplier of the symmetric disturbances with most of the first horizontal mode.

    There are two of them: a complex pair, or two real ones of different size.
    """
    scale, n = point.equations.problem.scale, model.size
    swing = np.zeros(2 * n, dtype=bool)
    swing[[model.horizontal, n + model.horizontal]] = True
    shares = [
        (_share(one.shape, swing, scale), one.multiplier)
        for one in disturbances(point, model)
        if one.is_symmetric
    ]
    most = max(share for share, _ in shares)
    return max((value for share, value in shares if share > MIN_SHARE * most), key=abs)


def starts_swing(point: Point, model: SpanModel) -> bool:
    """True if the disturbance that changes its sign at a period doubling is symmetric, as a swing.

    Above 2:1 it can have more of the vertical modes than of the horizontal one.
    """
    condensed = point.linear.matrix
    vector = np.linalg.svd(condensed.first - condensed.last)[2][-1]
    symmetric = np.tile(model.is_symmetric, 2)
    return _share(vector.astype(complex), symmetric, point.equations.problem.scale) > 0.5


def antisymmetric_multiplier(point: Point, model: SpanModel) -> float | None:
    """Largest factor of an antisymmetric disturbance in one period; None without such modes."""
    sizes = [abs(one.multiplier) for one in disturbances(point, model) if not one.is_symmetric]
    return max(sizes, default=None)


def name_of_disturbance(one: Disturbance, model: SpanModel) -> str:
    """Name of a Floquet mode: family and loops of its strongest coordinate."""
    n = model.size
    energy = np.abs(one.shape[n:]) ** 2  # the shapes are orthonormal in the mass
    strongest = int(np.argmax(energy))
    family = model.family[strongest]
    words = loops_in_words(model.loops(strongest))
    if family == "horizontal" and model.is_symmetric[strongest] and words == "one loop":
        return "swing"
    name = {"horizontal": "swing", "torsional": "twist"}.get(family, "vertical motion")
    return f"{name} in {words}"
