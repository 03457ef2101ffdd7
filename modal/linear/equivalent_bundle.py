"""One conductor in place of a bundle.

A bundle of n equal subconductors at distances r_i from its centre, held together by spacers, moves
as one conductor with n times the mass, the axial stiffness and the wind load, and in rotation about
its centre as a conductor with the torsional inertia n (I + m r2) and the torsional stiffness
n (GJ + H r2), where r2 = mean(r_i^2) and H is the horizontal tension of a subconductor.

If the bundle rotates with one loop, subconductors that move down stretch and those that move up
slacken. With k = sum y^2 / sum(y^2 + z^2), y the horizontal distances, and spacers l_s apart that
do not let the subconductors slide against each other at the spacers, symmetric torsion obeys
Irvine's equation tan x = x - 4 x^3/lambda_T^2, x = pi f/(2 f0), with f0 = c/(2L), c^2 = (H r2 +
GJ)/(m r2 + I), and

    lambda_T^2 = k lambda^2 [H r2/(H r2 + GJ)] / (1 + (1 - k) EA w^2 l_s^2/(12 H^3)),            (1)

lambda^2 = (w L/H)^2 L EA/(H Le), Le = L (1 + (w L/H)^2/8). The equivalent conductor has the
torsional stiffness times (f/f0)^2, so that its first symmetric torsional mode is that of (1). This
holds where posts or ends hold each subconductor along the line. Strings give way: the lowest
torsional modes then stretch the subconductors little, and the factor is 1.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from gallop_fmu import LineScene, Model, SceneError
from gallop_fmu.input.scene_like import LineLike, as_line
from gallop_fmu.scene.aerodynamics import Aerodynamics
from modal.linear.shallow_cable import symmetric_root

RANGE = (
    "Valid for motions of the whole bundle with loops longer than the distance of the spacers; it"
    " has no sub-span motion. Torsion holds for one symmetric loop in each span: frequencies of"
    " torsion with two loops are too high by the factor sqrt(sag_factor), and the torque of"
    " rotations above 20 deg is inaccurate. Rotation changes the attack angle, but not the"
    " velocities of the subconductors in the wind: galloping in bundle torsion is not found."
)
"""Range of an equivalent conductor."""

STRINGS = (
    " Between suspension strings the stiffening of torsion by the sag is left out (sag_factor = 1):"
    " the lowest frequency of torsion comes out too low, by up to 9 % in"
    " benchmarks/accuracy/equivalent_bundle.md, and more in long spans of heavy conductors."
)
"""Addition to the range of a section with strings."""

FREE_CLAMP = 1e-3
"""Torsional stiffness [N m/rad] of the clamp at a yoke that nothing restores."""

DEVICES = ("mass", "damper", "interphase_spacer", "interval")
"""Kinds of devices that an equivalent conductor can have."""


@dataclass(frozen=True)
class EquivalentBundle:
    """One conductor that stands for a bundle.

    Attributes
    ----------
    scene : LineScene
        The line with single conductors.
    sag_factor : float
        Factor of the torsional stiffness by the sag, (f/f0)^2: the mean of the spans by length, or
        1 with suspension strings.
    sag_factors : tuple of float
        The factor of each span between fixed ends.
    range : str
        What the equivalent conductor holds for.
    """

    scene: LineScene
    sag_factor: float
    sag_factors: tuple[float, ...]
    range: str


def equivalent_bundle(scene: LineLike) -> EquivalentBundle:
    """Replace each bundle of a line by one equivalent conductor.

    Strings, ends and devices of the subconductors are added up. A yoke adds its weight to that of
    the string, and restores the rotation of the bundle there by (weight x height of its joint).
    Damping of the twist becomes that of translation: subconductors translate as the bundle rotates.

    Parameters
    ----------
    scene
        The line, with two or more subconductors.

    Returns
    -------
    EquivalentBundle
        The new scene, with the range among its notes.

    Raises
    ------
    SceneError
        If the line has single conductors, a device that an equivalent conductor cannot have, or a
        device or load on one subconductor alone.
    SimulationError
        If no initial equilibrium exists.
    """
    scene = as_line(scene, "equivalent_bundle", "one span has no bundle to replace")
    count = scene.bundle.subconductors
    if count == 1:
        raise SceneError("subconductors = 1: the line has no bundle to replace")
    _check_devices(scene)
    taut = _with_torsion(scene, 1.0, scene.strung_tension)  # torsion has no effect on tensions
    tension = Model(taut).equilibrium().horizontal_tension / count
    factors = tuple(
        _sag_factor(scene, span, tension) for span in range(1, len(scene.section.spans) + 1)
    )
    lengths = [span.length for span in scene.section.spans]
    factor = float(np.average(factors, weights=lengths)) if _is_held(scene) else 1.0
    return EquivalentBundle(
        _with_torsion(scene, factor, tension), factor, factors, _range_of(scene)
    )


def _is_held(scene: LineScene) -> bool:
    """True if posts hold all subconductors along the line between the spans."""
    return all(suspension.kind == "post" for suspension in scene.section.suspensions)


def _range_of(scene: LineScene) -> str:
    return RANGE if _is_held(scene) else RANGE + STRINGS


def _check_devices(scene: LineScene) -> None:
    for number, device in enumerate(scene.devices, start=1):
        if device.kind not in DEVICES:
            raise SceneError(
                f"device {number} ({device.kind}): an equivalent conductor cannot have it; keep the"
                " bundle, or remove the device"
            )
    for name, items in (("device", scene.devices), ("load", scene.loads)):
        for number, item in enumerate(items, start=1):
            alone = getattr(item, "subconductor", None)
            if alone is not None and getattr(item, "kind", "") != "interphase_spacer":
                raise SceneError(
                    f"{name} {number} is on subconductor {alone} alone: an equivalent conductor"
                    " has no subconductors; leave subconductor out, or keep the bundle"
                )


def radius_squared(scene: LineScene) -> tuple[float, float]:
    """Mean squared distance r2 [m2] of the subconductors from their centre, and k of the module."""
    offsets = np.array(scene.bundle.positions)
    squares = np.mean((offsets - offsets.mean(axis=0)) ** 2, axis=0)
    return float(squares.sum()), float(squares[1] / squares.sum())


def _sag_factor(scene: LineScene, span: int, tension: float) -> float:
    """Factor (f/f0)^2 of equation (1) in one span with the horizontal tension [N]."""
    of_span, conductor, ice = (
        scene.section.spans[span - 1],
        scene.conductor,
        scene.ice_of_span(span),
    )
    weight = (conductor.mass_per_length + ice.mass_per_length) * scene.section.gravity
    length, stiffness = of_span.length, conductor.axial_stiffness
    parameter = weight * length / tension
    stretched = length * (1.0 + parameter**2 / 8.0)
    of_sag = parameter**2 * length * stiffness / (tension * stretched)
    r2, share = radius_squared(scene)
    taut = tension * r2 / (tension * r2 + conductor.torsional_stiffness)
    stations = (0.0, *scene.bundle.spacer_stations, 1.0)
    apart = length * float(np.max(np.diff(stations)))
    sliding = (1.0 - share) * stiffness * weight**2 * apart**2 / (12.0 * tension**3)
    return (2.0 * symmetric_root(share * of_sag * taut / (1.0 + sliding)) / math.pi) ** 2


def _with_torsion(scene: LineScene, factor: float, tension: float) -> LineScene:
    """The line with equivalent conductors; the tension [N] is that of one subconductor."""
    count = scene.bundle.subconductors
    r2, _ = radius_squared(scene)
    data = scene.model_dump(mode="json", exclude_none=True)
    mass = scene.conductor.mass_per_length
    conductor, section = data["conductor"], data["section"]
    conductor["mass_per_length"] *= count
    conductor["axial_stiffness"] *= count
    conductor["torsional_stiffness"] = (
        count * factor * (conductor["torsional_stiffness"] + tension * r2)
    )
    conductor["torsional_inertia"] = count * (conductor["torsional_inertia"] + mass * r2)
    if "horizontal_tension" in section:
        section["horizontal_tension"] *= count
    if "rated_strength" in section:
        section["rated_strength"] *= count
    for ice in _ices(data):
        ice["torsional_inertia"] = count * (ice["torsional_inertia"] + ice["mass_per_length"] * r2)
        for name in ("mass_per_length", "first_moment_x2", "first_moment_x3"):
            ice[name] *= count
    for curve in _curves(data):
        for name in ("lift", "drag", "moment"):
            curve[name] = [count * value for value in curve[name]]
    for held in (*section["suspensions"], section["left_end"], section["right_end"]):
        _add_up(held, count, held in section["suspensions"], scene)
    _add_devices(data, count, scene)
    data["damping"]["twist"] = data["damping"].get("translation")
    data["bundle"] = {}
    data["sources"] = {}
    note = f"equivalent conductor of {count}: {_range_of(scene)}"
    data["notes"] = [*data.get("notes", []), note]
    return LineScene.from_dict(data)


def _ices(data: dict[str, Any]) -> list[dict[str, Any]]:
    """All tables of ice in the data of a scene."""
    owners = [data, *data["section"]["spans"], *data.get("devices", [])]
    return [owner["ice"] for owner in owners if "ice" in owner]


def _curves(data: dict[str, Any]) -> list[dict[str, Any]]:
    """All coefficient curves in the data of a scene, with their numbers in place of a name."""
    owners = [owner for owner in (data, *data.get("devices", [])) if "aerodynamics" in owner]
    for owner in owners:
        if owner["aerodynamics"]["kind"] in ("packaged", "assumed"):
            named = TypeAdapter(Aerodynamics).validate_python(owner["aerodynamics"])
            owner["aerodynamics"] = named.explicit().model_dump(mode="json", exclude_none=True)
            data["notes"] = [*data.get("notes", []), *named.warnings()]
    return [owner["aerodynamics"] for owner in owners]


def _add_up(held: dict[str, Any], count: int, at_suspension: bool, scene: LineScene) -> None:
    """Add up what holds the subconductors at a tower; of a string at a suspension there is one."""
    if held["kind"] == "string" and at_suspension:
        yoke = scene.bundle.yoke_mass * scene.section.gravity
        held["weight"] += 2.0 * yoke  # half of the weight of a string is at the clamp
        carried = count * _mean_span_weight(scene) + 0.5 * held["weight"]
        restoring = scene.bundle.yoke_height * carried
        held["clamp_torsional_stiffness"] = max(restoring, FREE_CLAMP)
        return
    for name in ("weight", "stiffness", "damping", "stiffness_x1", "stiffness_x3"):
        if name in held:
            held[name] *= count


def _mean_span_weight(scene: LineScene) -> float:
    """Weight [N] of one subconductor over the mean length of a span."""
    lengths = [span.length for span in scene.section.spans]
    mass = scene.conductor.mass_per_length + scene.ice.mass_per_length
    return float(np.mean(lengths)) * mass * scene.section.gravity


def _add_devices(data: dict[str, Any], count: int, scene: LineScene) -> None:
    """Add up the devices of the subconductors, and add the masses of the spacers."""
    for device in data.get("devices", []):
        for name in ("mass", "damping", "hanging_mass", "hanging_stiffness"):
            if name in device and device["kind"] in ("mass", "damper"):
                device[name] *= count
        if device["kind"] == "interphase_spacer":
            device["subconductor"] = 1
    if scene.bundle.spacer_mass > 0.0:
        data["devices"] = [
            *data.get("devices", []),
            *(
                {"kind": "mass", "span": span, "station": s, "mass": scene.bundle.spacer_mass}
                for span in range(1, len(scene.section.spans) + 1)
                for s in scene.bundle.spacer_stations
            ),
        ]
