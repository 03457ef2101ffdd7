"""Results whose table can be written to a file."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from gallop_fmu import SceneError
from gallop_fmu.foundation.atomic_write import netcdf_bytes, write_whole

if TYPE_CHECKING:
    import xarray as xr

SUFFIXES = (".nc", ".csv")


class SavedTable:
    """A result with a dataset, of which `_rows` is the part that a file of rows has."""

    if TYPE_CHECKING:

        @property
        def dataset(self) -> xr.Dataset:
            """All tables; a field or a property of the class."""

    def _rows(self) -> Any:
        """Rows as a DataFrame: by default all of the dataset."""
        return self.dataset.to_dataframe().reset_index()

    def save(self, path: Path | str) -> Path:
        """Write all tables as ``.nc`` (NetCDF), or rows as ``.csv``.

        Raises
        ------
        SceneError
            The suffix is another one.
        OSError
            The file cannot be written.
        """
        path = Path(path)
        suffix = path.suffix.lower()
        if suffix == ".nc":
            write_whole(path, netcdf_bytes(self.dataset))
        elif suffix == ".csv":
            write_whole(path, self._rows().to_csv(index=False, float_format="%.9g").encode())
        else:
            raise SceneError(f"{path}: the suffix must be one of {', '.join(SUFFIXES)}")
        return path
