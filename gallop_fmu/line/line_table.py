"""Line data (code word, span, stringing tension, ice, wind), and the scene computed from them.

A scene file may have a table ``[line]`` in place of ``[span]``, ``[conductor]``, ``[ice]`` and so
on. The values of the scene are computed when the file is read, each with its source. Values in
sections alongside ``[line]`` replace computed values and change no others: with another conductor
mass, for example, the tension stays the same. A section with a ``kind`` replaces the whole section;
``[aerodynamics] outside = "hold"`` replaces this value only.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple, Self

from pydantic import ValidationError, model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.line.conductors import StrandedConductor, Wire, find_conductor
from gallop_fmu.line.ice_shapes import IceSection, IceShape, ice_section
from gallop_fmu.line.line_curve import ASSUMED, assumed_curve, line_curve
from gallop_fmu.scene.dotted_paths import SET_BY_USER
from gallop_fmu.scene.fields import Number, Section, Text, quantity, setting, unit_of_field
from gallop_fmu.scene.plausibility import check_possible, unusual
from gallop_fmu.scene.sag_tension import changed_tension, check_tension
from gallop_fmu.scene.validation_messages import explain
from gallop_fmu.scene.wind import MAX_WIND_SPEED

GRAVITY = 9.81
DRY_AIR = 101325.0 / 287.05
"""Pressure of the standard atmosphere over the gas constant of dry air [kg K/m3]."""

ONLY_IN_LINE = tuple(
    f"line.{name}"
    for name in ("ruling_span", "stringing_percent", "ice_thickness", "ice_density", "temperature")
)
"""Line data that are not values of a scene, so that the scene cannot check them."""

ZERO_CELSIUS = 273.15


class Line(Section):
    """Data of one span of a line.

    The bare conductor is strung at `stringing_tension` and `stringing_temperature`; the ice forms
    at `temperature`. The tension changes as in the `ruling_span` of the section, without creep.
    """

    conductor: Text = setting(
        ..., "code word of the conductor, such as Drake; `gallop-fmu conductors` lists them"
    )
    span: Number = quantity(..., "m", "horizontal distance between the supports", gt=0, le=10000)
    height_difference: Number = quantity(0.0, "m", "height of the right support above the left")
    ruling_span: Number | None = quantity(
        None, "m", "ruling span of the section (default: span)", gt=0
    )
    stringing_tension: Number | None = quantity(
        None, "N", "horizontal tension of the bare conductor at stringing", gt=0
    )
    stringing_percent: Number | None = quantity(
        None,
        "%",
        "horizontal tension at stringing in percent of the rated strength, in place of"
        " stringing_tension",
        gt=0,
        lt=100,
    )
    stringing_temperature: Number = quantity(
        15.0, "degC", "temperature at stringing", ge=-80, le=100
    )
    temperature: Number = quantity(
        0.0, "degC", "temperature of the iced conductor and the air", ge=-80, le=100
    )
    ice_shape: IceShape = setting(
        "crescent", "shape of the ice: radial, crescent, eccentric_circle or d_shape"
    )
    ice_thickness: Number = quantity(0.0, "m", "maximum ice thickness", ge=0, le=1)
    ice_density: Number = quantity(900.0, "kg/m3", "ice density", gt=0, le=1000)
    attack_angle_deg: Number = quantity(
        0.0,
        "deg",
        "attack angle of the wind on the ice; 0: the wind meets the thickest ice",
        ge=-360,
        le=360,
    )
    wind_speed: Number | None = quantity(
        None,
        "m/s",
        "constant wind speed; negative: from the other side",
        ge=-MAX_WIND_SPEED,
        le=MAX_WIND_SPEED,
    )
    coefficients: Text | None = setting(
        None,
        "coefficient curve: a CSV file with header angle_deg,lift,drag,moment, the name of a"
        " packaged curve (`gallop-fmu curves` lists them), or assumed (default with wind): an"
        " ASSUMED curve for the ice thickness, not measured",
    )
    insulator_length: Number | None = quantity(
        None,
        "m",
        "length of the suspension strings at both ends (default: dead ends)",
        gt=0,
    )
    insulator_weight: Number | None = quantity(
        None, "N", "weight of one string; required with insulator_length", ge=0
    )
    adjacent_span: Number | None = quantity(
        None, "m", "length of the spans beyond the strings (default: ruling_span)", gt=0
    )
    damping_percent: Number = quantity(0.5, "%", "damping ratio of translations", ge=0, lt=100)
    twist_damping_percent: Number = quantity(4.0, "%", "damping ratio of twist", ge=0, lt=100)

    @model_validator(mode="after")
    def _complete(self) -> Self:
        if (self.stringing_tension is None) == (self.stringing_percent is None):
            given = "neither" if self.stringing_tension is None else "both"
            raise SceneError(
                f"{given} of stringing_tension [N] and stringing_percent [% of rated strength]"
                " given; give exactly one"
            )
        if (self.insulator_length is None) != (self.insulator_weight is None):
            raise SceneError(
                "only one of insulator_length [m] and insulator_weight [N] given; give both, or"
                " neither for dead ends"
            )
        if self.insulator_length is None and self.adjacent_span is not None:
            raise SceneError(
                f"adjacent_span = {self.adjacent_span} m needs suspension strings; give"
                " insulator_length and insulator_weight, too"
            )
        return self


class _LineTable(Section):
    """A scene file with its table [line], so that errors have its path."""

    line: Line = setting(..., "line data")


class Value(NamedTuple):
    """A value of a scene, and its source."""

    value: Any
    source: str


def scene_data(data: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return scene data in which the table ``line`` is replaced by the values computed from it.

    Parameters
    ----------
    data
        Content of a scene file with a table ``line``. Values in its other sections replace computed
        values one by one; a section with a ``kind`` replaces the whole section.
    folder
        Folder of relative names of CSV files.

    Raises
    ------
    SceneError
        A value, code word or curve is not allowed; the message names the field.
    """
    try:
        line = _LineTable.model_validate({"line": data["line"]}).line
    except ValidationError as error:
        raise SceneError(explain(error, _LineTable)) from None
    numbers = numbers_of(line)
    check_possible(numbers)
    computed, sources = nested(line_values(line, folder, _conductor(line)))
    computed["notes"] = unusual(
        {path: value for path, value in numbers.items() if path in ONLY_IN_LINE}
    )
    given = {key: value for key, value in data.items() if key not in ("line", "sources")}
    _remove_contradictions(computed, sources, given)
    for key, value in given.items():
        merged = _merged(computed.get(key), value)
        if merged is not value:
            sources |= {f"{key}.{name}": SET_BY_USER for name in value}
        elif key not in ("title", "description"):
            sources[key] = SET_BY_USER
        computed[key] = merged
    computed["sources"] = {**sources, **data.get("sources", {})}
    return computed


