"""The validated description of one iced span of an overhead line.

Lengths in m, forces in N, times in s; angles in degrees where the name ends in ``_deg``. Axes: x1
along the span, x2 up, x3 across the span in the direction of the wind.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
import tomli_w
from numpy.typing import ArrayLike
from pydantic import Field, ValidationError, field_validator, model_validator

from gallop_fmu.foundation.atomic_write import write_whole
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.integrators import SPECTRAL_RADIUS
from gallop_fmu.scene.aerodynamics import Aerodynamics
from gallop_fmu.scene.consistency import check_consistency, unusual_combinations
from gallop_fmu.scene.damping import Damping
from gallop_fmu.scene.dotted_paths import Leaf, leaves, replace_values, unknown_key
from gallop_fmu.scene.fields import Number, Section, Text, WholeNumber, quantity, setting
from gallop_fmu.scene.file_format import FORMAT, without_format
from gallop_fmu.scene.front_ends import resolved
from gallop_fmu.scene.loads import Load
from gallop_fmu.scene.plausibility import unusual
from gallop_fmu.scene.supports import Supports
from gallop_fmu.scene.time_functions import Law
from gallop_fmu.scene.validation_messages import explain

MAX_WIND_SPEED = 150.0
"""Maximum wind speed [m/s]."""


class Span(Section):
    """Geometry and initial state, from the sag, the horizontal tension, or both prescribed."""

    length: Number = quantity(..., "m", "horizontal distance between the supports", gt=0, le=10000)
    height_difference: Number = quantity(0.0, "m", "height of the right support above the left")
    sag: Number | None = quantity(
        None, "m", "sag at mid-span, measured vertically from the chord", gt=0
    )
    horizontal_tension: Number | None = quantity(
        None, "N", "horizontal tension of the initial state", gt=0
    )
    gravity: Number = quantity(9.81, "m/s2", "acceleration of gravity", gt=0, le=100)

    @model_validator(mode="after")
    def _determined(self) -> Span:
        if self.sag is None and self.horizontal_tension is None:
            raise SceneError(
                "neither sag nor horizontal_tension is given, so the initial state is unknown; give"
                " sag [m] or horizontal_tension [N]"
            )
        if abs(self.height_difference) >= self.length:
            raise SceneError(
                f"height_difference = {self.height_difference} must be less than length ="
                f" {self.length} m either way"
            )
        return self

    @property
    def initial_state(self) -> Literal["from_sag", "from_tension", "held"]:
        """Source of the initial equilibrium: sag, tension, or both (``"held"``: prescribed)."""
        if self.horizontal_tension is None:
            return "from_sag"
        return "from_tension" if self.sag is None else "held"


class Conductor(Section):
    """The conductor; without ice, unless the scene's sources say that a value includes it."""

    diameter: Number = quantity(
        ..., "m", "diameter of the bare conductor, reference of the coefficients", gt=0, le=1
    )
    mass_per_length: Number = quantity(
        ..., "kg/m", "mass per unit length of the hanging conductor", gt=0
    )
    axial_stiffness: Number = quantity(..., "N", "axial stiffness EA", gt=0)
    torsional_stiffness: Number = quantity(..., "N m2/rad", "torsional stiffness GJ", gt=0)
    torsional_inertia: Number = quantity(
        ..., "kg m", "mass moment of inertia per unit length about x1", gt=0
    )
    slack: Literal["error", "tension_only"] = setting(
        "error",
        "at zero tension: end the run with an error, or continue with a slack conductor",
    )


