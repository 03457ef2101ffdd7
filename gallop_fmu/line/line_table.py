"""A line as an engineer knows it: code word, span, stringing tension, ice, wind. Turned into the numbers of a scene.

A scene file may hold a ``[line]`` table instead of its ``[span]``, ``[conductor]``, ``[ice]`` and
so on. What follows from it is filled in when the file is read, each value with its source; values
in sections beside ``[line]`` replace those that follow, without changing others: the tension, for
one, stays that of the conductor in the table. A section beside it that gives a ``kind`` replaces
the whole section, while ``[aerodynamics] outside = "hold"`` changes that value alone.
"""

from __future__ import annotations

import difflib
import math
import tomllib
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any, Self

from pydantic import ValidationError, model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import packaged_names, packaged_text, read_table
from gallop_fmu.line.conductors import StrandedConductor, find_conductor
from gallop_fmu.line.ice_shapes import IceShape, ice_section
from gallop_fmu.scene.aerodynamics import CURVE_COLUMNS
from gallop_fmu.scene.dotted_paths import SET_BY_USER
from gallop_fmu.scene.fields import Number, Section, Text, quantity, setting, unit_of_field
from gallop_fmu.scene.plausibility import check_possible, unusual
from gallop_fmu.scene.sag_tension import changed_tension, check_tension
from gallop_fmu.scene.validation_messages import explain

GRAVITY = 9.81
DRY_AIR = 101325.0 / 287.05
"""Pressure of the standard atmosphere over the gas constant of dry air [kg K/m3]."""

ONLY_IN_LINE = tuple(
    f"line.{name}"
    for name in ("ruling_span", "stringing_percent", "ice_thickness", "ice_density", "temperature")
)
"""Numbers of a line that a scene does not hold, so that it cannot judge them itself."""

ZERO_CELSIUS = 273.15


class Line(Section):
    """One span of a line in familiar numbers.

    The conductor is strung bare, at `stringing_tension` and `stringing_temperature`; the ice then
    comes at `temperature`. The tension changes as in the `ruling_span` of the section, without
    creep.
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
    ice_shape: IceShape = setting("crescent", "shape of the ice, see gallop_fmu.line.ice_shapes")
    ice_thickness: Number = quantity(0.0, "m", "maximum ice thickness", ge=0, le=1)
    ice_density: Number = quantity(900.0, "kg/m3", "ice density", gt=0, le=1000)
    attack_angle_deg: Number = quantity(
        0.0,
        "deg",
        "attack angle of the wind on the ice; 0: the wind meets the thickest ice",
        ge=-360,
        le=360,
    )
    wind_speed: Number | None = quantity(None, "m/s", "constant wind speed", ge=0)
    coefficients: Text | None = setting(
        None,
        "coefficient curve: a CSV file with header angle_deg,lift,drag,moment, or the name of a"
        " packaged scene",
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
                "give exactly one of stringing_tension [N] and stringing_percent [% of rated"
                f" strength]; {given} given"
            )
        if self.wind_speed and self.coefficients is None:
            raise SceneError(
                f"wind_speed = {self.wind_speed} m/s needs coefficients, the curve that turns wind"
                " into force: a CSV file with header angle_deg,lift,drag,moment, or the name of a"
                " packaged scene to take its curve"
            )
        if (self.insulator_length is None) != (self.insulator_weight is None):
            raise SceneError(
                "give both insulator_length [m] and insulator_weight [N], or neither for dead ends"
            )
        if self.insulator_length is None and self.adjacent_span is not None:
            raise SceneError(
                f"adjacent_span = {self.adjacent_span} m acts through suspension strings; give"
                " insulator_length and insulator_weight too"
            )
        return self


class _LineTable(Section):
    """The table as it stands in a file, so that errors name its path."""

    line: Line = setting(..., "a line in familiar numbers")


def scene_data(data: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Nested data of a scene, with what follows from its ``line`` table in place of that table.

    Parameters
    ----------
    data
        Content of a scene file with a table ``line``; its other sections win, value by value, or as
        a whole where they give a ``kind``.
    folder
        Where relative names of CSV files start.

    Raises
    ------
    SceneError
        Bad value, unknown code word or curve; the message names the field.
    """
    given = {key: value for key, value in data.items() if key != "line"}
    try:
        line = _LineTable.model_validate({"line": data["line"]}).line
    except ValidationError as error:
        raise SceneError(explain(error, _LineTable)) from None
    numbers = _numbers(line)
    check_possible(numbers)
    followed, sources = _resolve(line, folder)
    followed["notes"] = unusual(
        {path: value for path, value in numbers.items() if path in ONLY_IN_LINE}
    )
    beside = given.get("ice")
    if isinstance(beside, dict) and {"first_moment_x2", "first_moment_x3"} & beside.keys():
        del followed["ice"][
            "first_moment_angle_deg"
        ]  # moments beside the line are given at the angle beside it
    for key, value in given.items():
        if key == "sources":
            continue
        merged = _merged(followed.get(key), value)
        if merged is value:
            sources |= {} if key in ("title", "description") else {key: SET_BY_USER}
        else:
            sources |= {f"{key}.{name}": SET_BY_USER for name in value}
        followed[key] = merged
    wind = given.get("wind", {})
    if "history" in wind and "speed" not in wind and line.wind_speed is not None:
        del followed["wind"]["speed"], sources["wind.speed"]
    followed["sources"] = {**sources, **given.get("sources", {})}
    return followed