def nested(values: Mapping[str, Value]) -> tuple[dict[str, Any], dict[str, str]]:
    """Return values as nested data, and their sources by dotted path."""
    nested: dict[str, Any] = {}
    for path, (value, _) in values.items():
        *parents, last = path.split(".")
        section = nested
        for parent in parents:
            section = section.setdefault(parent, {})
        section[last] = value
    return nested, {path: value.source for path, value in values.items() if value.source}


def _remove_contradictions(
    computed: dict[str, Any], sources: dict[str, str], given: Mapping[str, Any]
) -> None:
    """Remove computed values that contradict given ones."""
    ice, wind = given.get("ice"), given.get("wind")
    if isinstance(ice, Mapping) and {"first_moment_x2", "first_moment_x3"} & ice.keys():
        del computed["ice"]["first_moment_angle_deg"]  # given moments refer to the given angle
    has_history = isinstance(wind, Mapping) and "history" in wind and "speed" not in wind
    if has_history and "speed" in computed["wind"]:
        del computed["wind"]["speed"], sources["wind.speed"]


def numbers_of(line: Line) -> dict[str, tuple[float, str]]:
    """Return the numbers of a line with their units."""
    fields = Line.model_fields.items()
    given = {name: (getattr(line, name), unit_of_field(about)) for name, about in fields}
    return {
        f"line.{name}": (value, unit)
        for name, (value, unit) in given.items()
        if isinstance(value, float)
    }


def _merged(computed: Any, given: Any) -> Any:
    """Merge given values into computed ones; a given ``kind`` replaces the whole section."""
    if not isinstance(computed, dict) or not isinstance(given, dict) or "kind" in given:
        return given
    return {
        **computed,
        **{name: _merged(computed.get(name), value) for name, value in given.items()},
    }