class Ice(Section):
    """Ice on the conductor: mass, moments, and attack angle."""

    mass_per_length: Number = quantity(0.0, "kg/m", "mass of ice per unit length", ge=0)
    torsional_inertia: Number = quantity(
        0.0, "kg m", "moment of inertia of ice per unit length about x1", ge=0
    )
    first_moment_x2: Number = quantity(
        0.0, "kg", "first moment, integral of rho x2 dA (S_x3 of Liu et al. 2009)"
    )
    first_moment_x3: Number = quantity(
        0.0, "kg", "first moment, integral of rho x3 dA (S_x2 of Liu et al. 2009)"
    )
    attack_angle_deg: Number = quantity(
        0.0,
        "deg",
        "initial attack angle of the wind on the ice; also rotates the first moments",
        ge=-360,
        le=360,
    )
    first_moment_angle_deg: Number | None = quantity(
        None,
        "deg",
        "attack angle of the given first moments (default: attack_angle_deg of the same file)",
        ge=-360,
        le=360,
    )

    @model_validator(mode="before")
    @classmethod
    def _keep_angle_of_moments(cls, data: Any) -> Any:
        """Store the attack angle of the first moments; a later change of it rotates them."""
        if not isinstance(data, dict) or data.get("first_moment_angle_deg") is not None:
            return data
        if not (data.get("first_moment_x2") or data.get("first_moment_x3")):
            return data
        return {**data, "first_moment_angle_deg": data.get("attack_angle_deg", 0.0)}

    def first_moments(self, attack_angle: ArrayLike | None = None) -> tuple[Any, Any]:
        """Return the first mass moments of the ice at an attack angle [rad] (default: initial).

        Returns
        -------
        tuple
            Integrals of rho x2 dA and of rho x3 dA [kg], of the shape of `attack_angle`. A larger
            attack angle rotates the section like a twist.
        """
        given = np.radians(
            self.attack_angle_deg
            if self.first_moment_angle_deg is None
            else self.first_moment_angle_deg
        )
        rotation = (
            np.radians(self.attack_angle_deg) if attack_angle is None else np.asarray(attack_angle)
        ) - given
        sine, cosine = np.sin(rotation), np.cos(rotation)
        return (
            self.first_moment_x2 * cosine - self.first_moment_x3 * sine,
            self.first_moment_x2 * sine + self.first_moment_x3 * cosine,
        )


class Wind(Section):
    """Wind towards +x3, uniform along the span: a constant speed or a history (default: 0)."""

    air_density: Number = quantity(1.225, "kg/m3", "density of air", gt=0)
    speed: Number | None = quantity(None, "m/s", "constant wind speed", ge=0, le=MAX_WIND_SPEED)
    history: Law | None = quantity(None, "m/s", "wind speed over time")

    @model_validator(mode="before")
    @classmethod
    def _calm_unless_given(cls, data: Any) -> Any:
        if isinstance(data, dict) and data.get("speed") is None and data.get("history") is None:
            return {**data, "speed": 0.0}
        return data

    @model_validator(mode="after")
    def _one_wind(self) -> Wind:
        if self.history is None:
            return self
        if self.speed is not None:
            raise SceneError(
                f"speed = {self.speed} m/s and history are both given; give one of them (None"
                " removes the other)"
            )
        for extreme in self.history.extremes:
            if not 0.0 <= extreme <= MAX_WIND_SPEED:
                raise SceneError(
                    f"history reaches {extreme} m/s; the speed must stay within 0 to"
                    f" {MAX_WIND_SPEED} m/s"
                )
        return self

    @property
    def mean_speed(self) -> float:
        """The constant speed, or the `mean_value` of the history [m/s].

        The latter is the final value of a ramp, the value before and after a pulse, and the mean of
        a harmonic or a table.
        """
        return self.history.mean_value if self.history is not None else self.speed or 0.0

    @property
    def can_blow(self) -> bool:
        """True if the wind speed is not zero at all times."""
        return self.history.extremes != (0.0, 0.0) if self.history else bool(self.speed)


class Initial(Section):
    """Start of the motion: a small first-mode perturbation, and the initial action of the wind."""

    seed_vertical: Number = quantity(
        0.0, "m", "amplitude a of u2 = a cos(pi x1/L), x1 from mid-span"
    )
    seed_horizontal: Number = quantity(
        0.0, "m", "amplitude a of u3 = a cos(pi x1/L), x1 from mid-span"
    )
    seed_twist: Number = quantity(
        0.0, "rad", "amplitude a of the twist a cos(pi x1/L), x1 from mid-span"
    )
    wind: Literal["at_once", "mean_wind_equilibrium"] = setting(
        "at_once",
        "wind at the start: applied suddenly to the conductor at rest, or in static equilibrium",
    )


