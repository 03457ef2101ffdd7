"""The two scenes: as gallop-fmu reads them, and as plain numbers for the peers."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

import gallop_fmu as gf

Array = NDArray[np.float64]

INTERVAL = 0.05
"""Time [s] between two outputs, the same for every code; every fixed step divides it."""

LOADED_POINTS = 39
"""Point loads at k/40 of the conductor's length: the interior nodes of a mesh of 41 nodes."""

NEVER = 1e9
"""Start [s] of a fall that does not happen."""

REFERENCE = (
    Path(__file__).resolve().parents[2] / "tests" / "peers" / "data" / "example1_step_opensees.csv"
)


@dataclass(frozen=True)
class Law:
    """Amplitude of the loads: smooth step over `rise`, down over `fall` from `fall_start` [s]."""

    rise: float
    fall_start: float = NEVER
    fall: float = 1.0

    def at(self, time: float | Array) -> Array:
        up, down = (
            np.clip((np.asarray(time) - start) / duration, 0.0, 1.0)
            for start, duration in ((0.0, self.rise), (self.fall_start, self.fall))
        )
        return np.asarray(
            sum(
                sign * x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
                for sign, x in ((1.0, up), (-1.0, down))
            )
        )

    def section(self) -> dict[str, object]:
        """As in a scene file."""
        if self.fall_start == NEVER:
            return {"kind": "ramp", "initial": 0.0, "final": 1.0, "duration": self.rise}
        return {
            "kind": "pulse",
            "peak": 1.0,
            "rise": self.rise,
            "fall_start": self.fall_start,
            "fall": self.fall,
        }


@dataclass(frozen=True)
class Wind:
    """Quasi-steady drag and lift without twist; polynomials in the angle from `centre` [rad]."""

    speed: float
    density: float
    diameter: float
    attack_angle: float
    centre: float
    lift: tuple[float, ...]
    drag: tuple[float, ...]


@dataclass(frozen=True)
class Problem:
    """One scene.

    Span [m], sag [m], mass [kg/m], axial stiffness [N], load [N] at each point, damping b1 [1/s].
    """

    name: str
    title: str
    stop_time: float
    length: float
    sag: float
    mass: float
    axial_stiffness: float
    gravity: float
    load: tuple[float, float, float]
    law: Law
    mass_damping: float
    wind: Wind | None
    scene: gf.Scene

    @cached_property
    def times(self) -> Array:
        """Times [s] of the outputs."""
        return INTERVAL * np.arange(1, round(self.stop_time / INTERVAL) + 1)


def example1() -> Problem:
    """Example 1 with the load of the OpenSees reference; without torques, as no peer can twist."""
    law, load = Law(rise=1.0), (0.0, 1.0, 2.0)
    points = {"evenly_spaced": LOADED_POINTS, "force": load, "law": law.section()}
    scene = gf.load_scene("example1").with_values({"loads": [points]})
    title = "Example 1: 39 point loads rise in 1 s and stay; no damping, no wind"
    return _problem("example1", title, 10.0, scene, load, law, wind=None)


def galloping() -> Problem:
    """Example 3 with translations, drag and lift only; from rest, excited by a short pulse.

    No ice eccentricity and no aerodynamic moment, so nothing twists.  The sag alone fixes the
    initial state.  Damping is proportional to mass, with the scene's ratio at the first horizontal
    frequency.
    """
    law, load = Law(rise=0.5, fall_start=0.5, fall=0.5), (0.0, 8.0, 4.0)
    points = {"evenly_spaced": LOADED_POINTS, "force": load, "law": law.section()}
    original = gf.load_scene("example3")
    damping = original.damping.translation
    scene = original.with_values(
        {
            "span.horizontal_tension": None,
            "ice.first_moment_x2": 0.0,
            "ice.first_moment_x3": 0.0,
            "aerodynamics.moment": [0.0],
            "damping.translation.high_ratio": (
                damping.low_ratio * damping.low_frequency / damping.high_frequency
            ),
            "initial.seed_vertical": 0.0,
            "initial.seed_horizontal": 0.0,
            "loads": [points],
            "numerics.elements": 20,
        }
    )
    curve = original.aerodynamics
    wind = Wind(
        speed=float(original.wind.speed),
        density=original.wind.air_density,
        diameter=original.conductor.diameter,
        attack_angle=float(np.radians(original.ice.attack_angle_deg)),
        centre=float(np.radians(curve.centre_deg)),
        lift=tuple(curve.lift),
        drag=tuple(curve.drag),
    )
    title = "Galloping: example 3 without twist, drag and lift, pushed by a pulse of 1 s"
    return _problem("galloping", title, 20.0, scene, load, law, wind)


def _problem(
    name: str,
    title: str,
    stop_time: float,
    scene: gf.Scene,
    load: tuple[float, float, float],
    law: Law,
    wind: Wind | None,
) -> Problem:
    damping = scene.damping.translation
    b1 = 2.0 * damping.low_ratio * 2.0 * np.pi * damping.low_frequency if wind else 0.0
    return Problem(
        name=name,
        title=title,
        stop_time=stop_time,
        length=scene.span.length,
        sag=scene.span.sag,
        mass=scene.conductor.mass_per_length,
        axial_stiffness=scene.conductor.axial_stiffness,
        gravity=scene.span.gravity,
        load=load,
        law=law,
        mass_damping=b1,
        wind=wind,
        scene=scene,
    )


def opensees_reference(problem: Problem) -> Array:
    """Stored response of 160 OpenSees elements: (time, 2), u2 and u3 [m]; accurate to 2e-4."""
    time, u2, u3 = np.loadtxt(REFERENCE, delimiter=",", skiprows=1, unpack=True)
    chosen = np.rint(problem.times / (time[1] - time[0])).astype(int)
    return np.column_stack([u2, u3])[chosen]
