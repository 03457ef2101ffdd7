"""The verdict of a study: questions of a line engineer, each with an answer and its evidence."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from gallop_fmu.foundation.text_rules import counted
from modal.report.findings import Missing
from modal.report.line_verdict import MIN_GALLOPING, critical_sentence, pairs_sentence
from modal.study.answer import Answer
from modal.study.cases import Case
from modal.study.certainty import certainty, failures
from modal.study.screened import onsets, states, swing
from modal.study.study import LineStudy, Tried, largest_of

MIN_EFFECT = 0.1
"""Share of the motion by which a measure must reduce it to be called effective."""


def answers(study: LineStudy) -> list[Answer]:
    """Return the answers in the order in which the questions arise.

    In a study that was stopped, no answer is called good.
    """
    found = [
        _gallops(study),
        _from_wind(study),
        _height(study),
        _clearance(study),
        _forces(study),
        _resonance(study),
        _changes(study),
        certainty(study),
    ]
    if not study.stopped:
        return found
    return [replace(each, level="open") if each.level == "good" else each for each in found]


def _gallops(study: LineStudy) -> Answer:
    """Number of cases that gallop."""
    known, galloping = study.known, study.galloping
    rule = (
        f"A span is said to gallop if its middle moves vertically by {MIN_GALLOPING:.0%} of its sag"
        " or more, peak to peak."
    )
    if not known:
        return Answer(
            "Will it gallop?", "Not known: no case has a result.", (*failures(study), rule)
        )
    unsettled = [case for case in known if case.may_grow and not case.gallops]
    count = f"{len(known)} simulated case{'s' * (len(known) != 1)}"
    if galloping:
        evidence = (
            *_for_a_time(galloping),
            *_spread(study, galloping),
            *_unsettled(unsettled),
            rule,
        )
        return Answer("Will it gallop?", f"Yes, in {len(galloping)} of {count}.", evidence, "bad")
    if unsettled:
        return Answer(
            "Will it gallop?",
            f"Not within the simulated time, but {len(unsettled)} of {count} had not settled.",
            (*_unsettled(unsettled), rule),
        )
    return Answer("Will it gallop?", f"No, in none of {count}.", (rule,), "good")


def _for_a_time(galloping: Sequence[Case]) -> Iterator[str]:
    """Cases that gallop until the section turns over."""
    if count := sum(case.gallops_for_a_time for case in galloping):
        yield (
            f"In {count} of these, the motion lasts for a time only: the wind and the weight of the"
            " ice rotate the iced conductor by half a turn or more, and then it calms."
        )


def _unsettled(cases: Sequence[Case]) -> Iterator[str]:
    """Cases that do not gallop by the rule, but were not settled at the end."""
    if cases:
        lowest = min(case.wind for case in cases)
        yield (
            f"{len(cases)} more had not settled at the end of the run (lowest wind {lowest:g} m/s):"
            " they may gallop later; a longer run (--stop-time) decides."
        )


def _spread(study: LineStudy, galloping: Sequence[Case]) -> Iterator[str]:
    """Share of galloping cases by ice and by attack angle, where several were simulated."""
    groups = {
        "by ice": [case.ice for case in study.known],
        "by attack angle": [f"{case.angle_deg:g} deg" for case in study.known],
        "by curve": [case.curve for case in study.known],
    }
    chosen = {
        "by ice": [case.ice for case in galloping],
        "by attack angle": [f"{case.angle_deg:g} deg" for case in galloping],
        "by curve": [case.curve for case in galloping],
    }
    for name, all_of in groups.items():
        counts, found = Counter(all_of), Counter(chosen[name])
        if len(counts) > 1:
            parts = [f"{key}: {found[key]} of {count}" for key, count in counts.items()]
            yield f"Galloping cases {name}: {', '.join(parts)}."


def _from_wind(study: LineStudy) -> Answer:
    """Lowest wind of galloping: simulated, and by linear theory."""
    question = "From which wind?"
    evidence = [*_den_hartog(study)]
    if not isinstance(study.findings, Missing):
        critical = critical_sentence(study.findings)
        evidence.append(f"At the worst condition, {critical[0].lower()}{critical[1:]}")
    evidence += onsets(study)
    galloping = study.galloping
    if not galloping:
        winds = [case.wind for case in study.known]
        answer = f"No galloping up to {max(winds):g} m/s in these runs." if winds else "Not known."
        settled = bool(winds) and not any(case.may_grow for case in study.known)
        return Answer(question, answer, tuple(evidence), "good" if settled else "open")
    lowest = min(case.wind for case in galloping)
    below = [wind for wind in study.conditions.winds if wind < lowest]
    if below:
        answer = (
            f"From between {max(below):g} and {lowest:g} m/s: {lowest:g} m/s is the lowest"
            " simulated wind with galloping."
        )
    else:
        answer = f"At the lowest simulated wind, {lowest:g} m/s, it gallops already."
    evidence.insert(0, _by_wind(study))
    return Answer(question, answer, tuple(evidence), "bad")


def _by_wind(study: LineStudy) -> str:
    """Number of galloping cases in each wind, in a sentence."""
    by_wind = [
        f"{wind:g} m/s: {sum(case.gallops for case in at)} of {len(at)}"
        for wind in study.conditions.winds
        if (at := [case for case in study.known if case.wind == wind])
    ]
    return f"Galloping cases by wind: {', '.join(by_wind)}."


def _den_hartog(study: LineStudy) -> Iterator[str]:
    """Range of critical winds by Den Hartog's formula over the conditions."""
    if isinstance(study.criteria, Missing):
        yield f"Den Hartog's formula could not be evaluated: {study.criteria.reason}"
        return
    winds = [found.wind for found in study.criteria if found.wind is not None]
    count = len(study.criteria)
    if winds:
        yield (
            f"Small motions grow by Den Hartog's formula from {_range(winds, 'm/s', '.1f')} in"
            f" {len(winds)} of {count} conditions (ice, attack angle, curve); large motions need"
            " more wind, or time."
        )
    else:
        yield f"By Den Hartog's formula no small motion grows, in all {count} conditions."