class Numerics(Section):
    """Discretisation and tolerances."""

    elements: WholeNumber = quantity(15, "1", "number of three-node elements", ge=2, le=5000)
    integrator: Literal["newmark", "gauss6", "generalised_alpha"] | None = setting(
        None,
        "integrator, see gallop_fmu.foundation.integrators (default: newmark; with a tolerance"
        " gauss6)",
    )
    time_step: Number = quantity(
        0.01,
        "s",
        "time step; with numerics.tolerance only the unit of run.record_every",
        gt=0,
        le=1,
    )
    tolerance: Number | None = quantity(
        None,
        "1",
        "relative error of vertical motion, horizontal motion and twist; controls the step size in"
        " place of time_step",
        ge=1e-8,
        le=0.1,
    )
    spectral_radius: Number | None = quantity(
        None,
        "1",
        "amplification factor of generalised_alpha per step for unresolved motion (default:"
        f" {SPECTRAL_RADIUS})",
        ge=0,
        le=1,
    )
    newton_tolerance: Number = quantity(
        1e-9,
        "m",
        "change that ends Newton's iteration; not used with numerics.tolerance",
        ge=1e-14,
        le=1e-3,
    )
    max_newton_iterations: WholeNumber = quantity(
        20, "1", "maximum number of iterations before a step is halved", ge=2, le=200
    )
    max_halvings: WholeNumber = quantity(
        8, "1", "maximum number of halvings of a step before the run fails", ge=0, le=20
    )

    @model_validator(mode="before")
    @classmethod
    def _whole_span(cls, data: Any) -> Any:
        """Accept the key `mesh` of release 0.1.0 if it is ``"whole_span"``."""
        if not isinstance(data, dict) or "mesh" not in data:
            return data
        if data["mesh"] != "whole_span":
            raise SceneError(
                f"mesh = {data['mesh']!r}: only whole spans are computed, as half a span excludes"
                " motion in 2, 4, ... loops; remove mesh"
            )
        return {key: value for key, value in data.items() if key != "mesh"}

    @model_validator(mode="after")
    def _fits_the_integrator(self) -> Numerics:
        if self.tolerance is not None and self.integrator not in (None, "gauss6"):
            raise SceneError(
                f'tolerance = {self.tolerance}: integrator = "{self.integrator}" takes equal steps;'
                ' choose "gauss6"'
            )
        if self.spectral_radius is not None and self.integrator != "generalised_alpha":
            raise SceneError(
                f'spectral_radius = {self.spectral_radius}: only integrator = "generalised_alpha"'
                " has one; choose it, or remove spectral_radius"
            )
        return self

    @property
    def method(self) -> Literal["newmark", "gauss6", "generalised_alpha"]:
        """The given or default integrator."""
        return self.integrator or ("newmark" if self.tolerance is None else "gauss6")


class Run(Section):
    """Duration and recording."""

    stop_time: Number = quantity(60.0, "s", "simulated time", gt=0)
    record_every: WholeNumber = quantity(
        1, "1", "number of time steps from one record to the next", ge=1, le=1_000_000
    )


