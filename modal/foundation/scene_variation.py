"""Scenes with one number changed, and with the sag, the tension and both ends adapted."""

from __future__ import annotations

from gallop_fmu import Model, Scene, SceneError
from modal.foundation.change_of_state import ACSR_EXPANSION, change_of_state

TEMPERATURE = "temperature_change"
"""Rise of temperature from the scene's state [K], which is not a number of the scene."""

ICE_MASS = "ice.mass_per_length"
"""Ice on the strung conductor, which changes its sag and tension."""

CABLE_SECTIONS = ("span.", "conductor.", "ice.", "supports.")
"""Sections of a scene whose numbers change sag and tension."""

BOTH_SUPPORTS = ("supports.stiffness_x1", "supports.stiffness_x3")
"""Paths that stand for the same number of both supports."""


def with_number(scene: Scene, path: str, value: float, expansion: float = ACSR_EXPANSION) -> Scene:
    """Change one number of a scene, with the paths of `modal.ratio_map`."""
    if path == TEMPERATURE:
        return change_of_state(scene, temperature_change=value, expansion=expansion)
    if path == ICE_MASS:
        return change_of_state(scene, ice_mass=value)
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


def number_of(scene: Scene, path: str) -> float:
    """Present value of a number, with the paths of `modal.ratio_map`.

    Raises
    ------
    SceneError
        If the scene does not have it.
    """
    if path == TEMPERATURE:
        return 0.0
    numbers = scene.numbers()
    if path in numbers:
        return float(numbers[path][0])
    if path in BOTH_SUPPORTS:
        return number_of(scene, path.replace("supports", "supports.left", 1))
    if path == "span.horizontal_tension":
        return Model(scene).equilibrium().horizontal_tension
    if path == "span.sag":
        return Model(scene).equilibrium().sag
    scene.unit_of(path)  # raises with the nearest path if there is no such number
    raise SceneError(f"{path}: the scene has no value for it; give the values to vary")


def unit_of(scene: Scene, path: str) -> str:
    """Unit of a number, with the paths of `modal.ratio_map`."""
    if path == TEMPERATURE:
        return "K"
    return "N/m" if path in BOTH_SUPPORTS else scene.unit_of(path)


def free_sag(scene: Scene) -> Scene:
    """Remove the sag of a scene that prescribes both sag and tension.

    With another number changed, the two would contradict each other.
    """
    return scene.with_values({"span.sag": None}) if scene.span.initial_state == "held" else scene
