"""Wind and tower motion from a CSV file as FMPy reads it for an FMU: ``time`` and the names of input variables.

So the same file drives the FMU (``fmpy simulate --input-file``) and `gallop_fmu.simulate`. FMPy
sets the inputs at the start of a communication step and the FMU reaches them at its end, so it
follows the file one step later: an error of first order in the step (`tests/fmu/test_inputs.py`
measures 0.045 m of 0.40 m at a step of 0.05 s, 0.009 m at 0.01 s).
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import check_table, read_table
from gallop_fmu.scene.scene import Scene

MOTIONS = {
    f"support.{end}.{axis}": f"supports.{end}.motion.{axis}"
    for end in ("left", "right")
    for axis in ("x1", "x2", "x3")
}
"""Input variables for the tower points, and where a scene holds their laws."""


COLUMNS = {"time": "s", "wind_speed": "m/s", "attack_angle": "rad", **dict.fromkeys(MOTIONS, "m")}
"""Columns that an input file can have, and their units."""


def with_inputs(scene: Scene, path: Path | str) -> Scene:
    """Copy of a scene that is driven by the columns of a CSV file, linear between its rows and held beyond them.

    Two rows of one time are a jump, and a single row is constant.

    Parameters
    ----------
    scene
        What to drive.
    path
        File whose first column is the time [s], whatever its name, and whose others are any of
        ``wind_speed`` [m/s], ``attack_angle`` [rad] and ``support.left.x1`` ...
        ``support.right.x3`` [m].

    Raises
    ------
    SceneError
        Unreadable file, unknown or repeated column, times that do not increase, or an attack angle
        that changes: a scene holds one angle, only the FMU can vary it.
    """
    path = Path(path)
    table = read_table(path, COLUMNS, first="time")
    columns, values = table.columns, dict[str, Any]()
    time = list(columns["time"])
    if not time:
        raise SceneError(f"{path.name}: has no rows; give at least one")
    if len(time) > 1:
        check_table(path.name, "time", columns, table.rows, jumps=True)
    for name, column in columns.items():
        law: dict[str, Any] = {"kind": "constant", "value": column[0]}
        if len(time) > 1:
            law = {"kind": "table", "time": time, "value": list(column), "max_gap": _length(time)}
        if name == "wind_speed":
            values |= {"wind.speed": None, "wind.history": law}
        elif name == "attack_angle":
            values["ice.attack_angle_deg"] = _constant_angle(path, column)
        elif name in MOTIONS:
            values[MOTIONS[name]] = law
    return scene.with_values(values)


def _length(time: list[float]) -> float:
    """Length of the whole file [s]: every gap between two rows is meant as a straight line."""
    return max(time[-1] - time[0], 1.0)


def _constant_angle(path: Path, angles: tuple[float, ...]) -> float:
    if len(set(angles)) != 1:
        raise SceneError(
            f"{path.name}: attack_angle changes from {angles[0]}; in a scene it is constant. "
            "Leave the column out, or run the FMU, whose input it is"
        )
    return math.degrees(angles[0])
