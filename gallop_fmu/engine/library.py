"""The compiled kernel as a shared library: where it lies, and the types of its functions."""

from __future__ import annotations

import ctypes as c
import functools
import sys
from contextlib import suppress
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gallop_fmu.engine.ctypes_structs import (
    CDerived,
    CDerivedChain,
    CInputs,
    CProbe,
    CReport,
    CScene,
    CTeam,
    Layout,
    mirrored_layout,
)

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

_SUFFIX = {"win32": ".dll", "darwin": ".dylib"}.get(sys.platform, ".so")


def library_path() -> Path:
    """Path of the compiled kernel: beside this package, or of the installed one.

    They are not the same place in an editable installation, and when Python is started in the
    source folder.
    """
    name = f"gallop_kernel{_SUFFIX}"
    folders = [Path(folder) for folder in sys.modules["gallop_fmu"].__path__]
    with suppress(PackageNotFoundError):
        folders.append(Path(str(distribution("gallop-fmu").locate_file("gallop_fmu"))))
    for folder in folders:
        if (folder / name).is_file():
            return folder / name
    raise ImportError(
        f"{name} is neither beside the package nor installed; run `pip install .` in the source"
        " folder"
    )


API_VERSION = 6
"""GALLOP_API_VERSION of the gallop.h that these modules are written for."""


def compiled_layout(library: c.CDLL) -> Layout:
    """Layout of the structures of gallop.h as the library was compiled."""
    function = library.gallop_structure_field
    text, size = c.c_char_p, c.c_size_t
    function.argtypes = (c.c_int32, *map(c.POINTER, (text, text, size, size)))
    structure, field, offset, bytes_ = text(), text(), size(), size()
    layout: Layout = {}
    while function(len(layout), structure, field, offset, bytes_) == 0:
        assert structure.value is not None
        name = field.value.decode() if field.value is not None else None
        layout[structure.value.decode(), name] = (offset.value, bytes_.value)
    return layout


def _compare(library: c.CDLL) -> None:
    """Refuse a library of another version, or with a structure that differs from its mirror."""
    version = library.gallop_api_version() if hasattr(library, "gallop_api_version") else 0
    if version != API_VERSION:
        raise ImportError(
            f"the compiled kernel has API version {version}; these modules need {API_VERSION};"
            " install the package again"
        )
    compiled, mirrored = compiled_layout(library), mirrored_layout()
    for key in compiled.keys() | mirrored.keys():
        if compiled.get(key) != mirrored.get(key):
            raise ImportError(
                f"{key[0]}.{key[1] or '(size)'} is at (byte, size) {compiled.get(key)} in the"
                f" compiled kernel, {mirrored.get(key)} here; install the package again"
            )