def _numbers(line: Line) -> dict[str, tuple[float, str]]:
    """Numbers that are given, with their units."""
    fields = Line.model_fields.items()
    given = {name: (getattr(line, name), unit_of_field(about)) for name, about in fields}
    return {
        f"line.{name}": (value, unit)
        for name, (value, unit) in given.items()
        if isinstance(value, float)
    }


def _merged(followed: Any, given: Any) -> Any:
    """What follows from the line with given values in their place; a given ``kind`` replaces the whole section."""
    if not isinstance(followed, dict) or not isinstance(given, dict) or "kind" in given:
        return given
    return {
        **followed,
        **{name: _merged(followed.get(name), value) for name, value in given.items()},
    }


def _resolve(line: Line, folder: Path) -> tuple[dict[str, Any], dict[str, str]]:
    """Sections of the scene, and the source of each value."""
    wire = _conductor(line)
    ice = ice_section(line.ice_shape, wire.diameter, line.ice_thickness, line.ice_density)
    if line.ice_thickness == 0.0:
        ice = ice._replace(mass_per_length=0.0, first_moment=0.0, torsional_inertia=0.0)
    moments = ice.first_moments(math.radians(line.attack_angle_deg))
    tension, how = _tension(line, wire, ice.mass_per_length)
    mass = wire.mass_per_length + ice.mass_per_length
    inertia = wire.torsional_inertia + ice.torsional_inertia
    swing = math.sqrt(tension / mass) / (2.0 * line.span)
    twist = math.sqrt(wire.torsional_stiffness / inertia) / (2.0 * line.span)
    iced = (
        f"{1e3 * line.ice_thickness:g} mm of {line.ice_shape} ice" if line.ice_thickness else "bare"
    )
    data: dict[str, Any] = {
        "title": f"{wire.code_word}, span of {line.span:g} m, {iced}",
        "description": (
            "Made from a line's familiar numbers; the sources say what was given, tabulated and"
            " assumed."
        ),
        "span": {
            "length": line.span,
            "height_difference": line.height_difference,
            "horizontal_tension": tension,
            "gravity": GRAVITY,
        },
        "conductor": {
            "diameter": wire.diameter,
            "mass_per_length": wire.mass_per_length,
            "axial_stiffness": wire.axial_stiffness,
            "torsional_stiffness": wire.torsional_stiffness,
            "torsional_inertia": wire.torsional_inertia,
        },
        "ice": {
            "mass_per_length": ice.mass_per_length,
            "torsional_inertia": ice.torsional_inertia,
            "first_moment_x2": moments[0],
            "first_moment_x3": moments[1],
            "attack_angle_deg": line.attack_angle_deg,
            "first_moment_angle_deg": line.attack_angle_deg,
        },
        "wind": {"air_density": DRY_AIR / (ZERO_CELSIUS + line.temperature)},
        "damping": {
            "translation": _equal_ratios(0.01 * line.damping_percent, swing),
            "twist": _equal_ratios(0.01 * line.twist_damping_percent, twist),
        },
        "initial": {"seed_vertical": 1e-3, "seed_horizontal": 1e-3},
        "numerics": {"elements": max(15, math.ceil(line.span / 20.0)), "time_step": 0.01},
        "run": {"stop_time": 600.0, "record_every": 5},
    }
    given, name = "given with the line", wire.code_word
    level = given if line.height_difference else "assumed: both supports at one height"
    sources = {
        "span.length": given,
        "span.height_difference": level,
        "span.horizontal_tension": how,
        "span.gravity": "standard value, rounded",
        "conductor.diameter": f"{name}: {wire.source}",
        "conductor.mass_per_length": f"{name}: {wire.source}",
        "conductor.axial_stiffness": (
            f"{name}: derived, E A of {wire.aluminium_wires} aluminium wires "
            f"({wire.aluminium_modulus / 1e9:g} GPa) and {wire.steel_wires} steel wires (190 GPa)"
        ),
        "conductor.torsional_stiffness": (
            f"{name}: estimated, 5 GPa times pi d^4/32; uncertain by a factor of two"
        ),
        "conductor.torsional_inertia": f"{name}: derived, wires in concentric layers",
        "conductor.slack": "chosen: a conductor that goes slack is an error",
        "ice": (
            f"derived: {iced}, {line.ice_density:g} kg/m3, thickest ice turned by the attack angle"
            " from the wind"
        ),
        "ice.attack_angle_deg": given,
        "wind.air_density": (
            f"dry air of the standard atmosphere's pressure at {line.temperature:g} degrees Celsius"
        ),
        "damping.translation": (
            f"assumed ratio, {line.damping_percent:g} %, at the first swing frequency, "
            "sqrt(H/m)/(2 L), and twice that"
        ),
        "damping.twist": (
            f"assumed ratio, {line.twist_damping_percent:g} %, at the first torsional frequency, "
            "sqrt(GJ/I)/(2 L), and twice that"
        ),
        "initial": "chosen: a small disturbance to grow from",
        "numerics": "chosen: elements of at most 20 m, and at least 15",
        "run": "chosen",
    }
    if line.wind_speed is not None:
        data["wind"]["speed"] = line.wind_speed
        sources["wind.speed"] = given
    if line.coefficients is not None:
        data["aerodynamics"], sources["aerodynamics"] = _curve(line.coefficients, folder)
    data["supports"], sources["supports"] = _supports(line, tension)
    return data, sources


