"""Wind and tower motion from a CSV file as FMPy reads it for an FMU: ``time`` and the names of input variables.

So the same file drives the FMU (``fmpy simulate --input-file``) and `gallop_fmu.simulate`.
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from gallop_fmu.errors import SceneError
from gallop_fmu.scene import Scene
from gallop_fmu.textfiles import read_header, read_table

MOTIONS = {
    f"support.{end}.{axis}": f"supports.{end}.motion.{axis}" for end in ("left", "right") for axis in ("x1", "x2", "x3")
}
"""Input variables for the tower points, and where a scene holds their laws."""


def with_inputs(scene: Scene, path: Path | str) -> Scene:
    """Copy of a scene that is driven by the columns of a CSV file, linear between its rows and held beyond them.

    Parameters
    ----------
    scene
        What to drive.
    path
        File whose header names ``time`` [s] and any of ``wind_speed`` [m/s], ``attack_angle`` [rad] and
        ``support.left.x1`` ... ``support.right.x3`` [m].

    Raises
    ------
    SceneError
        Unreadable file, unknown column, times that do not increase, or an attack angle that changes: a scene holds one
        angle, only the FMU can vary it.
    """
    path = Path(path)
    header = read_header(path)
    known = ("wind_speed", "attack_angle", *MOTIONS)
    unknown = [name for name in header if name not in ("time", *known)]
    if unknown or "time" not in header or len(header) < 2:
        wrong = f"{unknown[0]} is no input" if unknown else f"the header is {','.join(header)[:80]}"
        raise SceneError(f"{path.name}: {wrong}; it must name time and any of {', '.join(known)}")
    columns = read_table(path, header).columns
    time, values = list(columns["time"]), dict[str, Any]()
    for name in header:
        law = {"kind": "table", "time": time, "value": list(columns[name]), "max_gap": _length(time)}
        if name == "wind_speed":
            values |= {"wind.speed": None, "wind.history": law}
        elif name == "attack_angle":
            values["ice.attack_angle_deg"] = _constant_angle(path, columns[name])
        elif name in MOTIONS:
            values[MOTIONS[name]] = law
    return scene.with_values(values)


def _length(time: list[float]) -> float:
    """Length of the whole file [s]: every gap between two rows is meant as a straight line."""
    return max(time[-1] - time[0], 1.0) if time else 1.0


def _constant_angle(path: Path, angles: tuple[float, ...]) -> float:
    if len(set(angles)) != 1:
        raise SceneError(
            f"{path.name}: attack_angle changes from {angles[0] if angles else 'nothing'}; in a scene it is constant. "
            "Leave the column out, or run the FMU, whose input it is"
        )
    return math.degrees(angles[0])
