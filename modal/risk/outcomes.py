"""What the runs of an atlas found in each span: galloping or not, and its amplitude."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
Method = Literal["estimate", "simulate"]
METHODS = ("estimate", "simulate")

LASTING = ("steady", "beating", "irregular", "random")
"""Motions whose amplitude in the window is that of galloping."""
CEASING = ("at rest", "decaying")
"""Motions without galloping."""

MIN_AMPLITUDE = 0.05
"""Minimum vertical amplitude [m] of a simulated motion that counts as galloping."""

COMPLETED = "completed"


@dataclass(frozen=True)
class Found:
    """Outcome of all draws of a span.

    Attributes
    ----------
    gallops : (draws,) array
        1 or 0; NaN where this is not known.
    amplitude : (draws,) array
        Vertical amplitude [m], half peak-to-peak; 0 without galloping, NaN where it is not known,
        infinite where it is beyond the range of the estimate.
    swings : (draws,) array
        1 where the horizontal swing of the 2:1 resonance starts, else 0; NaN where not known.
    reasons : dict
        Reason to number of draws that are not resolved.
    """

    gallops: Array
    amplitude: Array
    swings: Array
    reasons: dict[str, int]


def found_by_estimate(rows: xr.Dataset) -> Found:
    """Read the rows of `modal.screen_spans` with ``estimate_only``."""
    completed = rows.outcome.values == COMPLETED
    amplitude = np.nan_to_num(rows.estimated_vertical.values, nan=0.0, posinf=np.inf)
    threshold = rows.estimated_threshold.values
    swings = np.where(np.isnan(threshold), False, amplitude > np.nan_to_num(threshold, nan=np.inf))
    return Found(
        gallops=np.where(completed, (amplitude > 0.0).astype(float), np.nan),
        amplitude=np.where(completed, amplitude, np.nan),
        swings=np.where(completed, swings.astype(float), np.nan),
        reasons=_counted(rows.message.values[~completed]),
    )


def found_by_simulation(rows: xr.Dataset, span: int | None = None) -> Found:
    """Read the rows of `gallop_fmu.sweep`; of a line those of a span, from 1."""

    def column(name: str) -> Any:
        whole = rows[name if span is None else f"span_{name}"]
        if span is not None:
            whole = whole.sel(span=span)
            if "phase" in whole.dims:  # the phase that moves most
                whole = whole.max("phase") if whole.dtype.kind == "f" else whole.isel(phase=0)
        return whole.values

    motion = np.array([str(text).partition(" (")[0] for text in column("motion")])
    vertical, horizontal = column("u2_amplitude"), column("u3_amplitude")
    completed = rows.outcome.values == COMPLETED
    small = np.nan_to_num(vertical, nan=np.inf) < MIN_AMPLITUDE
    none = completed & (np.isin(motion, CEASING) | (np.isin(motion, LASTING) & small))
    lasts = completed & np.isin(motion, LASTING) & ~small
    grows = completed & (motion == "still growing")
    amplitude = np.where(lasts, vertical, np.where(none, 0.0, np.nan))
    ratio = column("u3_frequency_hz") / column("u2_frequency_hz")
    half = (horizontal > MIN_AMPLITUDE) & (np.abs(ratio - 0.5) < 0.1)
    reasons = [
        str(message) if not is_complete else f"motion {kind}"
        for message, is_complete, kind, is_known in zip(
            rows.message.values, completed, motion, lasts | none, strict=True
        )
        if not is_known
    ]
    return Found(
        gallops=np.where(lasts | grows, 1.0, np.where(none, 0.0, np.nan)),
        amplitude=amplitude,
        swings=np.where(lasts, half.astype(float), np.where(none, 0.0, np.nan)),
        reasons=_counted(reasons),
    )


def _counted(reasons: Any) -> dict[str, int]:
    """Number of each reason, the most frequent first; numbers in a reason do not distinguish."""
    import re

    groups: dict[str, tuple[str, int]] = {}
    for reason in map(str, reasons):
        key = re.sub(r"[\d.+-]+", "", reason)
        first, number = groups.get(key, (reason, 0))
        groups[key] = first, number + 1
    return dict(sorted(groups.values(), key=lambda each: -each[1]))
