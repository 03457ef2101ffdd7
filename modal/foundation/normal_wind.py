"""Scenes whose mean wind is uniform and towards +x3, as some analyses require."""

import math

from gallop_fmu import LineScene, Scene, SceneError
from gallop_fmu.scene.wind import OTHER_SIDE

INSTEAD = 'use natural_modes with wind = "mean", or simulate the scene'


def unfit_wind(
    scene: Scene | LineScene, purpose: str, speed: float | None = None, *, oblique: bool = False
) -> str:
    """Describe wind that is not uniform or not towards +x3; empty if it is both.

    Gusts are no problem: their mean is 0.

    Parameters
    ----------
    scene
        The scene.
    purpose
        What needs such wind, as the subject of the message.
    speed
        Wind speed [m/s] in place of the mean of the scene.
    oblique
        True: a constant direction below 90 deg and a profile over the height are no problem.
    """
    wind = scene.wind
    mean = wind.mean_speed if speed is None else speed
    kind = "steady wind that blows across towards +x3" if oblique else "uniform wind towards +x3"
    takes = f"{purpose} takes {kind}; {INSTEAD}"
    if mean < 0.0:
        return f"wind speed = {mean:g} m/s: {OTHER_SIDE}, and {takes}"
    if oblique and abs(math.remainder(wind.direction_deg, 360.0)) > 90.0:
        return f"wind.direction_deg = {wind.direction_deg:g} deg: {OTHER_SIDE}, and {takes}"
    given = {
        "wind.direction_deg": wind.direction_deg != 0.0 and not oblique,
        "wind.direction_history": wind.direction_history is not None,
        "wind.profile": wind.profile is not None and not oblique,
    }
    name = next((name for name, is_given in given.items() if is_given), None)
    return "" if name is None else f"{name} is given, and {takes}"


def check_wind_is_normal(
    scene: Scene | LineScene, purpose: str, speed: float | None = None, *, oblique: bool = False
) -> None:
    """Refuse a scene with `unfit_wind`; parameters as there.

    Raises
    ------
    SceneError
        Its wind is not uniform, or not towards +x3.
    """
    if problem := unfit_wind(scene, purpose, speed, oblique=oblique):
        raise SceneError(problem)
