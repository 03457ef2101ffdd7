"""Modes tracked by their shapes over values of a number."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, SceneError
from gallop_fmu.input.scene_like import SpanLike, as_span
from modal.foundation import one_span as instead
from modal.foundation.one_thread import one_thread
from modal.foundation.scene_variation import unit_of, with_number
from modal.linear.line_modes import LineMode, line_modes
from modal.linear.linearise import SmallMotion, WindState
from modal.linear.modes import FAMILIES, Mode, modes_of

if TYPE_CHECKING:
    import xarray as xr
    from scipy.sparse import csc_array

Array = NDArray[np.float64]

EXTRA_MODES = 4
"""Modes computed in addition to the tracked ones, as a tracked mode may move up in the order."""

MIN_MAC = 0.8
"""Modal assurance criterion of two shapes above which they clearly are the same mode."""

MAX_HALVINGS = 10
"""Largest number of halvings of the interval between two values."""


@dataclass(frozen=True)
class Snapshot:
    """The lowest modes at one value of the varied number.

    Attributes
    ----------
    modes : list of Mode or LineMode
        The modes.
    mass : sparse array, shape (4 node, 4 node)
        Mass matrix, which weights the shapes.
    """

    modes: list[Mode] | list[LineMode]
    mass: csc_array

    @classmethod
    def of(cls, motion: SmallMotion, count: int, speed: float | None = None) -> Snapshot:
        """Compute the modes in still air, or in wind of a speed [m/s]."""
        equations = motion.in_still_air() if speed is None else motion.in_wind(speed)
        count = min(count, int(equations.free.sum()))
        if isinstance(motion.scene, LineScene):
            return cls(line_modes(equations, motion.mesh, count), equations.mass)
        return cls(modes_of(equations, motion.scene, count), equations.mass)

    def likeness(self, other: Snapshot) -> Array:
        """Modal assurance criterion of every mode (row) with every mode of `other` (column).

        |a* M b|^2 / ((a* M a) (b* M b))
        """
        a, b = (np.array([_flat(mode) for mode in modes]) for modes in (self.modes, other.modes))
        product = np.abs(a.conj() @ (other.mass @ b.T)) ** 2
        size_a = np.einsum("mi,im->m", a.conj(), other.mass @ a.T).real
        size_b = np.einsum("mi,im->m", b.conj(), other.mass @ b.T).real
        return np.asarray(product / np.outer(size_a, size_b))


@one_thread
def track_modes(
    scene: SpanLike, path: str, values: Sequence[float], count: int = 6, wind: WindState = "still"
) -> xr.Dataset:
    """Track modes over values of one number of a scene.

    A mode at one value is assigned to the mode at the next value with the most similar shape (modal
    assurance criterion, weighted by the mass). Where no shape is similar, or two modes change their
    order, the interval is halved, down to a thousandth. Two modes that cross therefore keep their
    numbers; two that veer keep their order and exchange their shapes, which the shares show. A
    veering narrower than a thousandth of the interval counts as a crossing.

    Parameters
    ----------
    scene
        The span.
    path
        Dotted path of the number, such as ``"span.horizontal_tension"``, as in `modal.ratio_map`.
    values
        Its values, in the order of tracking.
    count
        Number of tracked modes: the lowest at the first value.
    wind
        ``"still"`` or ``"mean"``; ``path="wind.speed"`` with ``"mean"`` tracks modes over the wind.

    Returns
    -------
    xarray.Dataset
        Over ``mode`` and `path`: ``frequency_hz`` [Hz], ``damping_ratio``, ``share`` (also over
        ``family``), and ``likeness``, the lowest assurance criterion since the previous value.

    Raises
    ------
    SceneError
        If a value is not allowed, or the modes at one value cannot be computed.
    """
    import xarray as xr

    scene = as_span(scene, "track_modes", instead.VARIATION)
    if len(values) == 0:
        raise SceneError(f"values of {path}: at least one is needed")

    def at(value: float) -> Snapshot:
        changed = with_number(scene, path, value)
        return Snapshot.of(
            SmallMotion(changed),
            count + EXTRA_MODES,
            changed.wind.mean_speed if wind == "mean" else None,
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
    halvings: int = MAX_HALVINGS,
) -> tuple[NDArray[np.intp], Array]:
    """Find the chosen modes of one snapshot in another one.

    Parameters
    ----------
    here, there
        Snapshots at the values `low` and `high`.
    chosen
        Numbers of the modes in `here`.
    at
        Function from a value to its snapshot.
    low, high
        The two values.
    halvings
        Largest number of halvings of the interval.

    Returns
    -------
    ndarray, ndarray, shape (mode,)
        Numbers of the modes in `there`, and the lowest assurance criterion on the way.
    """
    from scipy.optimize import linear_sum_assignment

    likeness = here.likeness(there)[chosen]
    _, found = linear_sum_assignment(-likeness)
    alike = likeness[np.arange(len(chosen)), found]
    overtaken = _overtaken([here.modes[k] for k in chosen], [there.modes[k] for k in found])
    if halvings == 0 or (np.all(alike > MIN_MAC) and not overtaken):
        return found, alike
    middle = 0.5 * (low + high)
    between = at(middle)
    halfway, first = follow(here, chosen, between, at, low, middle, halvings - 1)
    found, second = follow(between, halfway, there, at, middle, high, halvings - 1)
    return found, np.minimum(first, second)


def _overtaken(before: Sequence[Mode | LineMode], after: Sequence[Mode | LineMode]) -> bool:
    """True if two modes have changed their order, by a crossing or a veering within the step."""
    first, last = (np.array([mode.frequency_hz for mode in modes]) for modes in (before, after))
    return bool(np.any((first[:, None] < first) & (last[:, None] > last)))


def _flat(mode: Mode | LineMode) -> NDArray[np.complex128]:
    """Complex shape of a mode as one vector."""
    return np.asarray((mode.shape + 1j * mode.quadrature).ravel())
