"""The validated description of one iced span of an overhead line.

Nothing is computed here beyond checks: the kernel does the mechanics. Lengths in m, forces in N,
times in s; angles in degrees where the name ends in ``_deg``. Axes: x1 along the span, x2 up, x3
across it in the direction of the wind.
"""

from __future__ import annotations

import math
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
from gallop_fmu.scene.damping import Damping
from gallop_fmu.scene.dotted_paths import Leaf, leaves, replace_values, unknown_key
from gallop_fmu.scene.fields import Number, Section, Text, WholeNumber, quantity, setting
from gallop_fmu.scene.front_ends import resolved
from gallop_fmu.scene.loads import Load
from gallop_fmu.scene.plausibility import unusual
from gallop_fmu.scene.sag_tension import LARGEST_STRAIN, check_tension
from gallop_fmu.scene.supports import AdjacentSpanSupport, Supports
from gallop_fmu.scene.time_functions import Law
from gallop_fmu.scene.validation_messages import explain

SAG_TENSION_AGREEMENT = 0.05
"""Largest relative difference between a given sag and m g L^2/(8 H); published pairs differ by 1 to 2 %."""

DEEPEST_SAG = 5.0
"""Largest sag accepted, in parts of the span; a line has 0.1 at most."""

SHALLOWEST_SAG, DEEP_SAG = 5e-4, 0.25
"""Sags between which nothing is unusual, in parts of the span."""

LEAST_LIFT, LIFT_POINTS = 0.01, 73
"""Lift coefficient above which a section is not round, and angles at which it is looked for."""

FASTEST_WIND = 150.0
"""Highest wind speed accepted [m/s]."""


class Span(Section):
    """Geometry and initial state: from the sag, from the horizontal tension, or both held as a source prints them."""

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
                "give sag [m] or horizontal_tension [N]; without either the initial state is"
                " unknown"
            )
        if abs(self.height_difference) >= self.length:
            raise SceneError(
                f"height_difference = {self.height_difference} must be less than length ="
                f" {self.length} m either way"
            )
        return self

    @property
    def initial_state(self) -> Literal["from_sag", "from_tension", "held"]:
        """How the initial equilibrium follows: from one of sag and tension, or held where both are given."""
        if self.horizontal_tension is None:
            return "from_sag"
        return "from_tension" if self.sag is None else "held"


class Conductor(Section):
    """The conductor, without ice unless the scene's sources say that a value includes it."""

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
        "where tension would fall below zero: the run ends, or the conductor moves on without"
        " tension there",
    )


class Ice(Section):
    """Ice on the conductor: what it adds to the section, and how it is turned."""

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
        "initial attack angle of the wind on the ice; turns the first moments too",
        ge=-360,
        le=360,
    )
    first_moment_angle_deg: Number | None = quantity(
        None,
        "deg",
        "attack angle at which the first moments are given (default: attack_angle_deg of the same"
        " file)",
        ge=-360,
        le=360,
    )

    @model_validator(mode="before")
    @classmethod
    def _keep_angle_of_moments(cls, data: Any) -> Any:
        """Keep the attack angle that came with the first moments: a later change of it turns them."""
        if not isinstance(data, dict) or data.get("first_moment_angle_deg") is not None:
            return data
        if not (data.get("first_moment_x2") or data.get("first_moment_x3")):
            return data
        return {**data, "first_moment_angle_deg": data.get("attack_angle_deg", 0.0)}

    def first_moments(self, attack_angle: ArrayLike | None = None) -> tuple[Any, Any]:
        """First mass moments of the ice turned to an attack angle [rad]; by default to the initial one.

        Returns
        -------
        tuple
            Integrals of rho x2 dA and of rho x3 dA [kg], of the shape of `attack_angle`. An attack
            angle that is larger by an angle turns the section by that angle, as a twist does.
        """
        given = np.radians(
            self.attack_angle_deg
            if self.first_moment_angle_deg is None
            else self.first_moment_angle_deg
        )
        turn = (
            np.radians(self.attack_angle_deg) if attack_angle is None else np.asarray(attack_angle)
        ) - given
        sine, cosine = np.sin(turn), np.cos(turn)
        return (
            self.first_moment_x2 * cosine - self.first_moment_x3 * sine,
            self.first_moment_x2 * sine + self.first_moment_x3 * cosine,
        )


