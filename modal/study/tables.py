"""Tables of text of a study, each number with its unit."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

import numpy as np

from modal.report.line_tables import number
from modal.report.tables import Table
from modal.study.cases import Case
from modal.study.study import LineStudy, largest_of

ROUNDED = 4
"""Digits of the inputs in the appendix."""

_LONG_NUMBER = re.compile(r"-?\d+\.\d+(?:e[+-]?\d+)?|-?\d+e[+-]?\d+")


def rounded(tables: Sequence[Table]) -> list[Table]:
    """Return tables of a scene with values of four digits."""

    def short(text: str) -> str:
        return _LONG_NUMBER.sub(lambda found: f"{float(found[0]):.{ROUNDED}g}", text)

    return [
        Table(each.caption, each.headings, [(row[0], short(row[1]), *row[2:]) for row in each.rows])
        for each in tables
    ]


def measure_table(study: LineStudy) -> Table:
    """Measures before and after: motion, galloping cases, gap, tension, string pull."""
    rows = [("as it is", "", *_effects(study.before, study.before))]
    for tried in study.tried:
        name, detail = tried.measure.name, tried.measure.detail
        if tried.measure.scene is None:
            rows.append((name, f"not possible: {tried.measure.reason}", *["-"] * 6))
        else:
            rows.append((name, detail, *_effects(tried.cases, study.before)))
    headings = (
        "measure",
        "values",
        "largest motion, peak to peak [m]",
        "change [%]",
        "galloping cases",
        "smallest gap of phases [m]",
        "largest tension [kN]",
        "largest string pull [kN]",
    )
    return Table("Measures, simulated before and after", headings, rows)


def _effects(cases: Sequence[Case], before: Sequence[Case]) -> tuple[str, ...]:
    known = [case for case in cases if case.has_result]
    largest, first = largest_of(cases), largest_of(before)
    gaps = [case.smallest_gap for case in known if case.smallest_gap == case.smallest_gap]
    tensions = [float(np.nanmax(case.tension)) for case in known if np.isfinite(case.tension).any()]
    pulls = [pull for case in known if (pull := case.most("pull", inner=True)) == pull]
    change = largest / first - 1.0 if cases is not before and first else math.nan
    return (
        number(largest, digits=".2f"),
        number(change, 100.0, "+.0f"),
        f"{sum(case.gallops for case in known)} of {len(known)}",
        number(min(gaps, default=math.nan), digits=".2f"),
        number(max(tensions, default=math.nan), 1e-3, ".1f"),
        number(max(pulls, default=math.nan), 1e-3, ".1f"),
    )


def range_table(study: LineStudy) -> Table:
    """Range of the motion over the conditions at each wind."""
    rows = []
    for wind in study.conditions.winds:
        at = [case for case in study.known if case.wind == wind]
        sizes = np.array([case.largest for case in at if case.largest == case.largest])
        texts = ["-"] * 3
        if sizes.size:
            texts = [f"{value:.2f}" for value in (sizes.min(), np.median(sizes), sizes.max())]
        rows.append(
            (
                f"{wind:g} m/s",
                f"{sum(case.gallops for case in at)} of {len(at)}",
                *texts,
                number(min((case.smallest_gap for case in at), default=math.nan), digits=".2f"),
            )
        )
    headings = (
        "wind speed",
        "galloping cases",
        "smallest motion [m]",
        "median [m]",
        "largest [m]",
        "smallest gap of phases [m]",
    )
    caption = (
        "Vertical motion of the span that moves most, peak to peak: range over ice, attack angles"
        " and curves"
    )
    return Table(caption, headings, rows)


def case_table(study: LineStudy) -> Table:
    """All cases."""
    rows = [
        (
            case.condition(),
            number(case.largest, digits=".2f"),
            str(case.largest_span) if case.largest == case.largest else "-",
            number(float(case.frequency_hz[case.largest_span - 1]), digits=".3f")
            if case.largest == case.largest
            else "-",
            number(case.smallest_gap, digits=".2f"),
            case.kind,
            case.text,
        )
        for case in study.cases
    ]
    headings = (
        "case",
        "largest motion, peak to peak [m]",
        "in span",
        "frequency [Hz]",
        "smallest gap of phases [m]",
        "kind",
        "judgement or reason",
    )
    return Table("All simulated cases", headings, rows)


def force_table(study: LineStudy) -> Table | None:
    """Largest forces on each tower over all cases, with those at rest."""
    known = [case for case in study.known if "tower_force_x1_highest" in case.towers]
    if not known or study.worst is None:
        return None
    rows = []
    for tower in range(len(known[0].towers["tower_force_x1_highest"])):
        cells = [f"tower {tower}"]
        for column, still in (
            ("pull", "tower_pull_at_rest"),
            ("force_x1", "tower_preload_x1"),
            ("force_x2", "tower_preload_x2"),
            ("force_x3", "tower_preload_x3"),
        ):
            rest = study.worst.towers.get(still)
            low = _extreme(known, f"tower_{column}_lowest", tower, -1.0)
            high = _extreme(known, f"tower_{column}_highest", tower, 1.0)
            cells.append(number(math.nan if rest is None else float(rest[tower]), 1e-3, ".2f"))
            cells.append(
                "-"
                if math.isnan(low)
                else f"{number(low, 1e-3, '.2f')} to {number(high, 1e-3, '.2f')}"
            )
        rows.append(tuple(cells))
    names = ("string pull", "along the line", "upwards", "with the wind")
    headings = [
        f"{name}, {what} [kN]" for name in names for what in ("at rest", "lowest to highest")
    ]
    caption = (
        "Forces of one phase on the towers: at rest in still air in the worst case, and extremes of"
        " all cases, which include it"
    )
    return Table(caption, ("tower", *headings), rows)


def _extreme(cases: Sequence[Case], column: str, tower: int, sign: float) -> float:
    """Return the largest value of a tower, with -1.0 the smallest; NaN if there is none."""
    values = np.array([case.towers[column][tower] for case in cases if column in case.towers])
    values = sign * values[np.isfinite(values)]
    return sign * float(values.max()) if values.size else math.nan


def gap_table(study: LineStudy) -> Table | None:
    """Gap of phases in each span: by orbits over all cases, and by ellipses."""
    known = [case for case in study.known if np.isfinite(case.gap).any()]
    if len(study.scene.phases) < 2 or not known:
        return None
    rows = []
    for span in range(1, len(study.scene.section.spans) + 1):
        sizes = np.array([case.gap[span - 1] for case in known])
        gaps = sizes[np.isfinite(sizes)].tolist()
        rows.append(
            (
                f"span {span}",
                number(min(gaps, default=math.nan), digits=".2f"),
                number(max(gaps, default=math.nan), digits=".2f"),
                *(
                    number(gaps_of.get(span, math.nan), digits=".2f")
                    for gaps_of in study.ellipse_gaps.values()
                ),
            )
        )
    headings = (
        "span",
        "smallest gap of orbits [m]",
        "largest gap of orbits [m]",
        *(f"ellipses of {rule} [m]" for rule in study.ellipse_gaps),
    )
    caption = "Gap between phases, between conductors; negative: overlap"
    return Table(caption, headings, rows)
