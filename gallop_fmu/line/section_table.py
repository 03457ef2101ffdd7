"""A section from a table of towers, a conductor and stringing data."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any, Literal

from pydantic import ValidationError, model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.line.cable_catalogue import find_cable
from gallop_fmu.line.conductors import Wire, find_conductor
from gallop_fmu.line.line_table import (
    GRAVITY,
    ONLY_IN_LINE,
    Line,
    Value,
    iced_text,
    line_values,
    nested,
    numbers_of,
    strung_tension,
)
from gallop_fmu.line.tower_table import Tower, TowerTable, read_towers
from gallop_fmu.scene.fields import Number, Section, Text, WholeNumber, quantity, setting
from gallop_fmu.scene.plausibility import check_possible, unusual
from gallop_fmu.scene.sag_tension import ruling_span
from gallop_fmu.scene.validation_messages import explain

ONE_SPAN_ONLY = ("span", "height_difference", "ruling_span", "adjacent_span")
"""Line data of one span, which a section has in its table of towers."""

MAX_ELEMENT = 20.0
"""Maximum length of an element [m]."""

MIN_ELEMENTS = 15
"""Minimum number of elements of a span."""


class SectionTable(Section):
    """Data of a section in addition to those of a line, such as conductor, tension and ice.

    `insulator_length` and `insulator_weight` of the line are those of suspension strings without
    their own in the table.
    """

    section: Text = setting(
        ..., "table of towers and spans (.csv), also a section table of mechaphlowers"
    )
    catalogue: Text | None = setting(
        None, "cable catalogue of mechaphlowers (.csv) that has the conductor"
    )
    stringing_parameter: Number | None = quantity(
        None,
        "m",
        "horizontal tension over weight per unit length of the bare conductor at stringing, in"
        " place of stringing_tension",
        gt=0,
    )
    subconductors: WholeNumber = quantity(1, "1", "number of subconductors", ge=1, le=8)
    spacing: Number | None = quantity(
        None, "m", "distance of neighbouring subconductors in a bundle", gt=0
    )
    spacers: WholeNumber | None = quantity(
        None, "1", "number of spacers in each span of a bundle", ge=0, le=1000
    )
    orientation: Literal["horizontal", "vertical"] | None = setting(
        None, "arrangement of a twin bundle"
    )

    @model_validator(mode="after")
    def _bundle_has_spacing(self) -> SectionTable:
        if self.subconductors > 1 and self.spacing is None:
            raise SceneError(f"subconductors = {self.subconductors} need spacing [m]; give it, too")
        return self


def section_data(options: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return the data of a `LineScene`, every value with its source.

    Parameters
    ----------
    options
        Values of `SectionTable` and of `Line`, without those of `ONE_SPAN_ONLY`.
    folder
        Folder of relative names of files.

    Raises
    ------
    SceneError
        A value is not allowed; the message names the field, or file and row.
    """
    for name in ONE_SPAN_ONLY:
        if name in options:
            raise SceneError(
                f"{name} = {options[name]}: a section has its spans in the table of towers; remove"
                f" {name}"
            )
    own = {name: value for name, value in options.items() if name in SectionTable.model_fields}
    given = {name: value for name, value in options.items() if name not in own}
    try:
        table = SectionTable.model_validate(own)
    except ValidationError as error:
        raise SceneError(explain(error, SectionTable)) from None
    towers = read_towers(folder / table.section, GRAVITY)
    wire = _wire(str(given.get("conductor", "")), table, folder)
    line = _line(given, table, towers, wire)
    values = line_values(line, folder, wire)
    for path in list(values):
        if path.startswith("span.") or path == "supports":
            del values[path]
    computed, sources = nested(values | _section_values(line, table, towers, wire))
    numbers = numbers_of(line)
    computed["notes"] = [
        *towers.notes,
        *unusual({path: value for path, value in numbers.items() if path in ONLY_IN_LINE}),
    ]
    return {**computed, "sources": sources}


def _wire(name: str, table: SectionTable, folder: Path) -> Wire:
    if table.catalogue is not None:
        return find_cable(folder / table.catalogue, name)
    try:
        return find_conductor(name)
    except SceneError as problem:
        raise SceneError(
            f"conductor: {problem}; a cable of mechaphlowers needs its catalogue"
        ) from None


def _line(given: Mapping[str, Any], table: SectionTable, towers: TowerTable, wire: Wire) -> Line:
    """Return the line data of the ruling span, with the tension of the strung state."""
    values = dict(given)
    parameters = {
        "stringing_parameter": table.stringing_parameter,
        f"sagging_parameter of {towers.file}": towers.parameter,
    }
    tensions = [name for name, value in parameters.items() if value is not None]
    tensions += [name for name in ("stringing_tension", "stringing_percent") if name in values]
    if len(tensions) > 1:
        raise SceneError(f"{tensions[0]} and {tensions[1]} are both given; give only one of them")
    parameter = table.stringing_parameter or towers.parameter
    if parameter is not None:
        values["stringing_tension"] = parameter * wire.mass_per_length * GRAVITY
    if towers.temperature is not None:
        if "stringing_temperature" in values:
            raise SceneError(
                f"stringing_temperature and sagging_temperature of {towers.file} are both given;"
                " give only one of them"
            )
        values["stringing_temperature"] = towers.temperature
    values["span"] = ruling_span([tower.span_length or 0.0 for tower in towers.towers[:-1]])
    try:
        line = Line.model_validate(values)
    except ValidationError as error:
        raise SceneError(explain(error, Line)) from None
    check_possible(numbers_of(line))
    return line


