"""Self-contained HTML page of a study: verdict, pictures, measures, evidence, inputs."""

from __future__ import annotations

import math
from dataclasses import dataclass
from datetime import date
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from gallop_fmu.foundation.atomic_write import check_target, write_whole
from gallop_fmu.simulation.clearance import Ellipse, cigre_322_single_loop, davison_single_loop
from gallop_fmu.simulation.line_result import LineResult
from modal.foundation.one_thread import one_thread
from modal.motions.branches import Branches
from modal.report.animation import OTHER_PERIODS, shown_part
from modal.report.findings import Missing
from modal.report.line_findings import LineFindings
from modal.report.line_page import line_content
from modal.report.page import SUFFIXES
from modal.report.tables import scene_tables
from modal.report.template import render
from modal.study import tables
from modal.study.cases import Case
from modal.study.certainty import assumptions
from modal.study.gaps import NORMALS, motion_window, support
from modal.study.study import LineStudy, largest_of
from modal.study.verdict import answers

MARKS = {
    "steady": "{}",
    "not steady": "{}*",
    "turned over": "{} T",
    "left the curve": "> {}",
    "ended early": "> {}",
    "failed": "-",
}
"""Text of a kind of case in the map."""

LETTERS_ON_TELEPHONE = 24
"""Longest line of the name of a measure beside its bar on a telephone."""


@dataclass(frozen=True)
class Signature:
    """Who wrote the report for which project; empty texts are left out."""

    author: str = ""
    project: str = ""
    revision: str = ""


NO_SIGNATURE = Signature()


@one_thread
def write_study(study: LineStudy, path: Path | str, signature: Signature = NO_SIGNATURE) -> Path:
    """Write a study as one self-contained HTML page.

    Parameters
    ----------
    study
        From `modal.study_line`.
    path
        File to write (.html).
    signature
        Author, project and revision.

    Raises
    ------
    SceneError
        If the suffix is not allowed.
    """
    path = Path(path)
    check_target(path, SUFFIXES)
    write_whole(path, study_page(study, signature).encode())
    return path


def study_page(study: LineStudy, signature: Signature) -> str:
    """Fill in the template; every text from the scene is escaped."""
    return render("study.html", content(study, signature), Missing)


def content(study: LineStudy, signature: Signature) -> dict[str, Any]:
    """Values of all names in the template."""
    findings = study.findings
    filled: dict[str, Any] = {
        "scene": study.scene,
        "study": study,
        "signature": signature,
        "today": date.today().isoformat(),
        "footer": _footer(study.scene.title, signature),
        "answers": answers(study),
        "assumptions": assumptions(study),
        "study_pictures": _pictures(study),
        "measure_table": tables.measure_table(study) if study.tried else None,
        "case_table": tables.case_table(study),
        "range_table": tables.range_table(study),
        "force_table": tables.force_table(study),
        "gap_table": tables.gap_table(study),
    }
    if isinstance(findings, Missing):
        filled |= {
            "findings": findings,
            "toml": study.scene.to_toml(),
            "scene_tables": tables.rounded(scene_tables(study.scene)),
            "provenance_table": None,
            "animation": None,
        }
    else:
        filled |= line_content(findings) | {"scene": study.scene}
        filled["scene_tables"] = tables.rounded(filled["scene_tables"])
        filled["study_pictures"] += filled["pictures"][:1]  # the section
        filled["pictures"] = filled["pictures"][1:]
    return filled


def _pictures(study: LineStudy) -> list[Any]:
    """Motion over wind, map, orbits, forces, measures."""
    from modal.plots import study_figures as figures
    from modal.report.plots import picture

    drawn = []
    if study.known:
        drawn.append(
            picture(
                "wind",
                "Vertical motion over the wind speed, with the range over the conditions",
                "Largest vertical motion of all spans over the wind speed. Shaded: range over"
                " attack angles and curves. Marks: cases whose motion is not steady or not whole.",
                lambda: figures.wind_figure(_series(study), _points(study)),
            )
        )
        rows, motion, texts = _map(study)
        drawn.append(
            picture(
                "map",
                "Map of the vertical motion over wind, ice and attack angle",
                "Vertical motion, peak to peak [m], of the span that moves most. *: not steady;"
                " T: the iced section turned over; >: at least, the run ended early as it left the"
                " curve or went slack; -: no result.",
                lambda: figures.condition_map(study.conditions.winds, rows, motion, texts),
            )
        )
        if len(study.known) > len({(case.ice, case.wind) for case in study.known}):
            ices, share, counts = _risk(study)
            drawn.append(
                picture(
                    "risk",
                    "Map of the share of galloping cases over ice and wind",
                    "Share of the cases that gallop, over all attack angles and curves: galloping"
                    " cases of those with a result, and the largest motion, peak to peak.",
                    lambda: figures.condition_map(
                        study.conditions.winds,
                        ices,
                        share,
                        counts,
                        "share of cases\nthat gallop [%]",
                        100.0,
                    ),
                )
            )
    if study.worst is not None and not isinstance(study.branches, Missing):
        drawn.append(_branches(study.branches, study.worst))
    result = study.findings.result if isinstance(study.findings, LineFindings) else None
    if study.worst is not None and isinstance(result, LineResult):
        drawn += _pictures_of_worst(study, study.worst, result)
    simulated = [each for each in study.tried if each.largest == each.largest]
    if simulated:
        figure = partial(
            figures.measure_figure,
            [each.measure.name for each in simulated],
            largest_of(study.before),
            np.array([each.largest for each in simulated]),
        )
        drawn.append(
            picture(
                "measures",
                "Largest vertical motion with each measure",
                "Largest vertical motion with each measure, over the conditions in which they were"
                " tried.",
                figure,
                partial(figure, letters=LETTERS_ON_TELEPHONE),
            )
        )
    return drawn