def line_values(line: Line, folder: Path, wire: Wire) -> dict[str, Value]:
    """Return the values of the scene of one span by dotted path, each with its source."""
    ice = ice_section(line.ice_shape, wire.diameter, line.ice_thickness, line.ice_density)
    if line.ice_thickness == 0.0:
        ice = ice._replace(mass_per_length=0.0, first_moment=0.0, torsional_inertia=0.0)
    tension = _tension(line, wire, ice.mass_per_length)
    iced = iced_text(line)
    values = {
        "title": Value(f"{wire.code_word}, span of {line.span:g} m, {iced}", ""),
        "description": Value("Made from line data; see the sources of the values.", ""),
        **_span_values(line, tension),
        **_conductor_values(wire),
        **_ice_values(line, ice, iced),
        **_wind_values(line),
        **_damping_values(line, wire, ice, tension.value),
        "initial": Value(
            {"seed_vertical": 1e-3, "seed_horizontal": 1e-3}, "chosen: a small perturbation"
        ),
        "numerics": Value(
            {"elements": max(15, math.ceil(line.span / 20.0)), "time_step": 0.01},
            "chosen: elements of at most 20 m, and at least 15",
        ),
        "run": Value({"stop_time": 600.0, "record_every": 5}, "chosen"),
        "supports": _supports(line, tension.value),
    }
    if line.coefficients is not None or line.wind_speed:
        values["aerodynamics"] = _curve(line, wire, folder)
    return values


def iced_text(line: Line) -> str:
    """Ice of a line in words."""
    thickness = f"{1e3 * line.ice_thickness:g} mm of {line.ice_shape} ice"
    return thickness if line.ice_thickness else "bare"


GIVEN = "given with the line"


def _span_values(line: Line, tension: Value) -> dict[str, Value]:
    level = GIVEN if line.height_difference else "assumed: both supports at one height"
    return {
        "span.length": Value(line.span, GIVEN),
        "span.height_difference": Value(line.height_difference, level),
        "span.horizontal_tension": tension,
        "span.gravity": Value(GRAVITY, "standard value, rounded"),
    }


CONDUCTOR_FIELDS = (
    "diameter",
    "mass_per_length",
    "axial_stiffness",
    "torsional_stiffness",
    "torsional_inertia",
)
"""Values of the conductor of a scene of one span."""


def _conductor_values(wire: Wire) -> dict[str, Value]:
    name = wire.code_word
    return {
        **{
            f"conductor.{field}": Value(
                getattr(wire, field), f"{name}: {wire.value_sources[field]}"
            )
            for field in CONDUCTOR_FIELDS
        },
        "conductor.slack": Value("error", "chosen: a slack conductor is an error"),
    }


def _ice_values(line: Line, ice: IceSection, iced: str) -> dict[str, Value]:
    moments = ice.first_moments(math.radians(line.attack_angle_deg))
    source = (
        f"derived: {iced}, {line.ice_density:g} kg/m3, thickest ice rotated from the wind by the"
        " attack angle"
    )
    return {
        "ice": Value(
            {
                "mass_per_length": ice.mass_per_length,
                "torsional_inertia": ice.torsional_inertia,
                "first_moment_x2": moments[0],
                "first_moment_x3": moments[1],
                "first_moment_angle_deg": line.attack_angle_deg,
            },
            source,
        ),
        "ice.attack_angle_deg": Value(line.attack_angle_deg, GIVEN),
    }


def _wind_values(line: Line) -> dict[str, Value]:
    values = {
        "wind.air_density": Value(
            DRY_AIR / (ZERO_CELSIUS + line.temperature),
            f"dry air at standard pressure and {line.temperature:g} degrees Celsius",
        ),
        "wind.direction_deg": Value(0.0, "assumed: wind normal to the line"),
    }
    if line.wind_speed is not None:
        values["wind.speed"] = Value(line.wind_speed, GIVEN)
    return values


def _damping_values(line: Line, wire: Wire, ice: IceSection, tension: float) -> dict[str, Value]:
    """Equal damping ratios at the first swing or torsional frequency, and at twice that."""
    mass = wire.mass_per_length + ice.mass_per_length
    inertia = wire.torsional_inertia + ice.torsional_inertia
    swing = math.sqrt(tension / mass) / (2.0 * line.span)
    twist = math.sqrt(wire.torsional_stiffness / inertia) / (2.0 * line.span)
    return {
        "damping.translation": Value(
            _equal_ratios(0.01 * line.damping_percent, swing),
            f"assumed ratio, {line.damping_percent:g} %, at the first swing frequency, "
            "sqrt(H/m)/(2 L), and twice that",
        ),
        "damping.twist": Value(
            _equal_ratios(0.01 * line.twist_damping_percent, twist),
            f"assumed ratio, {line.twist_damping_percent:g} %, at the first torsional frequency, "
            "sqrt(GJ/I)/(2 L), and twice that",
        ),
    }


