"""Sentences of a screening: each verdict with the numbers that it rests on."""

from dataclasses import replace

import pytest

from modal.screening.continuation import Cycle
from modal.screening.verdict import RISKS, SENTENCES, Judgement, Verdict, explain
from modal.stability.frequency_ratio import FrequencyRatio

GALLOPING = Cycle(5.5, 0.585, 0.02, 0.2, 0.67, 1.25)
KNOWN = Judgement(
    verdict=Verdict.NO_GALLOPING,
    frequencies=FrequencyRatio(0.7, 0.38),
    wind_speed=5.5,
    highest_wind=8.25,
    galloping_from=4.6,
    galloping_until=None,
    limit_cycle=(GALLOPING,),
    end_reason=None,
    is_unresolved=False,
)
PAIR = "frequency ratio 1.842, 7.9% below 2:1"
ONSET = replace(
    KNOWN, verdict=Verdict.NO_SWING, onset=replace(GALLOPING, wind_speed=5.04, vertical=0.405)
)
STARTS = (
    f"{PAIR}: galloping starts the swing at 5.04 m/s, where its vertical amplitude passes 0.405 m"
)
SWING = replace(
    ONSET,
    verdict=Verdict.SWING,
    galloping=GALLOPING,
    saturated=Cycle(5.5, 0.44, 0.19, 0.2, 0.67, 0.95),
    antisymmetric_growth=1.05,
)
ALONE = (
    "; at 5.5 m/s galloping alone would reach 0.585 m, a small swing grows by 25.0% per cycle, and "
)
NO_CYCLE = replace(KNOWN, verdict=Verdict.NO_CYCLE)
REMEDY = "run a simulation at the scene's 5.5 m/s"
ENDED = replace(KNOWN, verdict=Verdict.NO_ONSET, galloping_until=5.0)


def test_every_verdict_has_a_risk_and_a_sentence():
    assert set(RISKS) == set(SENTENCES) == set(Verdict)


@pytest.mark.parametrize(
    ("judged", "sentence"),
    [
        (KNOWN, "the first symmetric vertical mode does not gallop up to 8.25 m/s"),
        (
            replace(KNOWN, end_reason="the span is unstable"),
            "the first symmetric vertical mode does not gallop up to 8.25 m/s;"
            " the span is unstable",
        ),
        (
            ENDED,
            f"{PAIR}: galloping begins at 4.6 m/s, ends at 5 m/s, below the scene's 5.5 m/s,"
            " and starts no swing up to 5.5 m/s",
        ),
        (
            replace(KNOWN, verdict=Verdict.NO_ONSET, galloping=GALLOPING, end_reason="it ends"),
            f"{PAIR}: galloping at the scene's 5.5 m/s has an amplitude of 0.585 m and starts no"
            " swing up to 5.5 m/s (it ends)",
        ),
        (ONSET, f"{STARTS}, but not at the scene's 5.5 m/s"),
        (
            replace(ONSET, until_wind_speed=7.0, saturated=SWING.saturated),
            f"{STARTS} and no longer from 7 m/s on, but not at the scene's 5.5 m/s, where a swing"
            " of 0.19 m is possible after a strong disturbance",
        ),
        (
            SWING,
            f"{STARTS}{ALONE}the motion settles at 0.44 m vertical and 0.19 m horizontal;"
            " an antisymmetric disturbance of it grows by 5.0% per cycle",
        ),
        (
            replace(
                SWING,
                saturated=replace(SWING.saturated, multiplier=1.01),
                antisymmetric_growth=1.001,
            ),
            f"{STARTS}{ALONE}the motion beats, up to 0.44 m vertical and 0.19 m horizontal",
        ),
        (
            replace(SWING, saturated=None, antisymmetric_growth=None),
            f"{STARTS}{ALONE}no steady motion with swing was found",
        ),
        (
            NO_CYCLE,
            f"{PAIR}, but no periodic motion was found at 5.5 m/s (no branch reaches it); {REMEDY}",
        ),
        (
            replace(NO_CYCLE, end_reason="it is unresolved above 5 m/s", is_unresolved=True),
            f"{PAIR}, but it is unresolved above 5 m/s; {REMEDY}",
        ),
        (
            replace(KNOWN, verdict=Verdict.BROKEN_BRANCH),
            f"{PAIR}, but the limit cycle is unresolved: no periodic motion was found between two"
            f" computed ones; {REMEDY}",
        ),
    ],
)
def test_sentences(judged, sentence):
    assert explain(judged) == sentence
