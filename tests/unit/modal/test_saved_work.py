"""Work that estimates and screenings save, and that it changes nothing."""

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from gallop_fmu.engine.state import State
from modal.continuation.equations import OrbitEquations
from modal.linear import modes
from modal.linear.linearise import linearised
from modal.linear.mode_basis import still_air_modes
from modal.motions.full_model import full_scene, run_from, runs_from
from modal.motions.reduced_model import ReducedModel
from modal.motions.span_model import SpanModel
from modal.screening import many_spans
from modal.screening import two_mode_estimate as pair

ALL = 3 * pair.MESH_ELEMENTS
"""Sections of a whole span."""

SLOPE = {"span.height_difference": 5.0, "span.sag": None}
OBLIQUE = {"wind.direction_deg": 20.0}


def reduced(values, elements=pair.MESH_ELEMENTS):
    scene = gf.load_scene("example3").with_values(values)
    rest = still_air_modes(scene, elements)
    chosen = [rest.first(family) for family in ("vertical", "horizontal", "torsional")]
    return ReducedModel(scene, rest, chosen, rest.shapes[chosen])


def evaluated(model):
    """Number of sections that a model evaluates."""
    return model._projection.at_sections(np.zeros((1, 3))).shape[2]


@pytest.mark.parametrize(
    ("values", "elements", "sections"),
    [({}, 6, 9), ({}, 5, 8), (SLOPE, 6, ALL), (OBLIQUE, 6, ALL)],
)
def test_a_symmetric_span_evaluates_one_half(values, elements, sections):
    assert evaluated(reduced(values, elements)) == sections


@pytest.mark.parametrize("elements", [5, 6])
def test_one_half_gives_the_forces_of_both(elements, monkeypatch):
    half = reduced({}, elements)
    monkeypatch.setattr(ReducedModel, "_is_symmetric", lambda _: False)
    whole = reduced({}, elements)
    assert evaluated(whole) == 3 * elements
    q, v, a = np.random.default_rng(2).normal(size=(3, 5, 3))
    for one, other in zip(half.forces(q, v, a, 5.0), whole.forces(q, v, a, 5.0), strict=True):
        assert one == pytest.approx(other, abs=1e-10 * np.max(np.abs(other)))  # seen: 3e-12
    assert half.angle_excess(q, v, 5.0) == pytest.approx(whole.angle_excess(q, v, 5.0), abs=1e-9)


def test_the_ratio_describes_no_mode_beyond_both(monkeypatch):
    described = []
    describe = modes._describe
    monkeypatch.setattr(modes, "_describe", lambda *given: described.append(1) or describe(*given))
    expected = modal.frequency_ratio("example3")
    assert len(described) == 2  # of 8
    both = [mode for mode in modal.natural_modes("example3", 8) if mode.symmetric]
    assert {mode.frequency_hz for mode in both} >= {expected.vertical_hz, expected.horizontal_hz}


def test_a_longer_run_continues_the_shorter_one(monkeypatch):
    scene = gf.load_scene("example3")
    model = SpanModel(scene, still_air_modes(scene, 6))
    calm = full_scene(scene, "wind.speed", 6.5, model, steps=100)
    state = np.full(2 * model.size, 1e-3)
    asked = []
    record = State.record
    monkeypatch.setattr(
        State,
        "record",
        lambda self, count, *rest: asked.append(count) or record(self, count, *rest),
    )
    _, whole, _ = run_from(calm, model, state, 70)
    runs = list(runs_from(calm, model, state, (65, 70)))
    assert asked == [70 * 50, 65 * 50, 5 * 50]
    assert np.array_equal(runs[1][1], whole)
    assert np.array_equal(runs[0][1], whole[: 65 * 50])
    assert runs[1][0] == run_from(calm, model, state, 70)[0]


def test_groups_of_draws_share_the_modes_of_their_span(monkeypatch):
    calls, original = [], many_spans.pair_of
    monkeypatch.setattr(many_spans, "pair_of", lambda scene: calls.append(1) or original(scene))
    base = gf.load_scene("example3").with_values({"conductor.torsional_stiffness": 161.0})
    windy = [base.with_values({"wind.speed": speed}) for speed in (5.0, 6.0)]
    task = many_spans.EstimateTask(None)
    groups = [task([scene], lambda: True)[0] for scene in windy]
    assert len(calls) == 1
    task([base.with_values({"conductor.torsional_stiffness": 162.0})], lambda: True)
    alone = task([windy[1]], lambda: True)[0]
    assert len(calls) == 3
    assert {**alone, "seconds": 0.0} == {**groups[1], "seconds": 0.0}


@pytest.mark.parametrize("values", [{}, SLOPE, OBLIQUE])
def test_the_swing_is_damped_in_proportion_to_the_wind(values):
    scene = gf.load_scene("example3").with_values(values)
    found = pair.pair_of(scene)
    for wind in (0.3, 5.5, 20.0):
        damping = pair._swing_damping(found.model, wind)
        assert found.swing(wind).damping == pytest.approx(damping, rel=1e-13)  # seen: 2e-15


def test_free_rows_and_columns_are_those_that_indices_select():
    equations = linearised(gf.load_scene("example3"), "still")
    kept = np.flatnonzero(equations.free)
    for found, whole in zip(
        equations.of_free(), (equations.mass, equations.damping, equations.stiffness), strict=True
    ):
        expected = whole[kept][:, kept].tocsc()
        assert np.array_equal(found.indices, expected.indices)
        assert np.array_equal(found.indptr, expected.indptr)
        assert np.array_equal(found.data, expected.data)


def test_orbits_are_mostly_corrected_without_linearisation(monkeypatch):
    """Observed: 84 linearisations for 42 points.

    88 if events are located by Brent's method, 133 if Newton's method makes all corrections.
    """
    calls = []
    whole = OrbitEquations.linearise

    def counted(self, *given):
        calls.append(self.intervals)
        return whole(self, *given)

    monkeypatch.setattr(OrbitEquations, "linearise", counted)
    found = modal.branches("example3", "wind.speed", 4.5, 5.2)
    assert len(calls) < 2.05 * sum(len(branch.points) for branch in found.diagram.branches)