def _height(study: LineStudy) -> Answer:
    """Largest motion, its place, and the range over the conditions."""
    question, worst = "How high?", study.worst
    if worst is None:
        return Answer(question, "Not known: no case has a result.", ())
    other = study.unequal
    top = other if other is not None and other.largest > LARGER * worst.largest else worst
    span = top.largest_span
    sag = float(top.sag[span - 1])
    at_least = "" if top.is_whole else "at least "
    answer = (
        f"Up to {at_least}{top.largest:.1f} m peak to peak, in span {span}:"
        f" {top.largest / sag:.0%} of its sag of {sag:.1f} m."
    )
    evidence = [
        f"Worst case: {worst.condition()}. {_kind_of(worst)}",
        _other_start(study, worst),
        *states(study),
        *_ranges(study),
    ]
    return Answer(question, answer, tuple(evidence), "bad" if worst.gallops else "good")


LARGER = 1.05
"""Ratio of the largest motions from two starts above which they are different."""


def _other_start(study: LineStudy, worst: Case) -> str:
    """Largest motion of the worst case from a push that is unlike on all spans, in a sentence."""
    other = study.unequal
    rest = "All other runs, with measures too, start alike on all spans."
    if other is None:
        return (
            "All runs start alike on all spans: motions that other starts lead to may be missing."
        )
    start = "Started by a push that differs from span to span, the worst case"
    if not other.has_result:
        return f"{start} has no result: {other.text} {rest}"
    if other.largest > LARGER * worst.largest:
        return (
            f"{start} moves by {other.largest:.2f} m, and by {worst.largest:.2f} m when all spans"
            f" start alike. {rest} They may miss larger motions; forces and gaps below are those of"
            " the equal start."
        )
    return f"{start} moves by {other.largest:.2f} m, which is not more. {rest}"


def _ranges(study: LineStudy) -> Iterator[str]:
    """Range of the largest motion at each wind, over ice, angles and curves."""
    parts = []
    for wind in study.conditions.winds:
        sizes = [case.largest for case in study.known if case.wind == wind]
        sizes = [size for size in sizes if size == size]
        if sizes:
            parts.append(f"{wind:g} m/s: {_range(sizes, 'm', '.1f')}")
    if parts:
        yield f"Range over ice, attack angles and curves, by wind: {'; '.join(parts)}."


def _kind_of(case: Case) -> str:
    """How the motion of a case ended, in a sentence."""
    if case.kind == "left the curve":
        return (
            "The run ended early, because the attack angle left the measured range of the curve;"
            " the motion is that of the last half of this run."
        )
    if case.kind == "steady":
        return "The motion is steady."
    if case.kind == "turned over":
        return (
            f"The motion is not steady: {case.text.partition(' (')[0]}. Its size is the largest"
            " within 20 s after the first 20 s."
        )
    if case.kind == "ended early":
        return f"The run ended early: {case.text}"
    return f"The motion is not steady: {case.text.partition(' (')[0]}."