class Scene(Section):
    """One span: structure, loads, numerics, and the source of each value."""

    title: Text = setting(..., "title, one line")
    description: Text = setting("", "purpose, assumptions and gaps")
    notes: Annotated[tuple[Text, ...], Field(strict=False)] = setting(
        (), "warnings about the line data of the scene"
    )
    span: Span = setting(..., "geometry and initial state")
    conductor: Conductor = setting(..., "conductor")
    ice: Ice = setting(Ice(), "ice")
    wind: Wind = setting(Wind(speed=0.0), "wind")
    aerodynamics: Aerodynamics | None = setting(None, "coefficient curve; required with wind")
    supports: Supports = setting(Supports(), "supports")
    damping: Damping = setting(Damping(), "structural damping")
    loads: Annotated[tuple[Load, ...], Field(strict=False)] = setting((), "concentrated loads")
    initial: Initial = setting(Initial(), "start of the motion")
    numerics: Numerics = setting(Numerics(), "discretisation and tolerances")
    run: Run = setting(Run(), "duration and recording")
    sources: dict[Text, Text] = setting({}, "dotted path of a value or section to its source")

    @field_validator("sources", mode="before")
    @classmethod
    def _join_keys(cls, sources: Any) -> Any:
        return _flat(sources) if isinstance(sources, dict) else sources

    @model_validator(mode="after")
    def _consistent(self) -> Scene:
        check_consistency(self)
        paths = [leaf.path for leaf in leaves(self)]
        for source in self.sources:
            if not any(path == source or path.startswith(source + ".") for path in paths):
                raise SceneError(unknown_key(Scene, f"sources.{source}", source))
        return self

    @classmethod
    def from_dict(cls, data: Mapping[str, Any], folder: Path | str = ".") -> Scene:
        """Validate nested plain data.

        Parameters
        ----------
        data
            Content of a scene file, with or without a table ``line`` (see
            `gallop_fmu.line.line_table.Line`) and ``format`` (default: 1).
        folder
            Where relative names of CSV files start.

        Raises
        ------
        SceneError
            One line per problem.
        """
        try:
            scene_data = resolved(without_format(data), Path(folder))
            return cls.model_validate(scene_data, context={"folder": Path(folder)})
        except ValidationError as error:
            raise SceneError(explain(error, cls)) from None
        except RecursionError:
            raise SceneError(
                "the data are nested too deeply for a scene; give flatter ones"
            ) from None

    def to_toml(self) -> str:
        """Return the whole scene as TOML, with all defaults; loading it gives an equal scene."""
        data = self.model_dump(mode="json", exclude_none=True)
        return tomli_w.dumps({"format": FORMAT, **data})

    def save(self, path: Path | str) -> None:
        """Write `to_toml` to a file."""
        write_whole(Path(path), self.to_toml().encode())

    def with_values(self, values: Mapping[str, Any]) -> Scene:
        """Return a copy with replaced values, validated as a whole.

        Parameters
        ----------
        values
            Dotted path to new value, such as ``{"wind.speed": 6.0}``. A path may also name a whole
            section; its new value is then a dictionary or an object. None removes an optional
            value. The scene notes "set by the user" as the source of a changed value.

        Raises
        ------
        SceneError
            A key is unknown (the message names the closest), or a value is not allowed.
        """
        resolved = [key for key in values if key.startswith("line.")]
        if resolved:
            raise SceneError(
                f"{resolved[0]}: a loaded scene no longer has its [line]; change the scene file, or"
                " vary this value with sweep, or with --set on the command line"
            )
        if {"ice.first_moment_x2", "ice.first_moment_x3"} & values.keys():
            # New first moments refer to the attack angle of the copy.
            values = {"ice.first_moment_angle_deg": None, **values}
        data = self.model_dump(mode="json", exclude_none=True)
        try:
            return type(self).from_dict(replace_values(type(self), data, values))
        except RecursionError:
            raise SceneError("the values are nested too deeply for a scene") from None

    def numbers(self) -> dict[str, tuple[float | int, str, str]]:
        """All single numbers of the scene: dotted path to (value, unit, meaning)."""
        return {
            leaf.path: (leaf.value, leaf.unit, leaf.meaning)
            for leaf in leaves(self)
            if isinstance(leaf.value, (int, float))
        }

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings about unusual values, each a fact and a remedy."""
        unusual_values = unusual(
            {path: (value, unit) for path, (value, unit, _) in self.numbers().items()}
        )
        return (*self.notes, *unusual_values, *unusual_combinations(self))

    def unit_of(self, path: str) -> str:
        """Return the unit of the value at a dotted path; empty for texts and choices.

        Raises
        ------
        SceneError
            The path does not exist; the message names the closest.
        """
        found: dict[str, Leaf] = {leaf.path: leaf for leaf in leaves(self)}
        if path not in found:
            raise SceneError(unknown_key(type(self), path))
        return found[path].unit


def _flat(nested: Mapping[str, Any], start: str = "") -> dict[str, Any]:
    """Join nested tables; an unquoted ``span.length`` in TOML is a table in a table."""
    flat: dict[str, Any] = {}
    for key, value in nested.items():
        flat |= _flat(value, f"{start}{key}.") if isinstance(value, dict) else {start + key: value}
    return flat
