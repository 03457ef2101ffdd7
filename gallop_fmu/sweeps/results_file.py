"""The file of results of a sweep: rows as a labelled dataset, in Parquet or NetCDF."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.foundation.atomic_write import check_target, netcdf_bytes, write_whole
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.sweeps.places import flattened, stacked
from gallop_fmu.sweeps.rows import FORMAT, TEXT_COLUMNS, Header, Row, finite_or_none, is_header

if TYPE_CHECKING:
    import xarray as xr

HEADER = "gallop_fmu"
"""Attribute of a dataset and of its file that holds the header as JSON."""
SUFFIXES = (".parquet", ".nc")
TYPES = (bool, int, float, object)
"""Types of values in a column; the first that fits counts."""


def as_dataset(rows: list[Row], header: Header) -> xr.Dataset:
    """Return one array per column over the dimension ``run``; missing values are NaN or ``""``.

    Columns of spans and towers are arrays over ``run`` and ``span`` or ``tower``, see
    `gallop_fmu.sweeps.places`. Without rows, the dataset has the columns of the header.
    """
    import xarray as xr

    columns = dict.fromkeys(("run", *(key for row in rows for key in row)))
    if not rows:
        columns = dict.fromkeys(("run", *header["grid"], *header["columns"]))
    variables = {
        name: ("run", _array([row.get(name) for row in rows], name in TEXT_COLUMNS))
        for name in columns
    }
    return _described(xr.Dataset(variables, attrs={HEADER: json.dumps(header)}), header)


def _described(flat: xr.Dataset, header: Header) -> xr.Dataset:
    """Return a dataset over places, with the units and meanings of the header."""
    dataset = stacked(flat, header["columns"])
    for name, (unit, meaning) in header["columns"].items():
        if name in dataset:
            dataset[name].attrs = {"long_name": meaning, **({"units": unit} if unit else {})}
    return dataset


def rows_of(dataset: xr.Dataset) -> list[Row]:
    """Return the rows of a dataset of `as_dataset`."""
    flat = flattened(dataset)
    columns = {str(name): values.values.tolist() for name, values in flat.variables.items()}
    return [
        {name: finite_or_none(values[k]) for name, values in columns.items()}
        for k in range(dataset.sizes["run"])
    ]


def _array(values: list[Any], is_text: bool) -> NDArray[Any]:
    """Return the array of a column, of the type of its values.

    Truth values and whole numbers are kept if none is missing. A column that mixes truth values
    with numbers is text.
    """
    kinds = {kind for kind in map(_type, values) if kind is not None}
    is_complete = bool(values) and None not in values
    if is_text or not (kinds <= {int, float} or kinds == {bool}):
        return np.array(["" if value is None else str(value) for value in values], dtype=object)
    if is_complete and kinds in ({bool}, {int}):
        return np.array(values, dtype=np.bool_ if kinds == {bool} else np.int64)
    return np.array([math.nan if value is None else value for value in values], np.float64)


def _type(value: Any) -> type | None:
    """Return the first type of `TYPES` that a value has; None for a missing value."""
    return None if value is None else next(kind for kind in TYPES if isinstance(value, kind))


def check_results_file(path: Path) -> None:
    """Refuse a file of results that cannot be written, before a long run.

    Raises
    ------
    SceneError
        See `check_suffix` and `gallop_fmu.foundation.atomic_write.check_target`.
    """
    check_suffix(path)
    check_target(path)


def check_suffix(path: Path) -> None:
    """Refuse a name whose suffix is not one of a file of results.

    Raises
    ------
    SceneError
        It is another suffix, or the package for Parquet is missing.
    """
    if path.suffix.lower() not in SUFFIXES:
        raise SceneError(
            f"{path}: must end in {' or '.join(SUFFIXES)}, as the suffix decides the format;"
            " change the name of the file"
        )
    if path.suffix.lower() == ".parquet":
        try:
            import pyarrow  # noqa: F401
        except ImportError:
            raise SceneError(
                f'{path}: Parquet needs pyarrow; pip install "gallop-fmu[parquet]", or give a name'
                " that ends in .nc"
            ) from None


def check_columns(path: Path | str | None, columns: Iterable[str]) -> None:
    """Refuse names of columns that the type of the file cannot hold, before a long run.

    Raises
    ------
    SceneError
        A name is not allowed.
    """
    slashed = [name for name in columns if "/" in name]
    if path is not None and Path(path).suffix.lower() == ".nc" and slashed:
        raise SceneError(
            f"{path}: NetCDF allows no slash in the name of a column, as in {slashed[0]!r}; call it"
            f" {slashed[0].replace('/', '_')!r}, or give a file name that ends in .parquet"
        )


def write_results(dataset: xr.Dataset, path: Path) -> None:
    """Replace a file of results atomically."""
    is_parquet = path.suffix.lower() == ".parquet"
    write_whole(path, _parquet_bytes(dataset) if is_parquet else netcdf_bytes(dataset))


def read_results(path: Path) -> xr.Dataset:
    """Read a file of results.

    Raises
    ------
    SceneError
        It is missing, or not a file of results.
    """
    if not path.exists():
        raise SceneError(f"{path}: no such file")
    try:
        dataset = (_read_parquet if path.suffix.lower() == ".parquet" else _read_netcdf)(path)
        header = json.loads(dataset.attrs[HEADER])
        columns = {str(name) for name in dataset.variables}
        is_valid = is_header({**header, "format": FORMAT})  # of this version or an older one
        if not is_valid or not {"run", *TEXT_COLUMNS} <= columns:
            raise ValueError("not a file of results")
    except Exception as problem:  # libraries raise many types of errors for a damaged file
        raise SceneError(
            f"{path}: not the results of a sweep, or damaged ({type(problem).__name__});"
            " run the sweep again"
        ) from None
    return dataset


def _parquet_bytes(dataset: xr.Dataset) -> bytes:
    import pyarrow as pa
    from pyarrow import parquet

    dataset = flattened(dataset)
    columns = {str(name): pa.array(values.values) for name, values in dataset.variables.items()}
    fields = [
        pa.field(name, column.type, metadata=dataset[name].attrs)
        for name, column in columns.items()
    ]
    schema = pa.schema(fields, metadata={HEADER: dataset.attrs[HEADER]})
    buffer = BytesIO()
    parquet.write_table(pa.table(list(columns.values()), schema=schema), buffer)
    return buffer.getvalue()


def _read_parquet(path: Path) -> xr.Dataset:
    import xarray as xr
    from pyarrow import parquet

    table = parquet.read_table(path)
    header = table.schema.metadata[HEADER.encode()].decode()
    variables = {name: ("run", table[name].to_numpy()) for name in table.column_names}
    flat = xr.Dataset(variables, attrs={HEADER: header})
    return _described(flat, json.loads(header))


def _read_netcdf(path: Path) -> xr.Dataset:
    import xarray as xr

    return xr.load_dataset(path, engine="h5netcdf")
