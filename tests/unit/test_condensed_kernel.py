"""The condensed kernel alone: numbers and lengths that no binding would pass, and motions that are none."""

import math

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.condensation import condense
from gallop_fmu.condensed_engine import CONDENSED_MODES, CondensedModel
from gallop_fmu.outcome import Outcome, Report

STEP = 0.05
IDLE = CONDENSED_MODES - 1
"""A mode to which a test gives what it needs."""


@pytest.fixture(scope="module")
def span():
    return condense(gf.load_scene("example3"))


def kernel(span, **values):
    return CondensedModel(span.model, {**span.values, "time_step": STEP, **values})


def without(span, mode):
    """The arrays of a span in which a mode neither stretches the cable nor moves a section."""
    arrays = {name: np.array(span.values[name]) for name in ("elongation", "stretch", "coupling", "shape", "slope")}
    arrays["elongation"][mode] = 0.0
    arrays["stretch"][mode] = arrays["stretch"][:, mode] = 0.0
    arrays["coupling"][mode] = arrays["coupling"][:, mode] = 0.0
    arrays["shape"][:, mode] = arrays["slope"][:, mode] = 0.0
    arrays |= {name: np.array(span.values[name]) for name in ("weighted", "slope_weighted", "frequency", "damping")}
    arrays["weighted"][..., mode] = arrays["slope_weighted"][..., mode] = 0.0
    return arrays


def march(condensed, q=None, v=None, first=0, steps=1, every=1, within=1):
    q = np.zeros(CONDENSED_MODES) if q is None else q
    v = np.zeros(CONDENSED_MODES) if v is None else v
    before = Report(Outcome.COMPLETED, 0.0, lowest_tension=math.inf)
    return condensed.run(q, v, first, steps, every, within, before)


def test_the_span_itself_is_marched(span):
    history, tension, report = march(kernel(span), steps=4, within=3)
    assert report.outcome is Outcome.COMPLETED
    assert history.shape == (12, 2, CONDENSED_MODES)
    assert report.lowest_tension == pytest.approx(tension.min(), rel=1e-3)


def test_as_many_loads_as_the_scene_has(span):
    more = kernel(span, load=np.zeros((len(span.model.scene.loads) + 1, CONDENSED_MODES)))
    assert march(more)[2].outcome is Outcome.BAD_CALL
    with pytest.raises(gf.SimulationError) as caught:
        more.forces(np.zeros(CONDENSED_MODES), np.zeros(CONDENSED_MODES))
    assert caught.value.report.outcome is Outcome.BAD_CALL


@pytest.mark.parametrize(
    "lengths",
    [
        {"first": -1},
        {"first": 2**63 - 1},
        {"steps": 2**53, "every": 2**62},
        {"every": 2**62, "within": -1},
    ],
)
def test_lengths_that_no_run_has(span, lengths):
    assert march(kernel(span), **lengths)[2].outcome is Outcome.BAD_CALL


@pytest.mark.parametrize("step", [0.0, -STEP, math.nan, math.inf])
def test_time_steps_that_are_none(span, step):
    assert march(kernel(span, time_step=step), steps=0)[2].outcome is Outcome.BAD_CALL
    assert march(kernel(span, time_step=1e300), first=2**62, steps=0)[2].outcome is Outcome.BAD_CALL


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_a_velocity_that_is_none_ends_the_run(span, value):
    """Not even a tension tells: it follows from displacements alone."""
    v = np.zeros(CONDENSED_MODES)
    v[0] = value
    assert march(kernel(span), v=v, steps=0)[2].outcome is Outcome.NON_FINITE


def test_slack_between_two_steps_is_slack(span):
    """A mode that swings once in a step pulls as hard at both ends of it, and pushes between."""
    arrays = without(span, IDLE)
    arrays["frequency"][IDLE], arrays["damping"][IDLE], arrays["elongation"][IDLE] = 2.0 * math.pi / STEP, 0.0, 1.0
    q = np.zeros(CONDENSED_MODES)
    q[IDLE] = 1e5 / span.values["stiffness"]
    assert march(kernel(span, **arrays), q=q.copy())[2].outcome is Outcome.COMPLETED
    _, tension, report = march(kernel(span, **arrays), q=q.copy(), within=10)
    assert report.outcome is Outcome.SLACK
    assert 0 < len(tension) < 5
    assert (tension >= 0.0).all()
    assert 0.0 < report.time <= 0.5 * STEP
    assert report.lowest_tension < 0.0