def _conductor(line: Line) -> StrandedConductor:
    try:
        return find_conductor(line.conductor)
    except SceneError as problem:
        raise SceneError(f"line.conductor: {problem}") from None


class Strung(NamedTuple):
    """Horizontal tension at stringing [N], and the words and question of a message about it."""

    tension: float
    given: str
    question: str


def strung_tension(line: Line, wire: Wire) -> Strung:
    """Return the horizontal tension of the bare conductor at stringing.

    Raises
    ------
    SceneError
        It is a share of an unknown rated strength, or more than the rated strength.
    """
    if line.stringing_tension is not None:
        strung = line.stringing_tension
        given, question = f"line.stringing_tension = {strung:g} N", "is it in kN?"
    elif wire.rated_strength is not None and line.stringing_percent is not None:
        strung = 0.01 * line.stringing_percent * wire.rated_strength
        given = (
            f"line.stringing_percent = {line.stringing_percent:g} % of the rated strength,"
            f" {strung:.4g} N,"
        )
        question = "check stringing_percent"
    else:
        raise SceneError(
            f"line.stringing_percent = {line.stringing_percent}: the table has no confirmed rated"
            f" strength of {wire.code_word}; give stringing_tension [N] instead"
        )
    if wire.rated_strength is not None and strung > wire.rated_strength:
        raise SceneError(
            f"line.stringing_tension = {strung} N is more than the rated strength of"
            f" {wire.code_word}, {wire.rated_strength:.6g} N; check the unit (N)"
        )
    return Strung(strung, given, question)


def _tension(line: Line, wire: Wire, ice_mass: float) -> Value:
    """Return the horizontal tension of the iced conductor [N]."""
    strung, given, question = strung_tension(line, wire)
    ruling, weight = line.ruling_span or line.span, wire.mass_per_length * GRAVITY
    check_tension(given, strung, weight, ruling, question)
    try:
        tension = changed_tension(
            strung,
            span=ruling,
            height_difference=0.0 if line.ruling_span else line.height_difference,
            weight=weight,
            new_weight=(wire.mass_per_length + ice_mass) * GRAVITY,
            axial_stiffness=wire.axial_stiffness,
            temperature_change=line.temperature - line.stringing_temperature,
            expansion=wire.thermal_expansion,
        )
    except SceneError as problem:
        raise SceneError(f"line: {problem}") from None
    if wire.rated_strength is not None and tension > wire.rated_strength:
        raise SceneError(
            f"line: the tension of the iced conductor is {tension:.4g} N, more than the rated"
            f" strength of {wire.code_word}, {wire.rated_strength:.6g} N; check stringing_tension,"
            " ruling_span and ice_thickness [m]"
        )
    where = f"a level ruling span of {ruling:g} m" if line.ruling_span else "the span"
    return Value(
        tension,
        f"derived: change of state in {where} from {strung:.6g} N, bare, at"
        f" {line.stringing_temperature:g} degrees Celsius to {line.temperature:g} degrees with"
        f" ice; E A and expansion {wire.thermal_expansion:.3g} 1/K from the wires, no creep",
    )


def _equal_ratios(ratio: float, frequency: float) -> dict[str, float]:
    return {
        "low_ratio": ratio,
        "low_frequency": frequency,
        "high_ratio": ratio,
        "high_frequency": 2.0 * frequency,
    }


def _curve(line: Line, wire: Wire, folder: Path) -> Value:
    """Return the coefficient curve, the assumed one if none is given."""
    if line.coefficients in (None, ASSUMED):
        return Value(*assumed_curve(line.ice_shape, line.ice_thickness / wire.diameter))
    return Value(*line_curve(str(line.coefficients), folder))


def _supports(line: Line, tension: float) -> Value:
    if line.insulator_length is None:
        rigid = {end: {"kind": "rigid"} for end in ("left", "right")}
        return Value(rigid, f"{GIVEN}: dead ends, assumed rigid")
    support = {
        "kind": "adjacent_span",
        "adjacent_span": line.adjacent_span or line.ruling_span or line.span,
        "adjacent_tension": tension,
        "insulator_length": line.insulator_length,
        "insulator_weight": line.insulator_weight,
    }
    return Value(
        {"left": dict(support), "right": dict(support)},
        f"{GIVEN}: suspension strings, and adjacent spans with the tension of this span",
    )
