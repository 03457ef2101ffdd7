"""A scene with one of its numbers changed, so that sag, tension and both ends follow."""

from __future__ import annotations

from gallop_fmu import Model, Scene, SceneError
from modal.foundation.change_of_state import ACSR_EXPANSION, change_of_state

TEMPERATURE = "temperature_change"
"""Not a number of the scene: the rise of temperature from the scene's state [K]."""

ICE_MASS = "ice.mass_per_length"
"""Ice on the strung conductor, which sags further under it."""

CABLE = ("span.", "conductor.", "ice.", "supports.")
"""Numbers with which sag and tension change."""

BOTH_ENDS = "supports"
"""``supports.stiffness_x1`` and ``supports.stiffness_x3`` stand for both ends at once."""

_BOTH = (f"{BOTH_ENDS}.stiffness_x1", f"{BOTH_ENDS}.stiffness_x3")


def with_number(scene: Scene, path: str, value: float, expansion: float = ACSR_EXPANSION) -> Scene:
    """The scene with one number changed, as `modal.ratio_map` reads it."""
    if path == TEMPERATURE:
        return change_of_state(scene, temperature_change=value, expansion=expansion)
    if path == ICE_MASS:
        return change_of_state(scene, ice_mass=value)
    if path in _BOTH:
        name = path.split(".")[1]
        return scene.with_values({f"supports.{end}.{name}": value for end in ("left", "right")})
    if path == "span.sag":
        return scene.with_values({path: value, "span.horizontal_tension": None})
    if path == "span.horizontal_tension":
        return scene.with_values({path: value, "span.sag": None})
    return (free_sag(scene) if path.startswith(CABLE) else scene).with_values({path: value})


def number_of(scene: Scene, path: str) -> float:
    """Present value of a number that `modal.ratio_map` can change.

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
    if path in _BOTH:
        return number_of(scene, path.replace(BOTH_ENDS, f"{BOTH_ENDS}.left", 1))
    if path == "span.horizontal_tension":
        return Model(scene).equilibrium().horizontal_tension
    if path == "span.sag":
        return Model(scene).equilibrium().sag
    scene.unit_of(path)  # names what comes closest if there is no such number at all
    raise SceneError(f"{path}: the scene does not have this number, so give the values to look at")


def unit_of(scene: Scene, path: str) -> str:
    """Unit of a number that `modal.ratio_map` can change."""
    if path == TEMPERATURE:
        return "K"
    return "N/m" if path in _BOTH else scene.unit_of(path)


def free_sag(scene: Scene) -> Scene:
    """Of a held pair of sag and tension, the tension alone: the sag of another design would contradict it."""
    return scene.with_values({"span.sag": None}) if scene.span.initial_state == "held" else scene
