"""Wind and tower motion from a CSV file with ``time`` and inputs of the FMU, as FMPy reads it.

The same file works for the FMU (``fmpy simulate --input-file``) and `gallop_fmu.simulate`. FMPy
sets inputs at the start of a communication step and the FMU reaches them at its end, so the FMU is
delayed by one step: an error of first order in the step (`tests/fmu/test_inputs.py` measures 0.045
m of 0.40 m for a step of 0.05 s, and 0.009 m for 0.01 s).
"""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any, TypeVar, overload

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import check_table, read_table
from gallop_fmu.input.scene_like import SceneLike, SceneName, as_scene
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.scene_base import SceneBase

_AXES = ("x1", "x2", "x3")

AnyScene = TypeVar("AnyScene", bound=Scene | LineScene)


def motions(scene: SceneBase) -> dict[str, str]:
    """Return the input variables of the tower points, each with the dotted path of its law.

    Towers of a line count from 0, the left end.
    """
    if isinstance(scene, LineScene):
        held = [f"suspensions.{k}" for k in range(len(scene.section.suspensions))]
        places = enumerate(("left_end", *held, "right_end"))
        points = {f"tower[{k}]": f"section.{place}" for k, place in places}
    else:
        points = {f"support.{end}": f"supports.{end}" for end in ("left", "right")}
    return {
        f"{point}.{axis}": f"{path}.motion.{axis}"
        for point, path in points.items()
        for axis in _AXES
    }


def columns_of(scene: SceneBase) -> dict[str, str]:
    """Return the possible columns of an input file, and their units."""
    angle = {} if isinstance(scene, LineScene) else {"attack_angle": "rad"}
    return {"time": "s", "wind_speed": "m/s", **angle, **dict.fromkeys(motions(scene), "m")}


@overload
def with_inputs(scene: AnyScene, path: Path | str) -> AnyScene: ...


@overload
def with_inputs(scene: SceneName, path: Path | str) -> Scene | LineScene: ...


def with_inputs(scene: SceneLike, path: Path | str) -> Scene | LineScene:
    """Return a copy of a scene with wind and tower motion from a CSV file.

    Values are linear between rows and constant before the first and after the last. Two rows with
    the same time are a jump; a single row is a constant.

    Parameters
    ----------
    scene
        The scene of one span or of a line.
    path
        File. Its first column is the time [s], with any name; the others are any of ``wind_speed``
        [m/s], ``attack_angle`` [rad] and ``support.left.x1`` ... ``support.right.x3`` [m]; of a
        line ``wind_speed`` and ``tower[0].x1``, ``tower[0].x2``, ... [m], with towers counted from
        the left end.

    Raises
    ------
    SceneError
        The file is unreadable, a column unknown or repeated, times do not increase, or the attack
        angle changes, which only the FMU supports.
    """
    scene = as_scene(scene)
    path = Path(path)
    paths = motions(scene)
    table = read_table(path, columns_of(scene), first="time")
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
        elif name in paths:
            values[paths[name]] = law
    return scene.with_values(values)


def _length(time: list[float]) -> float:
    """Return the length of the file [s], so that a gap of any length is interpolated."""
    return max(time[-1] - time[0], 1.0)


def _constant_angle(path: Path, angles: tuple[float, ...]) -> float:
    if len(set(angles)) != 1:
        raise SceneError(
            f"{path.name}: attack_angle changes from {angles[0]}, but is constant in a scene;"
            " remove the column, or simulate the FMU, which has this input"
        )
    return math.degrees(angles[0])