def _conductor(line: Line) -> StrandedConductor:
    try:
        return find_conductor(line.conductor)
    except SceneError as problem:
        raise SceneError(f"line.conductor: {problem}") from None


def _tension(line: Line, wire: StrandedConductor, ice_mass: float) -> tuple[float, str]:
    """Horizontal tension of the iced conductor [N], and how it follows."""
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
            f"line.stringing_percent = {line.stringing_percent}: no confirmed rated strength of"
            f" {wire.code_word} is in the table; give stringing_tension [N] instead"
        )
    if wire.rated_strength is not None and strung > wire.rated_strength:
        raise SceneError(
            f"line.stringing_tension = {strung} N is more than the rated strength of"
            f" {wire.code_word}, {wire.rated_strength:.6g} N; check the unit (N)"
        )
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
            f"line: the iced conductor would hang at {tension:.4g} N, more than the rated strength"
            f" of {wire.code_word}, {wire.rated_strength:.6g} N; check stringing_tension,"
            " ruling_span and ice_thickness [m]"
        )
    where = (
        f"a ruling span of {ruling:g} m, taken as level," if line.ruling_span else "the span itself"
    )
    return (
        tension,
        (
            f"derived: change of state in {where} from {strung:.6g} N, bare, at"
            f" {line.stringing_temperature:g} degrees Celsius to {line.temperature:g} degrees with"
            f" ice; E A and expansion {wire.thermal_expansion:.3g} 1/K from the wires, no creep"
        ),
    )


def _equal_ratios(ratio: float, frequency: float) -> dict[str, float]:
    return {
        "low_ratio": ratio,
        "low_frequency": frequency,
        "high_ratio": ratio,
        "high_frequency": 2.0 * frequency,
    }


@cache
def _packaged_curves() -> dict[str, dict[str, Any]]:
    """The packaged scenes that have a coefficient curve."""
    folder = "scene/packaged"
    scenes = {
        scene: tomllib.loads(packaged_text(folder, f"{scene}.toml"))
        for scene in packaged_names(folder, ".toml")
    }
    return {scene: content for scene, content in scenes.items() if "aerodynamics" in content}


def _curve(name: str, folder: Path) -> tuple[dict[str, Any], str]:
    """Coefficients of a packaged scene or of a CSV file, and their source."""
    curves = _packaged_curves()
    if name in curves:
        source = curves[name]["sources"]["aerodynamics"]
        return dict(curves[name]["aerodynamics"]), f"curve of the packaged scene {name}: {source}"
    path = folder / name
    if path.suffix.lower() != ".csv" and not path.exists():
        closest = difflib.get_close_matches(name, curves, n=1, cutoff=0.0)[0]
        raise SceneError(
            f"line.coefficients = {name!r}: neither a CSV file nor a packaged scene with a curve"
            f" (there are {', '.join(curves)}); closest: {closest}"
        )
    table = read_table(path, CURVE_COLUMNS)
    return {"kind": "table", **table.columns}, f"given with the line: {path.name}"


def _supports(line: Line, tension: float) -> tuple[dict[str, Any], str]:
    if line.insulator_length is None:
        return {
            end: {"kind": "rigid"} for end in ("left", "right")
        }, "given with the line: dead ends, taken as rigid"
    beside = {
        "kind": "adjacent_span",
        "adjacent_span": line.adjacent_span or line.ruling_span or line.span,
        "adjacent_tension": tension,
        "insulator_length": line.insulator_length,
        "insulator_weight": line.insulator_weight,
    }
    return (
        {"left": dict(beside), "right": dict(beside)},
        (
            "given with the line: suspension strings, and spans beyond them under the tension of"
            " this one"
        ),
    )
