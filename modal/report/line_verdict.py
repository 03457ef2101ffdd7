"""The verdict on a line in a few sentences: galloping, strings, resonances, critical winds."""

from __future__ import annotations

import math
from collections.abc import Iterator

from gallop_fmu.simulation.line_result import LineResult
from modal.report.findings import Missing
from modal.report.line_findings import LineFindings
from modal.report.line_screening import screening_sentences
from modal.stability.critical_wind import CriticalWind

MIN_GALLOPING = 0.1
"""Vertical motion, peak to peak, over the sag, from which a span is said to gallop.

Peak-to-peak amplitudes in the field are 0.1 to 1 times the sag (CIGRE Technical Brochure 322).
"""

MIN_SWING_DEG = 1.0
"""Lean of a string, peak to peak [deg], from which it is said to swing."""

NAMED_PAIRS = 3
"""Most resonant pairs in the verdict; the table has all."""

NOT_COMPUTED = (
    "Not computed for lines: all motions over the wind speed (gallop-modal branches does), and the"
    " risk of galloping over the year (gallop-modal atlas does)."
)


def verdict(findings: LineFindings) -> Iterator[str]:
    """Yield the sentences of the verdict; the warnings of the run follow separately."""
    if isinstance(findings.result, LineResult):
        yield _galloping(findings.result)
        if sentence := _strings(findings.result):
            yield sentence
    else:
        yield f"The simulation is missing: {findings.result.reason}"
    yield from screening_sentences(findings.screening, findings.result)
    yield pairs_sentence(findings)
    yield critical_sentence(findings)
    yield NOT_COMPUTED


def _galloping(result: LineResult) -> str:
    """Which spans gallop, how high, and whether that is steady."""
    wind = result.scene.wind.mean_speed
    where = f"In the mean wind of {wind:.3g} m/s" if wind != 0.0 else "Without wind"
    rows = result.spans.to_dict("records")
    if "u2_amplitude" not in result.spans:
        return f"{where} the run is too short to judge the motion."
    last = f"in the last {_window(result):.3g} s of the run"
    highest = max(rows, key=lambda row: row["u2_amplitude"])
    size = (
        f"{2.0 * highest['u2_amplitude']:.2f} m peak to peak at mid-span of"
        f" {result.label(highest['span'], highest['phase'])}"
    )
    named = [
        result.label(row["span"], row["phase"])
        for row in rows
        if 2.0 * row["u2_amplitude"] >= MIN_GALLOPING * row["sag"]
    ]
    judged = f" Judgement of the motion: {result.motion}."
    if not result.motion.is_steady:
        judged += " It is not steady, so the amplitudes hold only for the end of this run."
    if not named:
        return (
            f"{where} no span moves by {MIN_GALLOPING:.0%} of its sag or more {last}; the largest"
            f" vertical motion is {size}.{judged}"
        )
    which = "all spans" if len(named) == len(rows) else ", ".join(named)
    verb = "gallop" if wind != 0.0 else "move"
    sizes = "; ".join(
        f"{result.label(row['span'], row['phase'])} {2.0 * row['u2_amplitude']:.2f} m"
        for row in rows
    )
    return (
        f"{where} {which} {verb}{'s' if len(named) == 1 and len(rows) > 1 else ''} {last}: up to"
        f" {size}. Vertical motion peak to peak: {sizes}.{judged}"
    )


def _window(result: LineResult) -> float:
    start, stop = result.window()
    return stop - start


def _strings(result: LineResult) -> str:
    """Whether strings swing, and how fast."""
    table = result.strings
    if table.empty or "lean_across_amplitude" not in table:
        return ""
    rows = table.to_dict("records")
    sentences = []
    for way in ("across", "along"):
        largest = max(rows, key=lambda row: row[f"lean_{way}_amplitude"])
        size = 2.0 * math.degrees(largest[f"lean_{way}_amplitude"])
        hertz = largest[f"lean_{way}_frequency_hz"]
        at = f" at {hertz:.3f} Hz" if math.isfinite(hertz) else ""
        if size >= MIN_SWING_DEG:
            sentences.append(
                f"{way} the line by up to {size:.1f} deg peak to peak{at} (tower"
                f" {largest['tower']})"
            )
    if not sentences:
        return (
            f"The strings do not swing at the end of the run: all leans change by less than"
            f" {MIN_SWING_DEG:g} deg peak to peak."
        )
    return f"At the end of the run the strings swing {' and '.join(sentences)}."


def pairs_sentence(findings: LineFindings) -> str:
    """Return the resonant pairs that matter, as a sentence."""
    if isinstance(findings.pairs, Missing):
        return f"Resonant pairs of modes are missing: {findings.pairs.reason}"
    matter = [pair for pair in findings.pairs if pair.matters]
    if not matter:
        return "No pair of modes near 2:1 or 1:1 matters: galloping does not reach any threshold."
    named = "; ".join(
        f"{pair.kind} of mode {pair.driving} ({pair.driving_mode.family},"
        f" {pair.driving_mode.frequency_hz:.3f} Hz) with mode {pair.driven}"
        f" ({pair.driven_mode.family}, {pair.driven_mode.frequency_hz:.3f} Hz)"
        for pair in matter[:NAMED_PAIRS]
    )
    count = f"{len(matter)} resonant pairs of modes matter" if len(matter) > 1 else "One matters"
    first = ", first" if len(matter) > NAMED_PAIRS else ""
    return f"{count}{first}: {named}."


def lowest_by_family(onsets: list[CriticalWind]) -> dict[str, CriticalWind]:
    """Mode with the lowest critical wind of each family; its wind is None if no mode has one."""
    found: dict[str, CriticalWind] = {}
    for onset in onsets:
        known = found.get(onset.mode.family)
        if known is None or _speed(onset) < _speed(known):
            found[onset.mode.family] = onset
    return found


def _speed(onset: CriticalWind) -> float:
    return math.inf if onset.wind_speed is None else onset.wind_speed


def critical_sentence(findings: LineFindings) -> str:
    """Return the critical wind of each family, as a sentence."""
    if isinstance(findings.onsets, Missing):
        return f"Critical winds are missing: {findings.onsets.reason}"
    families = lowest_by_family(findings.onsets)
    named = "; ".join(
        f"{family} "
        + (
            f"none up to {onset.searched_to:g} m/s"
            if onset.wind_speed is None
            else f"from {onset.wind_speed:.2f} m/s"
        )
        for family, onset in families.items()
    )
    return (
        f"Critical wind of linear theory by family, of the {len(findings.onsets)} lowest modes:"
        f" {named}."
    )
