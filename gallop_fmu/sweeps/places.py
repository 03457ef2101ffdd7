"""Columns of spans and towers: one for each place in a row, one array for all places in a dataset.

The column ``span_u2_amplitude`` of a dataset, over ``run`` and ``span``, is ``span_2_u2_amplitude``
in the row of a run and in a Parquet file; of several phases ``span_2_phase_1_u2_amplitude``.
"""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Collection
from functools import lru_cache
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    import xarray as xr

KINDS = ("span", "tower")
"""Kinds of places, and dimensions of a dataset."""
PHASE = "phase"
_FLAT = re.compile(rf"({'|'.join(KINDS)})_(\d{{1,6}})_(?:{PHASE}_(\d{{1,6}})_)?(.+)")


class Place(NamedTuple):
    """A span or tower of a line, and its phase if there are several.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    number : int
        Number of the span, from 1, or of the tower, from 0.
    phase : int or None
        Number of the phase, from 1; None if there is one.
    """

    kind: str
    number: int
    phase: int | None = None

    def name_of(self, column: str) -> str:
        """Name in a row of a column such as ``span_u2_amplitude``."""
        phase = "" if self.phase is None else f"{PHASE}_{self.phase}_"
        return f"{self.kind}_{self.number}_{phase}{column.removeprefix(f'{self.kind}_')}"

    def __str__(self) -> str:
        phase = "" if self.phase is None else f", phase {self.phase}"
        return f"{self.kind} {self.number}{phase}"


@lru_cache(maxsize=65536)  # many rows have the same columns
def placed(name: str) -> tuple[str, Place | None]:
    """Return the column of a dataset to which a column of a row belongs, and its place."""
    found = _FLAT.fullmatch(name)
    if not found:
        return name, None
    kind, number, phase, quantity = found.groups()
    return f"{kind}_{quantity}", Place(kind, int(number), int(phase) if phase else None)


def stacked(flat: xr.Dataset, columns: Collection[str]) -> xr.Dataset:
    """Return a dataset with one array for the columns of all places.

    Parameters
    ----------
    flat
        Dataset over ``run`` with the columns of rows.
    columns
        Columns over places that it can have; other columns stay as they are.
    """
    found: dict[str, _Arrays] = {}
    for name, variable in flat.data_vars.items():
        column, place = placed(str(name))
        if place is not None and column in columns:
            found.setdefault(column, {})[place] = variable.values
    if not found:
        return flat
    axes = _axes([place for arrays in found.values() for place in arrays])
    rest = flat.drop_vars([name for name in flat.data_vars if placed(str(name))[0] in found])
    variables = {column: _joined(arrays, axes) for column, arrays in found.items()}
    return rest.assign(variables).assign_coords(axes)


_Arrays = dict[Place, NDArray[Any]]
"""Arrays of a column by place."""


def _axes(places: Collection[Place]) -> dict[str, list[int]]:
    """Return the numbers along each dimension."""
    axes = {}
    for kind in KINDS:
        if numbers := {place.number for place in places if place.kind == kind}:
            axes[kind] = sorted(numbers)
    if any(place.phase is not None for place in places):
        axes[PHASE] = sorted({place.phase or 1 for place in places})
    return axes


def _joined(arrays: _Arrays, axes: dict[str, list[int]]) -> tuple[tuple[str, ...], NDArray[Any]]:
    """Return the dimensions and the array of a column; missing places are NaN or ``""``."""
    first, values = next(iter(arrays.items()))
    dimensions = (first.kind, PHASE) if PHASE in axes else (first.kind,)
    is_text = any(each.dtype == object for each in arrays.values())
    missing: Any = "" if is_text else math.nan
    whole = np.full(
        (*(len(axes[dimension]) for dimension in dimensions), len(values)),
        missing,
        dtype=object if is_text else np.float64,
    )
    for place, values in arrays.items():
        at = zip(dimensions, (place.number, place.phase or 1), strict=False)
        if values.dtype == object or not is_text:  # otherwise all are missing
            whole[tuple(axes[dimension].index(number) for dimension, number in at)] = values
    return ("run", *dimensions), np.moveaxis(whole, -1, 0)


def flattened(dataset: xr.Dataset) -> xr.Dataset:
    """Return the dataset with one column over ``run`` for each place; the inverse of `stacked`."""
    import xarray as xr

    flat: dict[str, Any] = {}
    for name, variable in dataset.data_vars.items():
        if variable.dims == ("run",):
            flat[str(name)] = variable
            continue
        _, kind, *phase = variable.dims
        axes = [dataset[dimension].values.tolist() for dimension in (kind, *phase)]
        columns = variable.values.reshape(len(variable), math.prod(variable.shape[1:])).T
        for numbers, values in zip(itertools.product(*axes), columns, strict=True):
            place = Place(str(kind), *numbers)
            about = dict(variable.attrs)
            if "long_name" in about:
                about["long_name"] = f"{place}: {about['long_name']}"
            flat[place.name_of(str(name))] = ("run", values, about)
    return xr.Dataset(flat, attrs=dataset.attrs)