class Wind(Section):
    """Wind towards +x3, the same along the span: a constant speed or a history. Neither given: no wind."""

    air_density: Number = quantity(1.225, "kg/m3", "density of air", gt=0)
    speed: Number | None = quantity(None, "m/s", "constant wind speed", ge=0, le=FASTEST_WIND)
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
            if not 0.0 <= extreme <= FASTEST_WIND:
                raise SceneError(
                    f"history reaches {extreme} m/s; the speed must stay within 0 to"
                    f" {FASTEST_WIND} m/s"
                )
        return self

    @property
    def mean_speed(self) -> float:
        """The constant speed, or the `mean_value` of the history [m/s].

        That is the final value of a ramp, the value around a pulse, the mean of a harmonic and of a
        table.
        """
        return self.history.mean_value if self.history is not None else self.speed or 0.0

    @property
    def can_blow(self) -> bool:
        """Whether the wind speed is ever different from zero."""
        return self.history.extremes != (0.0, 0.0) if self.history else bool(self.speed)


class Initial(Section):
    """Start of the motion: a small first-mode seed, and whether the wind is already in equilibrium."""

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
        "wind at the start: applied at once to the still conductor, or in static equilibrium"
        " with it",
    )


class Numerics(Section):
    """Discretisation and tolerances."""

    elements: WholeNumber = quantity(15, "1", "number of three-node elements", ge=2, le=5000)
    integrator: Literal["newmark", "gauss6", "generalised_alpha"] | None = setting(
        None,
        "method, see gallop_fmu.foundation.integrators; not given: newmark, or gauss6 with a"
        " tolerance",
    )
    time_step: Number = quantity(
        0.01, "s", "time step; with a tolerance only the unit of run.record_every", gt=0, le=1
    )
    tolerance: Number | None = quantity(
        None,
        "1",
        "relative error of vertical and horizontal motion and of twist that chooses the steps, not"
        " time_step",
        ge=1e-8,
        le=0.1,
    )
    spectral_radius: Number | None = quantity(
        None,
        "1",
        "of generalised_alpha: factor a step on motion that no step resolves; else"
        f" {SPECTRAL_RADIUS}",
        ge=0,
        le=1,
    )
    newton_tolerance: Number = quantity(
        1e-9,
        "m",
        "change that ends Newton's iteration; a tolerance sets its own",
        ge=1e-14,
        le=1e-3,
    )
    max_newton_iterations: WholeNumber = quantity(
        20, "1", "iterations before a step is halved", ge=2, le=200
    )
    max_halvings: WholeNumber = quantity(
        8, "1", "times that a step may be halved before the run fails", ge=0, le=20
    )

    @model_validator(mode="before")
    @classmethod
    def _whole_span(cls, data: Any) -> Any:
        """Accept the `mesh` of files of release 0.1.0, which could ask for half of a span."""
        if not isinstance(data, dict) or "mesh" not in data:
            return data
        if data["mesh"] != "whole_span":
            raise SceneError(
                f"mesh = {data['mesh']!r}: only whole spans are computed, since half a span hides"
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
        """The integrator, given or by default."""
        return self.integrator or ("newmark" if self.tolerance is None else "gauss6")


class Run(Section):
    """How long to simulate and what to keep."""

    stop_time: Number = quantity(60.0, "s", "simulated time", gt=0)
    record_every: WholeNumber = quantity(
        1, "1", "time steps from one recorded state to the next", ge=1, le=1_000_000
    )


class Scene(Section):
    """One span: what it is, what acts on it, how it is computed, and where each number comes from."""

    title: Text = setting(..., "one line that names the scene")
    description: Text = setting("", "what the scene shows, assumptions, known gaps")
    notes: Annotated[tuple[Text, ...], Field(strict=False)] = setting(
        (), "doubts about the line data that the scene was made from; shown among its warnings"
    )
    span: Span = setting(..., "geometry and initial state")
    conductor: Conductor = setting(..., "conductor")
    ice: Ice = setting(Ice(), "ice")
    wind: Wind = setting(Wind(speed=0.0), "wind")
    aerodynamics: Aerodynamics | None = setting(
        None, "coefficient curve; needed as soon as wind blows"
    )
    supports: Supports = setting(Supports(), "supports")
    damping: Damping = setting(Damping(), "structural damping")
    loads: Annotated[tuple[Load, ...], Field(strict=False)] = setting((), "concentrated loads")
    initial: Initial = setting(Initial(), "start of the motion")
    numerics: Numerics = setting(Numerics(), "discretisation and tolerances")
    run: Run = setting(Run(), "duration and recording")
    sources: dict[Text, Text] = setting(
        {}, "source of each value: dotted path, or the start of one, to text"
    )

    @field_validator("sources", mode="before")
    @classmethod
    def _join_keys(cls, sources: Any) -> Any:
        return _flat(sources) if isinstance(sources, dict) else sources

    @model_validator(mode="after")
    def _consistent(self) -> Scene:
        _check_size_of_sag_and_tension(self)
        _check_sag_against_tension(self)
        _check_mass_matrix(self)
        _check_aerodynamics(self)
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
            The content of a scene file, with a table ``line`` or without (see
            `gallop_fmu.line.line_table.Line`).
        folder
            Where relative names of CSV files start.

        Raises
        ------
        SceneError
            One line per problem.
        """
        try:
            return cls.model_validate(
                resolved(data, Path(folder)), context={"folder": Path(folder)}
            )
        except ValidationError as error:
            raise SceneError(explain(error, cls)) from None
        except RecursionError:
            raise SceneError("the data are nested too deeply to be a scene") from None

    def to_toml(self) -> str:
        """The whole scene as TOML, defaults included; loading it gives an equal scene."""
        return tomli_w.dumps(self.model_dump(mode="json", exclude_none=True))

    def save(self, path: Path | str) -> None:
        """Write `to_toml` to a file."""
        write_whole(Path(path), self.to_toml().encode())

    def with_values(self, values: Mapping[str, Any]) -> Scene:
        """Copy with some values replaced, validated as a whole.

        Parameters
        ----------
        values
            Dotted path to new value, such as ``{"wind.speed": 6.0}``; a whole section as nested
            data or as a section; None removes what is optional. A changed value loses its source,
            if it had one, to "set by the user".

        Raises
        ------
        SceneError
            Unknown key, with the closest valid one, or a value that is not allowed.
        """
        resolved = [key for key in values if key.startswith("line.")]
        if resolved:
            raise SceneError(
                f"{resolved[0]}: a scene holds plain numbers, its line is resolved already; change"
                " the scene file, or vary this value with sweep, or with --set on the command line"
            )
        if {
            "ice.first_moment_x2",
            "ice.first_moment_x3",
        } & values.keys():  # given at the angle that the copy has
            values = {"ice.first_moment_angle_deg": None, **values}
        data = self.model_dump(mode="json", exclude_none=True)
        try:
            return type(self).from_dict(replace_values(type(self), data, values))
        except RecursionError:
            raise SceneError("the values are nested too deeply to be those of a scene") from None

    def numbers(self) -> dict[str, tuple[float | int, str, str]]:
        """Every value that is one number and is set: dotted path to (value, unit, meaning), in order of declaration."""
        return {
            leaf.path: (leaf.value, leaf.unit, leaf.meaning)
            for leaf in leaves(self)
            if isinstance(leaf.value, (int, float))
        }

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences on values that are unusual for a line, or that contradict each other; empty if there are none."""
        unusual_values = unusual(
            {path: (value, unit) for path, (value, unit, _) in self.numbers().items()}
        )
        doubts = [] if self.aerodynamics is None else self.aerodynamics.warnings()
        return (*self.notes, *unusual_values, *_doubts_of_sag(self), *doubts, *_doubts_of_ice(self))

    def unit_of(self, path: str) -> str:
        """Unit of the value at a dotted path, set or not; empty for texts and choices.

        Raises
        ------
        SceneError
            No value has this path; the message names the closest.
        """
        found: dict[str, Leaf] = {leaf.path: leaf for leaf in leaves(self)}
        if path not in found:
            raise SceneError(unknown_key(type(self), path))
        return found[path].unit


def _flat(nested: Mapping[str, Any], start: str = "") -> dict[str, Any]:
    """Join nested tables: an unquoted ``span.length`` in TOML is a table in a table."""
    flat: dict[str, Any] = {}
    for key, value in nested.items():
        flat |= _flat(value, f"{start}{key}.") if isinstance(value, dict) else {start + key: value}
    return flat


def _check_size_of_sag_and_tension(scene: Scene) -> None:
    span = scene.span
    weight = (scene.conductor.mass_per_length + scene.ice.mass_per_length) * span.gravity
    for end, support in (("left", scene.supports.left), ("right", scene.supports.right)):
        if isinstance(support, AdjacentSpanSupport):
            given = f"supports.{end}.adjacent_tension = {support.adjacent_tension:g} N"
            check_tension(given, support.adjacent_tension, weight, support.adjacent_span)
    if span.horizontal_tension is not None:
        given = f"span.horizontal_tension = {span.horizontal_tension:g} N"
        check_tension(given, span.horizontal_tension, weight, span.length)
    if span.sag is not None and span.sag > DEEPEST_SAG * span.length:
        raise SceneError(
            f"span.sag = {span.sag:g} m is more than {DEEPEST_SAG:g} times span.length ="
            f" {span.length:g} m; is it in cm or mm?"
        )


def _doubts_of_sag(scene: Scene) -> list[str]:
    span, found = scene.span, []
    weight = (
        (scene.conductor.mass_per_length + scene.ice.mass_per_length) * span.gravity * span.length
    )
    if span.sag is not None and not SHALLOWEST_SAG < span.sag / span.length < DEEP_SAG:
        found.append(
            f"span.sag = {span.sag:g} m is {span.sag / span.length:.3g} of span.length; usual are "
            f"{SHALLOWEST_SAG:g} to {DEEP_SAG:g}; check the units"
        )
    elif span.horizontal_tension is not None and 8.0 * DEEP_SAG * span.horizontal_tension < weight:
        found.append(
            f"span.horizontal_tension = {span.horizontal_tension:g} N is small for a weight of the"
            f" span of {weight:.4g} N: the sag is more than {DEEP_SAG:g} of span.length; check the"
            " units"
        )
    if (span.horizontal_tension or 0.0) > LARGEST_STRAIN * scene.conductor.axial_stiffness:
        found.append(
            f"span.horizontal_tension = {span.horizontal_tension:g} N is more than"
            f" {LARGEST_STRAIN:.0%} of conductor.axial_stiffness ="
            f" {scene.conductor.axial_stiffness:g} N, which no conductor bears; check the units"
            " (both in N)"
        )
    return found


def _doubts_of_ice(scene: Scene) -> list[str]:
    """A section whose ice is round has no lift."""
    if (
        scene.aerodynamics is None
        or scene.ice.first_moment_x2 != 0.0
        or scene.ice.first_moment_x3 != 0.0
    ):
        return []
    curve = scene.aerodynamics.curve()
    lift = float(
        abs(curve.lift(np.linspace(curve.breakpoint[0], curve.breakpoint[-1], LIFT_POINTS))).max()
    )
    if lift < LEAST_LIFT:
        return []
    return [
        "the first moments of the ice are 0, as of round ice or none, but the coefficient curve"
        f" has lift up to {lift:.3g}, which a round section has not; give the ice the shape of the"
        " curve ([line] ice_shape and ice_thickness, or [ice] first moments), or the curve of a"
        " round section"
    ]


def _check_sag_against_tension(scene: Scene) -> None:
    span = scene.span
    if span.sag is None or span.horizontal_tension is None:
        return
    mass = scene.conductor.mass_per_length + scene.ice.mass_per_length
    slope = math.hypot(1.0, span.height_difference / span.length)
    parabola = mass * span.gravity * span.length**2 / (8.0 * span.horizontal_tension) * slope
    if abs(span.sag - parabola) > SAG_TENSION_AGREEMENT * parabola:
        raise SceneError(
            f"span.sag = {span.sag} m and span.horizontal_tension = {span.horizontal_tension} N"
            f" contradict each other: m g L^2/(8 H) gives a sag of {parabola:.4g} m, and at most"
            f" {SAG_TENSION_AGREEMENT:.0%} difference is accepted; correct one, or give only one"
            " and let the other follow"
        )


def _check_mass_matrix(scene: Scene) -> None:
    ice = scene.ice
    mass = scene.conductor.mass_per_length + ice.mass_per_length
    inertia = scene.conductor.torsional_inertia + ice.torsional_inertia
    moments = ice.first_moment_x2**2 + ice.first_moment_x3**2
    if not inertia * mass > moments:
        raise SceneError(
            f"ice.first_moment_x2 = {ice.first_moment_x2} and ice.first_moment_x3 ="
            f" {ice.first_moment_x3} kg are too large: the sum of their squares, {moments:.4g},"
            f" must be less than inertia times mass, {inertia * mass:.4g} kg2 (else the mass matrix"
            " is not positive definite); check the units"
        )


def _check_aerodynamics(scene: Scene) -> None:
    if not scene.wind.can_blow:
        return
    curve, angle = scene.aerodynamics, scene.ice.attack_angle_deg
    if curve is None:
        raise SceneError(
            "wind is given but aerodynamics is not: a coefficient curve is needed to turn wind into"
            " force"
        )
    first, last = curve.range_deg
    reduced = angle - 360.0 * round((angle - 0.5 * (first + last)) / 360.0)
    if curve.beyond == "error" and not first <= reduced <= last:
        raise SceneError(
            f"ice.attack_angle_deg = {angle} lies outside the coefficient curve, which is valid"
            f" from {first} to {last} deg; choose an angle inside, or set aerodynamics.outside"
        )
