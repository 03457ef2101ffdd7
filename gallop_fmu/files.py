"""Writing files as a whole: whoever reads one finds the old one or the new one, whatever happens meanwhile."""

from __future__ import annotations

import os
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr


def write_whole(path: Path, content: bytes) -> None:
    """Write a file beside its place, then put it there; where a link stands, its target is replaced.

    Raises
    ------
    OSError
        With the name of the file. What stood there before is kept, and nothing is left beside it.
    """
    place = path.resolve()
    new = place.with_name(f"{place.name}.{os.getpid()}.new")
    try:
        new.write_bytes(content)
        os.replace(new, place)
    except OSError as problem:
        raise OSError(problem.errno, problem.strerror, str(path)) from None
    finally:
        with suppress(OSError):
            new.unlink(missing_ok=True)


def netcdf_bytes(dataset: xr.Dataset) -> bytes:
    """A dataset as a NetCDF file, built in memory: HDF5 crashes the program when the disk is full."""
    buffer = BytesIO()
    dataset.to_netcdf(buffer, engine="h5netcdf")
    return buffer.getvalue()
