"""The screening of the worst case of a study in sentences, beside the simulations."""

from __future__ import annotations

from collections.abc import Iterator

from modal.report.findings import Missing
from modal.report.line_screening import agreement, settled, unresolved
from modal.screening.line_screen import LineScreening
from modal.screening.verdict import divergence_sentence
from modal.study.study import LineStudy


def screening_of(study: LineStudy) -> LineScreening | None:
    """The screening of the worst case; None if it is missing."""
    found = None if isinstance(study.findings, Missing) else study.findings.screening
    return found if isinstance(found, LineScreening) else None


def onsets(study: LineStudy) -> Iterator[str]:
    """Motions that begin on rest by the screening, and cases that gallop below all of them."""
    found = screening_of(study)
    if found is None:
        return
    if not found.onsets:
        yield (
            "At the worst condition by the screening: no motion begins on rest up to"
            f" {found.highest_wind:.4g} m/s."
        )
    else:
        begin = "; ".join(map(str, found.onsets))
        yield f"At the worst condition by the screening, motions begin on rest: {begin}."
    lowest = min((one.wind_speed for one in found.onsets), default=found.highest_wind)
    worst = study.worst
    below = [
        case.wind
        for case in study.galloping
        if worst is not None
        and (case.ice, case.curve, case.angle_deg) == (worst.ice, worst.curve, worst.angle_deg)
        and 0.0 < case.wind < lowest
    ]
    if below:
        yield (
            f"Simulation and screening disagree: a case gallops at {min(below):g} m/s, but rest is"
            f" stable up to {lowest:.4g} m/s by the screening; the start of the run in sudden wind"
            " can lead to galloping that rest does not start."
        )


def states(study: LineStudy) -> Iterator[str]:
    """Stable states of the worst case by the screening, and if the simulation ends in one."""
    found = screening_of(study)
    if found is None or isinstance(study.findings, Missing):
        return
    found_states = settled(found)
    if found_states:
        several = (
            " (which one the line reaches depends on its start)" if len(found_states) > 1 else ""
        )
        named = " or ".join(map(str, found_states))
        yield f"Stable in the worst case by the screening{several}: {named}."
    else:
        yield "The screening found no stable state in the worst case: it is unresolved."
    if sentence := agreement(found, study.findings.result):
        yield sentence


def turning(found: LineScreening) -> str:
    """Reason why a span turns over, with a colon before it; empty if none does."""
    if found.divergence_from is not None:
        return f": {divergence_sentence(found.divergence_from)}"
    turned = next((state.name for state in found.states if state.is_turned_over), "")
    return turned and f": stable at {found.wind_speed:g} m/s is {turned}"


def swing(study: LineStudy) -> str:
    """Swing at half the frequency of galloping by the screening of the worst case."""
    found = screening_of(study)
    if found is None:
        missing = None if isinstance(study.findings, Missing) else study.findings.screening
        return f"The screening is missing: {missing.reason}" if isinstance(missing, Missing) else ""
    starts = "; ".join(str(one) for one in found.transitions)
    remark = f" ({starts})" if starts else ""
    words = {
        "none": "By the screening, no motion begins.",
        "other": f"By the screening, no span gallops in one loop{remark}.",
        "detuned": f"The screening found no swing at half the frequency of galloping{remark}.",
        "possible": "By the screening, galloping starts a swing at half its frequency in other"
        f" winds, or after a disturbance{remark}.",
        "certain": "Yes: by the screening, galloping starts a swing at half its frequency in the"
        f" worst case{remark}.",
        "turns over": "By the screening, no swing starts, but a span turns over"
        f"{turning(found)}{remark}.",
        "undetermined": "The screening of the worst case is unresolved:"
        f" {'; '.join(found.unresolved) or 'no stable motion was found'}.",
    }
    return f"{words[found.risk]} {unresolved(found)}".rstrip()
