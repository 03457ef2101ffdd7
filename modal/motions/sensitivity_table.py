"""Sensitivities as a labelled table, and the files of it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from modal.foundation.scene_variation import unit_of

if TYPE_CHECKING:
    import xarray as xr

    from modal.motions.branches import Branches
    from modal.motions.sensitivity import Quantity

Array = NDArray[np.float64]


def sensitivity_table(
    found: Branches,
    quantities: Sequence[Quantity],
    paths: Sequence[str],
    present: Sequence[float],
    values: Array,
) -> xr.Dataset:
    """Return the derivatives as a table; see `modal.motions.sensitivity.Sensitivity`.

    Parameters
    ----------
    found
        The motions.
    quantities, paths, present
        Quantities, numbers and their values.
    values : ndarray, shape (2, quantity, number)
        Derivatives by differences with a step, and with twice the step.
    """
    import xarray as xr

    names = found.dataset["name"].values
    value = np.array([one.gradient.value for one in quantities])
    numbers = np.array(present)
    units = [unit_of(found.scene, path) for path in paths]
    both = ("quantity", "number")
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = values[0] * numbers / value[:, None]
        # the error of a central difference grows with the square of the step
        error = np.abs(values[1] - values[0]) / 3.0 / np.abs(values[0])
    relative[
        :, [unit == "deg" or number == 0.0 for unit, number in zip(units, present, strict=True)]
    ] = np.nan
    return xr.Dataset(
        {
            "derivative": (both, values[0]),
            "relative": (both, relative, {"units": "%/%"}),
            "error": (both, error, {"units": "1"}),
            "value": ("quantity", value),
            "unit": ("quantity", [one.unit for one in quantities]),
            "branch": ("quantity", [one.branch for one in quantities]),
            "motion": ("quantity", [names[one.branch] for one in quantities]),
            "at": ("quantity", [one.at for one in quantities], {"units": found.unit}),
            "is_stable": ("quantity", [one.is_stable for one in quantities]),
            "present": ("number", numbers),
            "number_unit": ("number", units),
        },
        coords={"quantity": [one.name for one in quantities], "number": list(paths)},
        attrs={"title": found.scene.title, "over": found.over, "units": found.unit},
    )
