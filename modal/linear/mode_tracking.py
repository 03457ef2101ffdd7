"""Modes followed through a change of the span: by their shape, not by their place in the order of frequencies."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Scene, SceneError
from modal.foundation.scene_variation import unit_of, with_number
from modal.linear.linearise import SmallMotion, WindState
from modal.linear.modes import FAMILIES, Mode, modes_of

if TYPE_CHECKING:
    import xarray as xr
    from scipy.sparse import csc_array

Array = NDArray[np.float64]

SPARE = 4
"""Modes calculated beyond those that are followed, so that one is still found after others have overtaken it."""

ALIKE = 0.8
"""Modal assurance criterion below which two neighbours are too far apart to be called the same mode with certainty."""

HALVINGS = 10
"""Times that an interval between two values is halved to see a shape change from one mode's to another's."""


@dataclass(frozen=True)
class Snapshot:
    """The lowest modes at one value of what is varied, and the mass matrix that weighs their shapes."""

    modes: list[Mode]
    mass: csc_array  # of all unknowns

    @classmethod
    def of(cls, motion: SmallMotion, count: int, speed: float | None = None) -> Snapshot:
        """Modes in still air, or in wind of a speed [m/s]."""
        equations = motion.in_still_air() if speed is None else motion.in_wind(speed)
        return cls(
            modes_of(equations, motion.scene, min(count, int(equations.free.sum()))), equations.mass
        )

    def likeness(self, other: Snapshot) -> Array:
        """Modal assurance criterion of every mode here (row) with every mode there (column), weighted by the mass."""
        here, there = ([_flat(mode) for mode in modes] for modes in (self.modes, other.modes))
        a, b = np.array(here), np.array(there)
        product = np.abs(a.conj() @ (other.mass @ b.T)) ** 2
        size_a = np.einsum("mi,im->m", a.conj(), other.mass @ a.T).real
        size_b = np.einsum("mi,im->m", b.conj(), other.mass @ b.T).real
        return np.asarray(product / np.outer(size_a, size_b))


def track_modes(
    scene: Scene, path: str, values: Sequence[float], count: int = 6, wind: WindState = "still"
) -> xr.Dataset:
    """Follow modes while one number of a scene changes.

    A mode at one value is the one at the next whose shape it resembles most (modal assurance
    criterion, weighted by the mass). Where no shape resembles it well, or two modes change their
    order, the interval is halved, down to a thousandth. Hence two modes that truly cross keep their
    names, and two that veer keep to their sides and exchange their shapes, which the shares show; a
    veering narrower than a thousandth of the interval passes for a crossing.

    Parameters
    ----------
    scene
        The span.
    path
        Dotted path of the number, such as ``"span.horizontal_tension"``, understood as
        `modal.ratio_map` does.
    values
        Its values, in the order in which they are gone through.
    count
        Number of modes followed: the lowest at the first value.
    wind
        ``"still"`` or ``"mean"``; with ``path="wind.speed"`` and ``"mean"`` the modes go with the
        wind.

    Returns
    -------
    xarray.Dataset
        Over ``mode`` and `path`: ``frequency_hz`` [Hz], ``damping_ratio``, ``share`` (also over
        ``family``), and ``likeness``, the lowest assurance on the way from the value before.

    Raises
    ------
    SceneError
        If a value is not allowed, or the modes at one value cannot be calculated.
    """
    import xarray as xr

    if len(values) == 0:
        raise SceneError(f"values of {path}: at least one is needed")

    def at(value: float) -> Snapshot:
        changed = with_number(scene, path, value)
        return Snapshot.of(
            SmallMotion(changed), count + SPARE, changed.wind.mean_speed if wind == "mean" else None
        )

    if wind not in ("still", "mean"):
        raise SceneError(f'wind = {wind!r}: must be "still" or "mean"')
    here = at(values[0])
    chosen = np.arange(min(count, len(here.modes)))
    rows, likeness = [[here.modes[k] for k in chosen]], [np.ones(len(chosen))]
    for before, value in pairwise(values):
        there = at(value)
        chosen, lowest = follow(here, chosen, there, at, before, value)
        rows.append([there.modes[k] for k in chosen])
        likeness.append(lowest)
        here = there
    table = (
        ("mode", path),
        np.array([[mode.frequency_hz for mode in row] for row in rows]).T,
        {"units": "Hz"},
    )
    shares = np.array(
        [[[mode.shares[family] for family in FAMILIES] for mode in row] for row in rows]
    )
    return xr.Dataset(
        {
            "frequency_hz": table,
            "damping_ratio": (
                ("mode", path),
                np.array([[m.damping_ratio for m in row] for row in rows]).T,
            ),
            "share": (("mode", path, "family"), np.swapaxes(shares, 0, 1)),
            "likeness": (("mode", path), np.array(likeness).T),
        },
        coords={
            path: (path, np.asarray(values, dtype=np.float64), {"units": unit_of(scene, path)}),
            "family": list(FAMILIES),
        },
        attrs={"title": scene.title, "wind": wind},
    )


def follow(
    here: Snapshot,
    chosen: NDArray[np.intp],
    there: Snapshot,
    at: Callable[[float], Snapshot],
    low: float,
    high: float,
    halvings: int = HALVINGS,
) -> tuple[NDArray[np.intp], Array]:
    """Where the chosen modes of `here` (at `low`) are among those of `there` (at `high`), and the lowest likeness."""
    from scipy.optimize import linear_sum_assignment

    likeness = here.likeness(there)[chosen]
    _, found = linear_sum_assignment(-likeness)
    alike = likeness[np.arange(len(chosen)), found]
    overtaken = _overtaken([here.modes[k] for k in chosen], [there.modes[k] for k in found])
    if halvings == 0 or (np.all(alike > ALIKE) and not overtaken):
        return found, alike
    middle = 0.5 * (low + high)
    between = at(middle)
    halfway, first = follow(here, chosen, between, at, low, middle, halvings - 1)
    found, second = follow(between, halfway, there, at, middle, high, halvings - 1)
    return found, np.minimum(first, second)


def _overtaken(before: list[Mode], after: list[Mode]) -> bool:
    """Whether any two modes have changed their order: they have crossed, or the step has jumped over a veering."""
    first, last = (np.array([mode.frequency_hz for mode in modes]) for modes in (before, after))
    return bool(np.any((first[:, None] < first) & (last[:, None] > last)))


def _flat(mode: Mode) -> NDArray[np.complex128]:
    return np.asarray((mode.shape + 1j * mode.quadrature).ravel())
