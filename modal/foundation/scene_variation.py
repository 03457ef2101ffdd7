"""Scenes with one number changed, and with the sag, the tension and both ends adapted."""

from __future__ import annotations

from typing import Any, overload

from gallop_fmu import LineScene, Model, Scene, SceneError
from modal.foundation.change_of_state import ACSR_EXPANSION, change_of_state

TEMPERATURE = "temperature_change"
"""Rise of temperature from the scene's state [K], which is not a number of the scene."""

ICE_MASS = "ice.mass_per_length"
"""Ice on the strung conductor, which changes its sag and tension."""

CABLE_SECTIONS = ("span.", "conductor.", "ice.", "supports.")
"""Sections of a scene whose numbers change sag and tension."""

BOTH_SUPPORTS = ("supports.stiffness_x1", "supports.stiffness_x3")
"""Paths that stand for the same number of both supports."""

DAMPING_FACTORS = ("damping.translation", "damping.twist")
CURVE_FACTORS = ("aerodynamics.lift", "aerodynamics.drag", "aerodynamics.moment")
ICE_FACTOR = "ice.first_moment"
FACTORS = (*DAMPING_FACTORS, *CURVE_FACTORS, ICE_FACTOR)
"""Paths that stand for a factor on several numbers of the scene: the damping ratios, a coefficient
at all angles (and so its slope), and the first moments of the ice."""


def with_number(scene: Scene, path: str, value: float, expansion: float = ACSR_EXPANSION) -> Scene:
    """Change one number of a scene, with the paths of `modal.ratio_map`."""
    if path == TEMPERATURE:
        return change_of_state(scene, temperature_change=value, expansion=expansion)
    if path == ICE_MASS:
        return change_of_state(scene, ice_mass=value)
    if path in FACTORS:
        return scene.with_values(_scaled(scene, path, value))
    if path in BOTH_SUPPORTS:
        name = path.split(".")[1]
        return scene.with_values({f"supports.{end}.{name}": value for end in ("left", "right")})
    if path == "span.sag":
        return scene.with_values({path: value, "span.horizontal_tension": None})
    if path == "span.horizontal_tension":
        return scene.with_values({path: value, "span.sag": None})
    return (free_sag(scene) if path.startswith(CABLE_SECTIONS) else scene).with_values(
        {path: value}
    )


@overload
def varied(scene: Scene, path: str, value: float) -> Scene: ...


@overload
def varied(scene: LineScene, path: str, value: float) -> LineScene: ...


@overload
def varied(scene: Scene | LineScene, path: str, value: float) -> Scene | LineScene: ...


def varied(scene: Scene | LineScene, path: str, value: float) -> Scene | LineScene:
    """Change one number of a scene as `with_number`, but keep what the scene prescribes.

    A scene that prescribes both sag and tension keeps the ratio of its sag to that of the
    equilibrium, and the same of its tension. At the present value of the number, the result is the
    scene itself, so that derivatives and diagrams are those of the scene. A line takes the names of
    its numbers, and factors: its ice does not change its strung state.
    """
    if isinstance(scene, LineScene):
        return scene.with_values(_scaled(scene, path, value) if path in FACTORS else {path: value})
    changed = with_number(scene, path, value)
    if scene.span.initial_state != "held" or changed.span.initial_state == "held":
        return changed
    free = Model(with_number(scene, path, number_of(scene, path))).equilibrium()
    now = Model(changed).equilibrium()
    sag, tension = scene.span.sag, scene.span.horizontal_tension
    assert sag is not None  # held
    assert tension is not None
    return changed.with_values(
        {
            "span.sag": sag * now.sag / free.sag,
            "span.horizontal_tension": tension * now.horizontal_tension / free.horizontal_tension,
        }
    )


def number_of(scene: Scene | LineScene, path: str) -> float:
    """Present value of a number, with the paths of `varied`.

    Raises
    ------
    SceneError
        If the scene does not have it.
    """
    if path in FACTORS:
        _scaled(scene, path, 1.0)  # raises if there is nothing to scale
        return 1.0
    numbers = scene.numbers()
    if path in numbers:
        return float(numbers[path][0])
    if isinstance(scene, Scene):
        if path == TEMPERATURE:
            return 0.0
        if path in BOTH_SUPPORTS:
            return number_of(scene, path.replace("supports", "supports.left", 1))
        if path == "span.horizontal_tension":
            return Model(scene).equilibrium().horizontal_tension
        if path == "span.sag":
            return Model(scene).equilibrium().sag
    scene.unit_of(path)  # raises with the nearest path if there is no such number
    raise SceneError(f"{path}: the scene has no value for it; give the values to vary")


def unit_of(scene: Scene | LineScene, path: str) -> str:
    """Unit of a number, with the paths of `modal.ratio_map`."""
    if path in FACTORS:
        return "1"
    if isinstance(scene, LineScene):
        return scene.unit_of(path)
    if path == TEMPERATURE:
        return "K"
    return "N/m" if path in BOTH_SUPPORTS else scene.unit_of(path)


def _scaled(scene: Scene | LineScene, path: str, factor: float) -> dict[str, Any]:
    """Return the values of what a path of `FACTORS` stands for, multiplied."""
    name = path.split(".")[1]
    if path == ICE_FACTOR:
        ice = scene.ice
        moments = (factor * ice.first_moment_x2, factor * ice.first_moment_x3)
        return dict(zip(("ice.first_moment_x2", "ice.first_moment_x3"), moments, strict=True))
    if path in DAMPING_FACTORS:
        pair = getattr(scene.damping, name)
        if pair is None:
            raise SceneError(f"{path} is not given, so it cannot be multiplied; give its ratios")
        ratios = {f"{path}.{key}": getattr(pair, key) for key in ("low_ratio", "high_ratio")}
        return {key: factor * value for key, value in ratios.items()}
    if scene.aerodynamics is None:
        raise SceneError(f"{path} is not given, so it cannot be multiplied; give a curve")
    curve = scene.aerodynamics.explicit().model_dump(mode="json", exclude_none=True)
    curve[name] = [factor * value for value in curve[name]]
    return {"aerodynamics": curve}


def free_sag(scene: Scene) -> Scene:
    """Remove the sag of a scene that prescribes both sag and tension.

    With another number changed, the two would contradict each other.
    """
    return scene.with_values({"span.sag": None}) if scene.span.initial_state == "held" else scene