def _series(study: LineStudy) -> list[Any]:
    """Range of the motion over the wind for each ice."""
    from modal.plots.study_figures import WindSeries

    winds = np.array(study.conditions.winds)
    found = []
    for ice in dict.fromkeys(case.ice for case in study.cases):
        ranges = []
        for wind in study.conditions.winds:
            sizes = [case.largest for case in study.known if (case.ice, case.wind) == (ice, wind)]
            sizes = [size for size in sizes if size == size]
            ranges.append((min(sizes), max(sizes)) if sizes else (math.nan, math.nan))
        low, high = np.array(ranges).T
        found.append(WindSeries(ice, winds, low, high))
    return found


def _points(study: LineStudy) -> dict[str, Any]:
    """Cases whose motion is not steady or not whole."""
    names = {
        "not steady": "not steady",
        "turned over": "section turned over",
        "left the curve": "left the curve: at least",
        "ended early": "ended early: at least",
    }
    points = {}
    for kind, name in names.items():
        cases = [case for case in study.known if case.kind == kind]
        if cases:
            points[name] = (
                np.array([case.wind for case in cases]),
                np.array([case.largest for case in cases]),
            )
    return points


def _map(study: LineStudy) -> tuple[list[str], Any, list[list[str]]]:
    """Rows of the map with the motion and the text of each cell."""
    keys = list(dict.fromkeys((case.ice, case.curve, case.angle_deg) for case in study.cases))
    winds = study.conditions.winds
    motion = np.full((len(keys), len(winds)), np.nan)
    texts = [["-"] * len(winds) for _ in keys]
    for case in study.cases:
        row = keys.index((case.ice, case.curve, case.angle_deg))
        column = winds.index(case.wind)
        motion[row, column] = case.largest
        if case.has_result:
            texts[row][column] = MARKS[case.kind].format(f"{case.largest:.1f}")
    curves = len({curve for _, curve, _ in keys}) > 1
    rows = [
        f"{ice}, {angle:g} deg" + (f", {curve.removeprefix('curve ') or 'own'}" if curves else "")
        for ice, curve, angle in keys
    ]
    return rows, motion, texts


def _branches(found: Branches, worst: Case) -> Any:
    """All motions over the wind of the span that moves most."""
    from modal.plots.branch_figure import branch_figure
    from modal.report.plots import picture

    curve = f", {worst.curve}" if worst.curve else ""
    remarks = "".join(f" {text[0].upper()}{text[1:]}." for text in found.remarks)
    return picture(
        "branches",
        f"All motions of span {worst.largest_span} alone over the wind speed",
        f"All states of rest and periodic motions of span {worst.largest_span} alone, between rigid"
        f" supports, over the wind speed ({worst.ice}, attack angle {worst.angle_deg:g} deg"
        f"{curve}): half peak-to-peak. Solid: stable, the span can stay there; dashed: unstable."
        " Where no solid line is, the motion beats or the iced section rotates. In the section, the"
        " strings and the neighbouring spans change these motions; the cases above are those of"
        f" the section.{remarks}",
        lambda: branch_figure(found.dataset),
        lambda: branch_figure(found.dataset, legend_columns=1),
    )


