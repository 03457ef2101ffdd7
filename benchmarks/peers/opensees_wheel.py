"""OpenSeesPy from its wheel: its Linux wheel brings a BLAS that its own library does not find."""

from __future__ import annotations

import ctypes
import importlib.util
from pathlib import Path
from types import ModuleType


def load() -> ModuleType:
    """Load the libraries of the wheel, then OpenSees itself."""
    linux = importlib.util.find_spec("openseespylinux")
    for folder in linux.submodule_search_locations or () if linux else ():
        for name in ("libquadmath.so.0", "libgfortran.so.4", "libblas.so.3", "liblapack.so.3"):
            ctypes.CDLL(str(Path(folder) / "lib" / name), mode=ctypes.RTLD_GLOBAL)
    import openseespy.opensees as opensees

    return opensees
