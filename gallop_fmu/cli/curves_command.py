"""The command ``gallop-fmu curves``: list coefficient curves, or describe one."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from gallop_fmu.cli.terminal import (
    PICTURE_SUFFIXES,
    AsJson,
    check_output,
    echo_json,
    new_console,
    new_table,
    print_warnings,
    real,
)

if TYPE_CHECKING:
    from gallop_fmu.scene.aerodynamics import Aerodynamics

CURVES_EXAMPLE = "gallop-fmu curves assumed --thickness-ratio 0.2 --plot curve.png"

ASSUMED_TITLE = "iced conductor of any ice thickness, over the full circle"
ASSUMED_TEXTS = {
    "status": "assumed",
    "source": "none: ASSUMED, not measured. Its lift is calibrated so that simulated amplitudes"
    " follow the largest ones observed on lines (CIGRE 322)",
    "reynolds": "none",
    "attack_angle": "0: the wind meets the thickest ice",
    "validity": "for a first estimate; use measured coefficients of the ice for design",
}


def curves(
    name: Annotated[
        str | None,
        typer.Argument(
            metavar="[NAME]",
            help="A curve of the list, or a CSV file with a curve.",
            show_default=False,
        ),
    ] = None,
    thickness_ratio: Annotated[
        float,
        typer.Option(
            metavar="RATIO",
            parser=real,
            help="Ice thickness over the bare diameter, of the assumed curve.",
        ),
    ] = 0.1,
    plot: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Write a picture of NAME: .png, .svg or .pdf."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """List the coefficient curves that a scene can name, or describe one.

    A picture shows lift, drag and moment, and where Den Hartog's criterion is negative.
    """
    from gallop_fmu.foundation.errors import SceneError

    if name is None:
        if plot is not None:
            raise SceneError("--plot: needs the name of a curve, or a CSV file")
        _list(as_json)
        return
    check_output(plot, PICTURE_SUFFIXES)
    section, texts = _chosen(name, thickness_ratio)
    numbers: dict[str, Any] = {
        "name": name,
        **texts,
        "range_deg": list(section.range_deg),
        "outside": section.beyond,
        "den_hartog_unstable_deg": _unstable_ranges(section),
    }
    if plot is not None:
        from gallop_fmu.plots import curve_figure, save_figure

        figure = curve_figure(section.curve(), f"{name}, {texts['status']}: {texts['title']}")
        numbers["files"] = [str(save_figure(figure, plot))]
    if as_json:
        echo_json({**numbers, "warnings": section.warnings()})
        return
    _describe(numbers)
    print_warnings(section.warnings())


def _list(as_json: bool) -> None:
    from gallop_fmu.scene.curve_catalogue import packaged_curves
    from gallop_fmu.scene.packaged_coefficients import PackagedCoefficients

    rows: list[dict[str, Any]] = [
        {
            "name": entry.name,
            "status": entry.status,
            "range_deg": list(PackagedCoefficients(name=entry.name).range_deg),
            "title": entry.title,
            "source": entry.source,
        }
        for entry in packaged_curves().values()
    ]
    rows.insert(
        0,
        {
            "name": "assumed",
            "status": "assumed",
            "range_deg": [-180.0, 180.0],
            "title": ASSUMED_TITLE,
            "source": ASSUMED_TEXTS["source"],
        },
    )
    if as_json:
        echo_json(rows)
        return
    table = new_table("name", "status", "range [deg]", "section")
    for row in rows:
        first, last = row["range_deg"]
        table.add_row(row["name"], row["status"], f"{first:g} to {last:g}", row["title"])
    console = new_console()
    console.print(table)
    console.print("gallop-fmu curves NAME has source and limits of a curve", style="dim")


def _chosen(name: str, thickness_ratio: float) -> tuple[Aerodynamics, dict[str, str]]:
    """Return the section ``[aerodynamics]`` of a curve, and its description."""
    from pydantic import ValidationError

    from gallop_fmu.foundation.errors import SceneError
    from gallop_fmu.scene.assumed_coefficients import AssumedCoefficients
    from gallop_fmu.scene.curve_catalogue import packaged_curves
    from gallop_fmu.scene.packaged_coefficients import PackagedCoefficients
    from gallop_fmu.scene.table_coefficients import TableCoefficients
    from gallop_fmu.scene.validation_messages import explain

    kind: Any = TableCoefficients
    try:
        if name == "assumed":
            kind = AssumedCoefficients
            assumed = AssumedCoefficients(ice_thickness_ratio=thickness_ratio)
            return assumed, {"title": f"ice of {thickness_ratio:g} diameters", **ASSUMED_TEXTS}
        if Path(name).suffix.lower() == ".csv":
            table = TableCoefficients.model_validate({"file": name}, context={"folder": Path()})
            return table, {"title": f"{len(table.angle_deg)} angles", "status": "from a file"}
    except ValidationError as error:
        raise SceneError(explain(error, kind)) from None
    if name not in packaged_curves():
        names = ", ".join(["assumed", *packaged_curves()])
        raise SceneError(
            f"{name!r}: no curve has this name; there are {names}, or a CSV file (.csv)"
        )
    packaged = PackagedCoefficients(name=name)
    entry = packaged.entry
    return packaged, {key: getattr(entry, key) for key in LABELS}


def _unstable_ranges(section: Aerodynamics) -> list[list[float]]:
    """Ranges of the attack angle [deg] in which Den Hartog's criterion is negative, to 0.5 deg."""
    import numpy as np

    first, last = section.range_deg
    angle = np.linspace(first, last, round(2.0 * (last - first)) + 1)
    unstable = section.curve().den_hartog(np.radians(angle)) < 0.0
    edges = np.flatnonzero(np.diff(np.concatenate([[False], unstable, [False]])))
    return [[float(angle[a]), float(angle[b - 1])] for a, b in edges.reshape(-1, 2)]


LABELS = {
    "title": "section",
    "status": "status",
    "source": "source",
    "reynolds": "Reynolds number",
    "attack_angle": "attack angle",
    "validity": "validity",
}


def _describe(numbers: dict[str, Any]) -> None:
    console = new_console()
    console.print(numbers["name"], style="bold")
    for key, label in LABELS.items():
        if key in numbers:
            console.print(f"{label}: {numbers[key]}", soft_wrap=True, highlight=False)
    first, last = numbers["range_deg"]
    rule = {"error": "an error", "hold": "the end value", "periodic": "the repeated curve"}
    console.print(f"range: {first:g} to {last:g} deg; outside: {rule[numbers['outside']]}")
    ranges = [f"{a:g} to {b:g} deg" for a, b in numbers["den_hartog_unstable_deg"]]
    console.print(f"CD + dCL/dalpha is negative: {', '.join(ranges) or 'nowhere'}", soft_wrap=True)
    for path in numbers.get("files", []):
        console.print(f"wrote {path}", soft_wrap=True)