def _load() -> c.CDLL:
    library = c.CDLL(str(library_path()))
    _compare(library)
    pointer, double, whole, size = c.c_void_p, c.c_double, c.c_int64, c.c_size_t
    doubles, report, inputs = c.POINTER(c.c_double), c.POINTER(CReport), c.POINTER(CInputs)
    integers, probes = c.POINTER(c.c_int32), (c.POINTER(CProbe), c.c_int32)
    signatures: dict[str, tuple[Any, tuple[Any, ...]]] = {
        "gallop_build": (c.c_char_p, ()),
        "gallop_has_fused_path": (c.c_int32, ()),
        "gallop_arithmetic_fault": (c.c_char_p, ()),
        "gallop_model_create": (c.c_int, (c.POINTER(CScene), c.POINTER(pointer), report)),
        "gallop_model_free": (None, (pointer,)),
        "gallop_model_derived": (c.c_int, (pointer, c.POINTER(CDerived))),
        "gallop_chain_derived": (c.c_int, (pointer, c.c_int32, c.POINTER(CDerivedChain))),
        "gallop_model_nodes": (c.c_int, (pointer, doubles)),
        "gallop_state_size": (size, (pointer,)),
        "gallop_saved_size": (size, (pointer,)),
        "gallop_state_init": (c.c_int, (pointer, pointer, double, inputs, report)),
        "gallop_state_time": (double, (pointer,)),
        "gallop_state_check": (c.c_int, (pointer, pointer)),
        "gallop_shedding_times": (c.c_int, (pointer, pointer, doubles)),
        "gallop_shedding_energies": (c.c_int, (pointer, pointer, doubles)),
        "gallop_equilibrium": (c.c_int, (pointer, pointer, double, inputs, report)),
        "gallop_state_place": (
            c.c_int,
            (pointer, pointer, double, inputs, doubles, doubles, report),
        ),
        "gallop_settle": (c.c_int, (pointer, pointer, report)),
        "gallop_advance": (c.c_int, (pointer, pointer, inputs, double, report)),
        "gallop_run": (
            c.c_int,
            (pointer, pointer, *[whole] * 3, *probes, doubles, c.POINTER(whole), report),
        ),
        "gallop_run_in_team": (
            c.c_int,
            (
                *(pointer, pointer, *[whole] * 3, *probes),
                *(doubles, c.POINTER(whole), c.POINTER(CTeam), report),
            ),
        ),
        "gallop_assist": (whole, (c.POINTER(CTeam),)),
        "gallop_dismiss": (c.c_int, (c.POINTER(CTeam),)),
        "gallop_observe": (c.c_int, (pointer, pointer, *probes, doubles)),
        "gallop_observe_equilibrium": (c.c_int, (pointer, *probes, doubles)),
        "gallop_residual": (c.c_int, (pointer, pointer, double, inputs, *[doubles] * 4)),
        "gallop_tangent": (
            c.c_int,
            (pointer, pointer, double, inputs, *[doubles] * 3, double, double, double, doubles),
        ),
        "gallop_device_force": (
            c.c_int,
            (pointer, pointer, double, inputs, *[doubles] * 3, c.c_int32, doubles, doubles),
        ),
        "gallop_device_tangent": (
            c.c_int,
            (
                *(pointer, pointer, double, inputs),
                *[doubles] * 3,
                *[double] * 3,
                c.c_int32,
                doubles,
            ),
        ),
        "gallop_device_load": (c.c_int, (pointer, c.c_int32, c.c_int32, *[doubles] * 5)),
        "gallop_junction_nodes": (c.c_int, (pointer, integers, integers)),
        "gallop_aero_load": (c.c_int, (pointer, c.c_int32, double, c.c_int32, *[pointer] * 5)),
        "gallop_shape_load": (
            c.c_int,
            (pointer, c.c_int32, integers, pointer, c.c_int32, *[pointer] * 2, c.c_int32)
            + (pointer,) * 2,
        ),
        "gallop_sections": (c.c_int, (pointer, *[doubles] * 3)),
        "gallop_strain_points": (c.c_int, (pointer, *[doubles] * 3)),
        "gallop_node_normals": (c.c_int, (pointer, doubles)),
        "gallop_free_unknowns": (c.c_int, (pointer, integers)),
        "gallop_seed": (c.c_int, (pointer, doubles)),
        "gallop_history_size": (size, (whole,)),
        "gallop_history_numbers": (c.c_int, (whole, c.c_int32, pointer, double, *[pointer] * 2)),
        "gallop_history_sizes": (c.c_int, (whole, c.c_int32, *[pointer] * 2)),
        "gallop_history_energy_line": (whole, (whole, c.c_int32, pointer, double)),
        "gallop_history_distances": (c.c_int, (whole, *[pointer] * 4)),
        "gallop_history_beats": (c.c_int, (whole, *[pointer] * 3, c.POINTER(double))),
    }
    for name, (result, arguments) in signatures.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    fault = library.gallop_arithmetic_fault()
    if fault:
        raise ImportError(f"the compiled kernel cannot compute; check {fault.decode()}")
    return library


kernel = _load()
"""The library, with the types of its functions."""


def address(values: NDArray[np.generic]) -> int:
    """Address of the numbers of an array, as the functions of the library take it."""
    return values.ctypes.data


@functools.cache
def build() -> str:
    """Compiler that built the kernel."""
    return str(kernel.gallop_build().decode())


def arithmetic(portable: bool) -> str:
    """Arithmetic of the kernel on this processor, ``"fused"`` or ``"portable"``.

    Parameters
    ----------
    portable
        True: the scene asks for portable arithmetic (`numerics.portable`).
    """
    return "fused" if kernel.gallop_has_fused_path() and not portable else "portable"