def _clearance(study: LineStudy) -> Answer:
    """Gaps of phases by simulated orbits and by the ellipses of two rules."""
    question = "Do phases clash or flash over?"
    if len(study.scene.phases) < 2:
        return Answer(
            question,
            "Not examined: the line is described with one phase.",
            ("Give the positions of all phases as [[phases]] in the scene file.",),
        )
    known = [case for case in study.known if case.smallest_gap == case.smallest_gap]
    if not known:
        return Answer(question, "Not known: no case has a result.", ())
    closest = min(known, key=lambda case: case.smallest_gap)
    gap, span = closest.smallest_gap, int(np.nanargmin(closest.gap)) + 1
    clashes = sum(case.smallest_gap <= 0.0 for case in known)
    required = study.limits.clearance
    if gap <= 0.0:
        answer = (
            f"They can clash: in {clashes} of {len(known)} cases the orbits of two phases overlap,"
            f" by up to {-gap:.1f} m in span {span}."
        )
        level = "bad"
    elif required is not None and gap < required:
        short = sum(case.smallest_gap < required for case in known)
        answer = (
            f"They do not touch, but can flash over: the smallest gap is {gap:.1f} m in span"
            f" {span}, and {required:g} m are required; {short} of {len(known)} cases are below."
        )
        level = "bad"
    else:
        kept = "" if required is None else f", at least the required {required:g} m"
        answer = f"They do not touch: the smallest gap is {gap:.1f} m in span {span}{kept}."
        level = "good" if required is not None else "open"
    evidence = [
        f"Smallest gap: {closest.condition()}. Gaps are between the areas that the orbits of two"
        " phases cover, since the phases need not move in step, at mid-span and the quarter points."
        " An overlap is the shift that would separate the areas.",
        *_ellipses(study),
    ]
    if required is None:
        evidence.append("No required distance was given (--clearance), so flashover is not judged.")
    return Answer(question, answer, tuple(evidence), level)


def _ellipses(study: LineStudy) -> Iterator[str]:
    """Gaps of the ellipses of design rules."""
    for rule, gaps in study.ellipse_gaps.items():
        if not gaps:
            continue
        span = min(gaps, key=lambda span: gaps[span])
        size = gaps[span]
        how = f"overlap by {-size:.1f} m" if size < 0.0 else f"keep {size:.1f} m"
        yield (
            f"Design rule {rule}: the ellipses of neighbouring phases {how} in span {span}, with"
            " the sag under the ice of the worst case."
        )


def _forces(study: LineStudy) -> Answer:
    """Pull of strings, unbalanced pull, and tension, with the values at rest and design values."""
    question, known = "Which forces reach the towers?", study.known
    if not known:
        return Answer(question, "Not known: no case has a result.", ())
    limits, rest = study.limits, _at_rest(study)
    tension = max(float(np.nanmax(case.tension)) for case in known)
    parts = [f"conductor tension up to {tension / 1e3:.1f} kN"]
    if strength := study.scene.section.rated_strength:
        parts[0] += f", {tension / strength:.0%} of the rated strength"
    evidence, over = [], 0
    for name, short, words, key, limit in (
        ("pull", "string pull", "Pull of a suspension string", "tower_pull_at_rest", "string_pull"),
        (
            "force_x1",
            "unbalanced pull",
            "Unbalanced pull along the line on a suspension tower",
            "tower_preload_x1",
            "unbalanced_pull",
        ),
        ("force_x3", "", "Force across the line on a suspension tower", "tower_preload_x3", ""),
    ):
        found = [(size, case) for case in known if (size := case.most(name, inner=True)) == size]
        if not found:
            continue
        size, case = max(found, key=lambda pair: pair[0])
        text = f"{words}: up to {size / 1e3:.1f} kN{_still(rest.get(key))} ({case.condition()})"
        design = getattr(limits, limit, None)
        if design is not None:
            count = sum(each > design for each, _ in found)
            over += count
            exceeded = counted(count, "case")
            text += f"; the design value is {design / 1e3:.1f} kN, exceeded in {exceeded}"
        evidence.append(f"{text}.")
        if short:
            parts.append(f"{short} up to {size / 1e3:.1f} kN")
    evidence += [
        *_pull_of_ends(known, rest),
        "Forces are those of one phase; extremes are of the whole run, with its start in sudden"
        " wind.",
    ]
    answer = "; ".join(parts)
    given = limits.string_pull is not None or limits.unbalanced_pull is not None
    if over:
        answer += "; design values are exceeded"
    level = ("bad" if over else "good") if given else "open"
    return Answer(question, f"{answer[0].upper()}{answer[1:]}.", tuple(evidence), level)


def _still(force: float | None) -> str:
    """Force at rest in words."""
    return "" if force is None else f"; at rest in still air at most {force / 1e3:.1f} kN"


def _pull_of_ends(known: Sequence[Case], rest: dict[str, float]) -> Iterator[str]:
    """Largest pull on a tension tower, in a sentence."""
    ends = [(size, case) for case in known if (size := case.most("force_x1")) == size]
    if ends:
        size, case = max(ends, key=lambda pair: pair[0])
        yield (
            f"Pull along the line on a tension tower at the end: up to {size / 1e3:.1f} kN"
            f"{_still(rest.get('ends'))} ({case.condition()})."
        )


