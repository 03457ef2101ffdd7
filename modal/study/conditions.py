"""Conditions of a study: wind speed, attack angle, ice and coefficient curve, and their scenes."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from gallop_fmu import LineScene, SceneError
from gallop_fmu.line.ice_shapes import IceShape, ice_section
from gallop_fmu.line.line_curve import ASSUMED, LineCurve, assumed_curve, line_curve
from gallop_fmu.scene.wind import MAX_WIND_SPEED

DEFAULT_WINDS = (4.0, 6.0, 8.0, 10.0, 12.0)
"""Wind speeds [m/s] of a study without its own."""

MAX_THICKNESS = 0.2
"""Largest ice thickness [m]; more is almost certainly an error in the unit."""

OWN = "own"
"""Name of the ice and of the curve of the scene."""


@dataclass(frozen=True)
class StudyConditions:
    """Values over which a study computes all combinations.

    Attributes
    ----------
    winds : tuple of float
        Wind speeds [m/s].
    angles_deg : tuple of float
        Attack angles [deg] of the wind on the ice; empty: that of the scene.
    ices : tuple of float
        Largest ice thicknesses [m]; empty: the ice of the scene.
    curves : tuple of str
        Coefficient curves: packaged ones, CSV files, or ``"assumed"``; empty: the curve of the
        scene, which follows the ice if it is assumed.
    ice_shape, ice_density
        Shape and density [kg/m3] of the ice, where `ices` are given.
    """

    winds: tuple[float, ...] = DEFAULT_WINDS
    angles_deg: tuple[float, ...] = ()
    ices: tuple[float, ...] = ()
    curves: tuple[str, ...] = ()
    ice_shape: IceShape = "crescent"
    ice_density: float = 900.0

    def __post_init__(self) -> None:
        """Refuse values that no line has."""
        if not self.winds:
            raise SceneError("winds: no wind speed is given; give at least one, such as 4:12:2")
        for name, values, limit in (
            ("wind", self.winds, MAX_WIND_SPEED),
            ("angle", self.angles_deg, 360.0),
            ("ice", self.ices, MAX_THICKNESS),
        ):
            if wrong := [value for value in values if not abs(value) <= limit]:
                unit = {"wind": "m/s", "angle": "deg", "ice": "m"}[name]
                raise SceneError(f"{name} = {wrong[0]:g} {unit}: must be at most {limit:g} {unit}")
            if len(set(values)) < len(values):
                raise SceneError(f"{name}: a value is given twice; give each once")
        if wrong := [value for value in self.ices if not value > 0.0]:
            raise SceneError(f"ice = {wrong[0]:g} m: must be greater than 0")
        if not 0.0 < self.ice_density <= 1000.0:
            raise SceneError(
                f"ice_density = {self.ice_density:g} kg/m3: must be greater than 0 and at most 1000"
            )

    def climates(self, scene: LineScene, folder: Path = Path()) -> Iterator[Climate]:
        """Yield the scene with each ice and each curve.

        Parameters
        ----------
        scene
            The line.
        folder
            Folder of relative names of CSV files.

        Raises
        ------
        SceneError
            A curve does not exist, or the line does not stand with this ice.
        """
        for curve in self.curves or (OWN,):
            for ice in self.ices or (None,):
                found = self._curve(scene, curve, ice, folder)
                curved, source = scene, scene.sources.get("aerodynamics", "source not stated")
                if found is not None:
                    curved = scene.with_values({"aerodynamics": found.data})
                    source = found.source
                if curved.aerodynamics is None:
                    raise SceneError(
                        "the scene has no coefficient curve, so the wind cannot excite it; give one"
                        " with --curve FILE (columns angle_deg,lift,drag,moment), or --curve"
                        f" {ASSUMED}"
                    )
                if ice is not None:
                    curved = with_ice(curved, ice, self.ice_shape, self.ice_density)
                yield Climate(ice, curve, curved, source)

    def _curve(
        self, scene: LineScene, curve: str, ice: float | None, folder: Path
    ) -> LineCurve | None:
        """Return the curve for an ice; None: that of the scene. An assumed curve follows the ice.

        Raises
        ------
        SceneError
            There is no such curve, or the assumed one has no ice thickness.
        """
        if curve not in (OWN, ASSUMED):
            return line_curve(curve, folder)
        own = scene.aerodynamics
        if ice is not None:
            is_assumed = scene.sources.get("aerodynamics", "").startswith(ASSUMED.upper())
            if curve == ASSUMED or is_assumed or (own is not None and own.kind == ASSUMED):
                return assumed_curve(self.ice_shape, ice / scene.conductor.diameter)
        elif curve == ASSUMED and (own is None or own.kind != ASSUMED):
            raise SceneError(
                f"--curve {ASSUMED}: it depends on the thickness of the ice; give --ice, too"
            )
        return None

    def angles(self, scene: LineScene) -> tuple[float, ...]:
        """Attack angles [deg]; without any, that of the scene."""
        return self.angles_deg or (scene.ice.attack_angle_deg,)


@dataclass(frozen=True)
class StudyLimits:
    """Design values of the line, with which a study compares; None: not given.

    Attributes
    ----------
    clearance : float or None
        Distance [m] that two phases must keep.
    string_pull : float or None
        Largest pull [N] of a suspension string of one phase.
    unbalanced_pull : float or None
        Largest pull [N] along the line of one phase on a suspension tower.
    """

    clearance: float | None = None
    string_pull: float | None = None
    unbalanced_pull: float | None = None

    def __post_init__(self) -> None:
        """Refuse values that no line has."""
        for name, value in vars(self).items():
            if value is not None and not 0.0 < value < math.inf:
                unit = "m" if name == "clearance" else "N"
                raise SceneError(f"{name} = {value:g} {unit}: must be greater than 0")


@dataclass(frozen=True)
class Climate:
    """A line with one ice and one curve.

    Attributes
    ----------
    ice : float or None
        Largest thickness [m]; None: the ice of the scene.
    curve : str
        Name of the curve; `OWN`: that of the scene.
    scene : LineScene
        The line.
    source : str
        Source of the curve.
    """

    ice: float | None
    curve: str
    scene: LineScene
    source: str

    @property
    def ice_text(self) -> str:
        """Ice in words."""
        if self.ice is None:
            return f"ice of {self.scene.ice.mass_per_length:.3g} kg/m"
        return f"{1e3 * self.ice:g} mm ice"

    @property
    def curve_text(self) -> str:
        """Curve in words; empty for that of the scene."""
        return "" if self.curve == OWN else f"curve {Path(self.curve).stem}"

    def at(self, wind: float, angle_deg: float) -> LineScene:
        """The line in a wind [m/s] at an attack angle [deg]."""
        return self.scene.with_values({"wind.speed": wind, "ice.attack_angle_deg": angle_deg})


def with_ice(scene: LineScene, thickness: float, shape: IceShape, density: float) -> LineScene:
    """Return the line with ice of a thickness [m]; its attack angle stays.

    The damping of the scene stays, too. Spans with their own ice keep it.
    """
    ice = ice_section(shape, scene.conductor.diameter, thickness, density)
    angle = scene.ice.attack_angle_deg
    first = ice.first_moments(math.radians(angle))
    values: dict[str, Any] = {
        "mass_per_length": ice.mass_per_length,
        "torsional_inertia": ice.torsional_inertia,
        "first_moment_x2": first[0],
        "first_moment_x3": first[1],
        "first_moment_angle_deg": angle,
        "attack_angle_deg": angle,
    }
    return scene.with_values({"ice": values})


def steady_wind(scene: LineScene) -> LineScene:
    """Return the line with a constant wind speed, which a study varies."""
    if scene.wind.speed is not None:
        return scene
    return scene.with_values(
        {"wind": {"air_density": scene.wind.air_density, "speed": scene.wind.mean_speed}}
    )
