"""How sure a study is: kinds of cases, warnings, failures, assumptions."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator

from modal.study.answer import Answer
from modal.study.cases import KINDS, Case, Kind
from modal.study.study import LineStudy

_NUMBER = re.compile(r"[\d.]+")


def certainty(study: LineStudy) -> Answer:
    """Number of cases of each kind, ranges, and what is assumed."""
    counts = Counter(case.kind for case in study.cases)
    total = len(study.cases)
    words: dict[Kind, str] = {
        "not steady": "{} without a steady motion",
        "turned over": "in {} the section turned over",
        "left the curve": "{} left the curve",
        "ended early": "{} ended early",
        "failed": "{} have no result",
    }
    others = [text.format(counts[kind]) for kind, text in words.items() if counts[kind]]
    steady = f"{counts['steady']} of {total} cases ended in a steady motion"
    answer = f"{', '.join([steady, *others])}."
    evidence = [f"{counts[k]} of {total}: {text}." for k, text in KINDS.items() if counts[k]]
    evidence += [*failures(study), *_warnings(study), *assumptions(study)]
    return Answer("How sure is this?", answer, tuple(evidence))


def _warnings(study: LineStudy) -> Iterator[str]:
    """Warnings of the runs, those that differ in numbers only together."""
    groups: dict[str, list[tuple[Case, str]]] = {}
    for case in study.known:
        own = case.warnings
        for text in study.warnings:  # they are said once, for all cases
            own = own.replace(text, "").strip()
        if own:
            groups.setdefault(_NUMBER.sub("", own), []).append((case, own))
    for found in groups.values():
        (case, own), count = found[0], f"{len(found)} of {len(study.known)} cases"
        yield f"Warning in {count} (first: {case.condition()}): {own}"
    for text in {_NUMBER.sub("", text): text for text in reversed(study.warnings)}.values():
        yield f"Warning: {text}"


def failures(study: LineStudy) -> Iterator[str]:
    """Reasons of the cases without a result, with their number and the first condition."""
    reasons: dict[str, list[Case]] = {}
    for case in study.cases:
        if not case.has_result:
            reasons.setdefault(case.reason, []).append(case)
    for reason, cases in reasons.items():
        yield f"{len(cases)} without a result: {reason} (first: {cases[0].condition()})."


def assumptions(study: LineStudy) -> list[str]:
    """What the study assumes, one sentence each."""
    conditions = study.conditions
    found = []
    if conditions.ices:
        found.append(
            f"Assumed: {conditions.ice_shape.replace('_', ' ')} ice of"
            f" {conditions.ice_density:g} kg/m3, equal on all spans; the thickness is the largest"
            " one of the section."
        )
    found.append(f"Coefficient curve: {'; '.join(study.curve_sources)}.")
    found.append(
        "Assumed: wind of constant speed, equal on all spans and normal to the line; forces as"
        " measured on a section at rest (quasi-steady); no bending stiffness; rigid towers."
    )
    if study.is_single:
        found.append(
            "One phase was simulated for all: nothing connects the phases, so they move alike."
        )
    return found