def _at_rest(study: LineStudy) -> dict[str, float]:
    """Largest forces at rest in still air, of suspensions and ends, in the worst case."""
    worst = study.worst
    if worst is None:
        return {}
    found: dict[str, float] = {}
    for key in ("tower_pull_at_rest", "tower_preload_x1", "tower_preload_x3"):
        values = np.abs(worst.towers.get(key, np.array([])))
        inner = values[1:-1][np.isfinite(values[1:-1])] if len(values) > 2 else np.array([])
        if inner.size:
            found[key] = float(inner.max())
    along = np.abs(worst.towers.get("tower_preload_x1", np.array([])))
    if len(along) > 1 and np.isfinite(along[[0, -1]]).all():
        found["ends"] = float(along[[0, -1]].max())
    return found


def _resonance(study: LineStudy) -> Answer:
    """Internal resonance of the worst case."""
    question = "Is there an internal resonance?"
    if isinstance(study.findings, Missing) or isinstance(study.findings.pairs, Missing):
        reason = (
            study.findings.reason
            if isinstance(study.findings, Missing)
            else str(getattr(study.findings.pairs, "reason", ""))
        )
        return Answer(question, "Not known.", (reason,))
    pairs = study.findings.pairs
    matter = [pair for pair in pairs if pair.matters]
    screened = swing(study)
    explained = (
        "In an internal resonance, galloping in one mode starts another at the same or at half the"
        " frequency, such as a swing across the line. Table of pairs below; it is that of the worst"
        " case."
    )
    if not matter:
        named, level = pairs_sentence(study.findings), "good"
    else:
        two = [pair for pair in matter if pair.kind == "2:1"]
        first, level = (two or matter)[0], "bad"
        driving, driven = first.driving_mode, first.driven_mode
        named = (
            f"Yes, possible: {counted(len(matter), 'pair')} of modes, first {first.kind} of the"
            f" {driving.family} mode at {driving.frequency_hz:.3f} Hz with the {driven.family} mode"
            f" at {driven.frequency_hz:.3f} Hz."
        )
    if screened.startswith("Yes"):
        return Answer(question, screened, (named, explained), "bad")
    return Answer(question, named, (screened, explained), level)


def _changes(study: LineStudy) -> Answer:
    """The most effective measure."""
    question = "What to change, and by how much does it help?"
    if not study.galloping:
        return Answer(question, "Nothing: no case gallops.", (), "good")
    before = largest_of(study.before)
    simulated = [each for each in study.tried if each.largest == each.largest]
    if not simulated and study.stopped:
        return Answer(question, "Not known.", (study.stopped,))
    evidence = [_sentence_of(each, study.before) for each in study.tried]
    if worst := study.worst:
        curve = f", {worst.curve}" if worst.curve else ""
        evidence.append(
            f"Simulated before and after, with the ice and curve of the worst case ({worst.ice}"
            f"{curve}), in all winds at its attack angle and at all attack angles in its wind;"
            " other conditions were not tried."
        )
    effective = [each for each in simulated if each.largest <= (1.0 - MIN_EFFECT) * before]
    if not effective:
        return Answer(
            question,
            f"None of {len(simulated)} simulated measures reduces the largest motion by"
            f" {MIN_EFFECT:.0%} or more.",
            tuple(filter(None, evidence)),
            "bad",
        )
    best = effective[0]
    answer = (
        f"{best.measure.name}: the largest motion falls from {before:.1f} to {best.largest:.1f} m"
        f" ({best.largest / before - 1.0:+.0%})."
    )
    return Answer(question, answer, tuple(filter(None, evidence)))


def _sentence_of(tried: Tried, before: Sequence[Case]) -> str:
    """Effect of a measure in a sentence."""
    if tried.measure.scene is None:
        return f"{tried.measure.name}: not possible on this line; {tried.measure.reason}."
    largest, first = tried.largest, largest_of(before)
    if math.isnan(largest):
        return f"{tried.measure.name}: no simulated case has a result."
    count = sum(case.gallops for case in before)
    return (
        f"{tried.measure.name}: {first:.1f} to {largest:.1f} m ({largest / first - 1.0:+.0%});"
        f" {tried.galloping} of {len(tried.cases)} cases gallop, before {count}."
    )


def _range(values: Sequence[float], unit: str, digits: str) -> str:
    """Smallest to largest value with the unit."""
    low, high = format(min(values), digits), format(max(values), digits)
    return f"{low} {unit}" if low == high else f"{low} to {high} {unit}"