def _section_values(
    line: Line, table: SectionTable, towers: TowerTable, wire: Wire
) -> dict[str, Value]:
    """Return the values that a section has in place of those of one span."""
    rows = towers.towers
    spans = [_span(table, left, right) for left, right in pairwise(rows)]
    level = all(tower.attachment_height is None for tower in rows)
    heights = "; level: no attachment heights given" if level else " and attachment heights"
    iced = iced_text(line)
    values = {
        "title": Value(f"{wire.code_word}, section of {len(spans)} spans, {iced}", ""),
        "description": Value(
            f"Made from the table {towers.file} of towers {rows[0].name} to {rows[-1].name}; see"
            " the sources of the values.",
            "",
        ),
        "section.horizontal_tension": Value(
            strung_tension(line, wire).tension, _tension_source(line, table, towers)
        ),
        "section.strung_with_ice": Value(False, "strung bare"),
        "section.strung_temperature_deg_c": Value(line.stringing_temperature, _GIVEN),
        "section.temperature_deg_c": Value(line.temperature, _GIVEN),
        "section.gravity": Value(GRAVITY, "standard value, rounded"),
        "section.spans": Value(spans, f"table {towers.file}: span lengths{heights}"),
        "section.suspensions": Value(
            [_suspension(line, tower, towers.file) for tower in rows[1:-1]],
            f"table {towers.file}: towers {', '.join(tower.name for tower in rows[1:-1])}",
        ),
        "conductor.thermal_expansion": Value(
            wire.thermal_expansion, f"{wire.code_word}: {wire.value_sources['thermal_expansion']}"
        ),
        "numerics.elements": Value(MIN_ELEMENTS, f"chosen: at most {MAX_ELEMENT:g} m long"),
    }
    for side, tower in (("left", rows[0]), ("right", rows[-1])):
        values[f"section.{side}_end"] = _end(table, tower, towers.file)
    if wire.rated_strength is not None:
        values["section.rated_strength"] = Value(
            wire.rated_strength, f"{wire.code_word}: {wire.value_sources['rated_strength']}"
        )
    bundle = {
        name: value
        for name in ("subconductors", "spacing", "spacers", "orientation")
        if (value := getattr(table, name)) is not None
    }
    if bundle != {"subconductors": 1}:
        values["bundle"] = Value(bundle, _GIVEN)
    return values


_GIVEN = "given with the section"


def _tension_source(line: Line, table: SectionTable, towers: TowerTable) -> str:
    if towers.parameter is not None:
        return f"sagging_parameter {towers.parameter:g} m of {towers.file} times m g, bare"
    if table.stringing_parameter is not None:
        return f"stringing_parameter {table.stringing_parameter:g} m times m g, bare"
    if line.stringing_percent is not None:
        return f"{line.stringing_percent:g} % of the rated strength, bare"
    return _GIVEN


def _span(table: SectionTable, left: Tower, right: Tower) -> dict[str, Any]:
    """Return the data of the span between two towers."""
    length = left.span_length or 0.0
    span: dict[str, Any] = {"length": length}
    if left.attachment_height is not None and right.attachment_height is not None:
        span["height_difference"] = right.attachment_height - left.attachment_height
    elements = max(MIN_ELEMENTS, math.ceil(length / MAX_ELEMENT), 2 * ((table.spacers or 0) + 1))
    return span if elements == MIN_ELEMENTS else {**span, "elements": elements}


def _suspension(line: Line, tower: Tower, file: str) -> dict[str, Any]:
    """Return the data of the suspension at a tower."""
    if tower.kind == "post":
        return {"kind": "post"}
    length, weight = tower.string_length, tower.string_weight
    if length is None:
        length = line.insulator_length
    if weight is None:
        weight = line.insulator_weight
    if length is None or weight is None:
        missing = "string_length [m]" if length is None else "string_weight [N]"
        raise SceneError(
            f"{file}: row {tower.row}: suspension tower {tower.name} has no {missing}; give it in"
            " the table, or insulator_length and insulator_weight for all strings, or the type post"
        )
    found = {"kind": tower.kind, "length": length, "weight": weight}
    if tower.kind == "string":
        return found
    if not tower.half_spread:
        raise SceneError(
            f"{file}: row {tower.row}: tower {tower.name} has a V-string without half_spread [m];"
            " give half the distance of its tower points"
        )
    # The table has the weight of the whole V-string.
    return {**found, "weight": 0.5 * weight, "half_spread": tower.half_spread}


def _end(table: SectionTable, tower: Tower, file: str) -> Value:
    """Return the end of the section at a tension tower."""
    if tower.string_length is None:
        return Value({"kind": "rigid"}, f"table {file}: tower {tower.name} without a string")
    if tower.string_weight is None:
        raise SceneError(
            f"{file}: row {tower.row}: tension tower {tower.name} has a string without"
            " string_weight [N]; give it, too, or leave string_length empty"
        )
    share = f", one of {table.subconductors} equal parts" if table.subconductors > 1 else ""
    end = {
        "kind": "string",
        "length": tower.string_length,
        "weight": tower.string_weight / table.subconductors,
    }
    return Value(end, f"table {file}: tower {tower.name}, dead-end string{share}")
