"""The coefficient curve of line data: a file, a packaged curve, or the assumed one."""

from __future__ import annotations

import difflib
from pathlib import Path
from typing import Any, NamedTuple

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.line.ice_shapes import IceShape
from gallop_fmu.scene.assumed_coefficients import DRAG
from gallop_fmu.scene.curve_catalogue import packaged_curves
from gallop_fmu.scene.curve_file import read_curve

ASSUMED = "assumed"
"""Name of the assumed curve in line data."""


class LineCurve(NamedTuple):
    """Section ``[aerodynamics]`` of a scene, and its source."""

    data: dict[str, Any]
    source: str


def line_curve(name: str, folder: Path) -> LineCurve:
    """Return the curve of a CSV file or a packaged one.

    Parameters
    ----------
    name
        Name of the file or of the packaged curve.
    folder
        Folder of relative names of files.

    Raises
    ------
    SceneError
        There is no such curve, or the file is not a curve.
    """
    curves = packaged_curves()
    if name in curves:
        entry = curves[name]
        source = f"packaged curve {name}, {entry.status}: {entry.source}"
        if entry.status == "published":
            return LineCurve({"kind": "packaged", "name": name}, source)
        return LineCurve(dict(entry.data), source)
    path = folder / name
    if path.suffix.lower() != ".csv" and not path.exists():
        names = [ASSUMED, *curves]
        closest = difflib.get_close_matches(name, names, n=1, cutoff=0.0)[0]
        raise SceneError(
            f"line.coefficients = {name!r}: neither a CSV file nor a packaged curve; packaged are"
            f" {', '.join(names)}; closest: {closest}"
        )
    table = read_curve(path)
    return LineCurve({"kind": "table", **table.columns}, f"given with the line: {path.name}")


def assumed_curve(shape: IceShape, thickness_ratio: float) -> LineCurve:
    """Return the assumed curve for the ice of a line.

    Parameters
    ----------
    shape
        Shape of the ice; round ice has no lift and no moment.
    thickness_ratio
        Maximum ice thickness over the diameter of the bare conductor.
    """
    if shape == "radial" or thickness_ratio == 0.0:
        drag = DRAG * (1.0 + 2.0 * thickness_ratio)
        return LineCurve(
            {
                "kind": "polynomial",
                "valid_from_deg": -180.0,
                "valid_to_deg": 180.0,
                "lift": [0.0],
                "drag": [drag],
                "moment": [0.0],
                "outside": "periodic",
            },
            f"ASSUMED, not measured: round section without lift, drag {DRAG:g} of its own width",
        )
    return LineCurve(
        {"kind": "assumed", "ice_thickness_ratio": thickness_ratio},
        "ASSUMED, not measured: full-circle curve for the thickness of the ice, calibrated to the"
        " largest amplitudes observed on lines (CIGRE 322); give coefficients of the ice if known",
    )