def _risk(study: LineStudy) -> tuple[list[str], Any, list[list[str]]]:
    """Ices with the share of galloping cases [%] and the text of each cell, over the winds."""
    ices = list(dict.fromkeys(case.ice for case in study.cases))
    winds = study.conditions.winds
    share = np.full((len(ices), len(winds)), np.nan)
    texts = [["-"] * len(winds) for _ in ices]
    for row, column in np.ndindex(*share.shape):
        chosen = ices[row], winds[column]
        cases = [case for case in study.known if (case.ice, case.wind) == chosen]
        if cases:
            count = sum(case.gallops for case in cases)
            share[row, column] = 100.0 * count / len(cases)
            texts[row][column] = f"{count} of {len(cases)}, {largest_of(cases):.1f} m"
    return ices, share, texts


def _pictures_of_worst(study: LineStudy, worst: Case, result: LineResult) -> list[Any]:
    """Orbit of mid-span with the other phases, and forces over time."""
    from modal.plots import study_figures as figures
    from modal.report.plots import picture

    if result.dataset.sizes["time"] < 2:
        return []
    span = worst.largest_span
    bundle = result.bundle(span, 1)
    start, stop = motion_window(result)
    late = bundle.sel(time=slice(start - 1e-9, stop + 1e-9))
    histories = [np.asarray(bundle[name].values) for name in ("u2", "u3")]
    _, chosen = shown_part(np.asarray(bundle.time.values), histories, OTHER_PERIODS)
    last = bundle.isel(time=chosen)
    area = figures.Area(NORMALS, support(late["u2"].values, late["u3"].values))
    offsets = {phase.name: phase.offset for phase in study.scene.phases}
    where = f"span {span}, {worst.condition()}"
    return [
        picture(
            "orbit",
            f"Path of mid-span of span {span} across the line, with clearance",
            f"Path of mid-span across the line in five periods, wind from the left: {where}. All"
            " phases with the area that the motion covers, in the place of the conductor at rest.",
            lambda: figures.orbit_figure(
                (last["u3"].values, last["u2"].values),
                area,
                offsets,
                _ellipses(study, float(worst.sag[span - 1])),
                study.limits.clearance if len(offsets) > 1 else None,
            ),
        ),
        picture(
            "forces",
            "Forces over time in the worst case",
            f"Forces over time in the worst case ({worst.condition()}), of one phase.",
            lambda: figures.force_figure(
                np.asarray(result.dataset.time.values), _forces(study, result)
            ),
        ),
    ]


def _ellipses(study: LineStudy, sag: float) -> dict[str, Ellipse]:
    """Ellipses of the design rules."""
    diameter = study.scene.conductor.diameter
    found = {"Davison": davison_single_loop(sag)}
    if sag > 6.25 * diameter:
        found = {"CIGRE 322": cigre_322_single_loop(sag, diameter), **found}
    return found


def _forces(study: LineStudy, result: LineResult) -> list[Any]:
    """Largest string pull, unbalanced pull, and tension of the conductor over time."""
    from modal.plots.study_figures import ForceHistory

    data = result.dataset
    found = []
    limits = study.limits
    for channel, name, limit in (
        ("string_pull", "pull of the string at tower", limits.string_pull),
        ("tower_force_x1", "unbalanced pull along the line, tower", limits.unbalanced_pull),
    ):
        towers = [
            tower
            for tower in result.map.towers
            if 0 < tower.tower < result.map.spans and (tower.has_string or channel[:5] == "tower")
        ]
        if channel not in data or not towers:
            continue
        values = {t: data[channel].values[:, t.tower, t.phase - 1] / 1e3 for t in towers}
        chosen = max(towers, key=lambda tower: float(np.abs(values[tower]).max()))
        rest = data[f"{channel}_at_rest"].sel(tower=chosen.tower, line_phase=chosen.phase)
        levels = {"at rest": float(rest) / 1e3}
        if limit is not None:
            levels["design value"] = limit / 1e3
        found.append(ForceHistory(f"{name} {chosen.tower}", values[chosen], levels))
    if "tension" in data:
        tension = data["tension"].values
        column = int(np.nanargmax(np.nanmax(tension, axis=0)))
        span = int(data.span.values[column])
        levels = {"at rest": float(tension[0, column]) / 1e3}
        if study.scene.section.rated_strength:
            levels["rated strength"] = study.scene.section.rated_strength / 1e3
        found.append(
            ForceHistory(
                f"tension of the conductor in span {span}", tension[:, column] / 1e3, levels
            )
        )
    return found


def _footer(title: str, signature: Signature) -> str:
    """Text at the foot of printed pages, as the content of a string in CSS."""
    parts = [signature.project, signature.revision and f"revision {signature.revision}", title]
    text = "; ".join(part for part in parts if part)
    return "".join(f"\\{ord(letter):06x}" if letter in "\\\"<>&'\n" else letter for letter in text)
