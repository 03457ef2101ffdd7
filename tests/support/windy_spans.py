"""Spans and lines in oblique, sheared and gusty wind, and their wind by numpy.

The wind here follows the formulas of the documentation from the scene alone; nothing of it is
taken from the kernel.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Scene, load_scene
from gallop_fmu.engine.mesh import Mesh
from gallop_fmu.scene.wind_consistency import gusts_of, towers_of

Array = NDArray[np.float64]

TURBULENCE = {
    "spectrum": "kaimal",
    "intensity": 0.25,
    "intensity_across": 0.2,
    "intensity_upwards": 0.15,
    "length_scale": 60.0,
    "length_scale_across": 30.0,
    "length_scale_upwards": 20.0,
    "spacing": 17.0,
    "duration": 4.0,
    "seed": 11,
}
POWER = {"kind": "power", "exponent": 0.2, "attachment_height": 18.0}
LOGARITHMIC = {
    "kind": "logarithmic",
    "roughness_length": 0.3,
    "attachment_height": 22.0,
    "ground_heights": [0.0, 9.0],
}


def windy_span(values: dict[str, Any] | None = None) -> Scene:
    """Example 3 with few elements, inclined, and wind as given."""
    return load_scene("example3").with_values(
        {
            "span.sag": None,
            "span.height_difference": 30.0,
            "numerics.elements": 6,
            "aerodynamics.outside": "hold",
        }
        | (values or {})
    )


def wind_at(scene: Scene | LineScene, x: Array, time: float, speed: float | None = None) -> Array:
    """Wind W along x1, x2, x3 [m/s] at places x (place, 3) of the line, shape (place, 3).

    `speed` [m/s] replaces that of the scene; the gusts stay.
    """
    wind = scene.wind
    if speed is None:
        speed = float(wind.speed_law.at(time))
    yaw = np.radians(0.0 if wind.direction_law is None else float(wind.direction_law.at(time)))
    factor = np.ones(len(x))
    if wind.profile is not None:
        towers = [place for place, _ in towers_of(scene)]
        factor = wind.profile.factor(x[:, 1] - np.interp(x[:, 0], *wind.profile.ground(towers)))
    gust = np.zeros((3, len(x)))
    gusts = gusts_of(wind, scene.length, scene.run.stop_time)
    if gusts is not None:
        at = time
        if gusts.repeat:
            period = gusts.times[-1] - gusts.times[0]
            at = gusts.times[0] + (time - gusts.times[0]) % period
        for component in range(gusts.values.shape[2]):
            row = [np.interp(at, gusts.times, column) for column in gusts.values[..., component].T]
            gust[component] = np.interp(x[:, 0], gusts.stations, row)
    along, across, up = 1.0 + gust[0], gust[1], gust[2]
    return (speed * factor)[:, None] * np.stack(
        [
            along * np.sin(yaw) + across * np.cos(yaw),
            up,
            along * np.cos(yaw) - across * np.sin(yaw),
        ],
        axis=1,
    )


def wind_force(mesh: Mesh, u: Array, v: Array, time: float, speed: float | None = None) -> Array:
    """Nodal forces of the wind [N, N m] in a motion, shape (node, 4).

    The load of a section is that of its motion relative to the air.
    """
    scene, sections = mesh.model.scene, mesh.sections
    x = mesh.model.equilibrium().x
    place = np.einsum("pn,enk->epk", sections.shape, x[sections.nodes]).reshape(-1, 3)
    wind = wind_at(scene, place, time, speed)
    across = (wind[:, :2] * sections.normal).sum(axis=1)
    (_, _, theta), (v2, v3, omega) = sections.motion(u), sections.motion(v)
    load = mesh.aero_load(theta, v2 - across, v3, omega, wind[:, 2]).force * sections.length
    parts = np.stack([load[0] * sections.normal[:, 0], load[0] * sections.normal[:, 1], *load[1:]])
    by_node = np.einsum("pn,iep->eni", sections.shape, parts.reshape(4, -1, 3))
    force = np.zeros((mesh.model.nodes, 4))
    np.add.at(force, sections.nodes, by_node)
    return force
