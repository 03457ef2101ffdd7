"""Irvine's theory against the finite elements: small sag, springs, slopes; where they differ."""

import math

import pytest

import gallop_fmu as gf
import modal
from modal.foundation.root_finding import bracketed_root
from modal.linear.shallow_cable import CROSSOVER, lambda_squared_for

SPRINGS = {"kind": "springs", "stiffness_x1": 80e3, "stiffness_x3": 2000.0}
SOFT = {"kind": "springs", "stiffness_x1": 30e3, "stiffness_x3": 900.0}
ADJACENT = {
    "kind": "adjacent_span",
    "adjacent_span": 120.0,
    "adjacent_tension": 20e3,
    "insulator_length": 2.0,
    "insulator_weight": 500.0,
}


def span(**changes):
    """A sag of 0.4 % of the span, without eccentric ice."""
    base = {
        "span": {"length": 100.0, "sag": 0.4},
        "ice": {"mass_per_length": 0.2},
        "numerics.elements": 30,
    }
    return gf.load_scene("example1").with_values({**base, **changes})


@pytest.mark.parametrize(
    ("ratio", "expected"), [(1.040200, 1.0), (1.345125, 10.0), (1.826435, 30.0), (2.0, CROSSOVER)]
)
def test_lambda_squared_for_a_ratio(ratio, expected):
    assert lambda_squared_for(ratio) == pytest.approx(
        expected, rel=2e-5
    )  # the ratios are given to six digits


@pytest.mark.parametrize("ratio", [0.9, 1.0, 2.8606, 3.0])
def test_no_lambda_squared_for_an_impossible_ratio(ratio):
    with pytest.raises(gf.SceneError, match=r"between 1 and 2\.8606"):
        lambda_squared_for(ratio)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"supports.left": SPRINGS, "supports.right": SPRINGS},
        {"supports.left": SPRINGS, "supports.right": SOFT},
        {"supports.right": SPRINGS},
        {"supports.left": ADJACENT, "supports.right": ADJACENT},
        {"span": {"length": 100.0, "sag": 0.4, "height_difference": 25.0}},
    ],
    ids=["rigid", "springs", "unequal springs", "one spring", "adjacent spans", "inclined"],
)
def test_finite_elements_agree_at_small_sag(changes):
    scene = span(**changes)
    theory, found = modal.shallow_cable(scene), modal.natural_modes(scene, 24)

    def first(family, symmetric):
        return next(
            m.frequency_hz for m in found if m.family == family and m.symmetric == symmetric
        )

    assert theory.horizontal_hz == pytest.approx(
        first("horizontal", True), rel=2e-5
    )  # observed 1.3e-5
    assert theory.vertical_symmetric_hz == pytest.approx(
        first("vertical", True), rel=8e-5
    )  # observed 5e-5
    assert theory.vertical_antisymmetric_hz == pytest.approx(
        first("vertical", False), rel=1.5e-4
    )  # observed 9.6e-5
    assert not theory.beyond_crossover


def test_an_inclined_span_on_a_spring_is_further_off():
    # the theory neglects that an end which gives way along x1 also moves across the inclined
    # chord
    inclined = {"length": 100.0, "horizontal_tension": 50e3, "height_difference": 25.0}
    scene = span(**{"span": inclined, "supports.left": SPRINGS})
    found = modal.frequency_ratio(scene)
    assert modal.shallow_cable(scene).vertical_symmetric_hz == pytest.approx(
        found.vertical_hz, rel=4e-3
    )  # observed 2.8e-3


def test_twist_is_that_of_a_shaft():
    scene = span(**{"conductor.torsional_stiffness": 1.0})
    first = next(m for m in modal.natural_modes(scene) if m.family == "torsional")
    assert modal.shallow_cable(scene).torsional_hz == pytest.approx(
        first.frequency_hz, rel=2e-7
    )  # observed 8.5e-8


@pytest.mark.parametrize(("sag", "difference"), [(1.0, 3e-5), (4.05, 2e-3), (10.0, 1.2e-2)])
def test_the_difference_grows_with_the_square_of_the_sag(sag, difference):
    # observed 2.0e-5, 1.7e-3, 1.06e-2.  The terms that Irvine neglects are of the order
    # (sag/span)^2: the tension varies along the span, and the motion has a longitudinal part
    scene = span(**{"span": {"length": 100.0, "sag": sag}})
    theory, found = modal.shallow_cable(scene), modal.frequency_ratio(scene)
    assert abs(theory.vertical_symmetric_hz / found.vertical_hz - 1.0) < difference


def test_held_sag_and_tension_both_count():
    scene = gf.load_scene("example3")
    theory = modal.shallow_cable(scene)
    assert (theory.sag, theory.horizontal_tension) == (2.12, 15000.0)
    found = modal.frequency_ratio(scene)
    assert theory.vertical_symmetric_hz == pytest.approx(
        found.vertical_hz, rel=6e-4
    )  # observed 4.9e-4
    assert theory.torsional_hz == pytest.approx(3.93, abs=0.005)


def test_beyond_the_crossover():
    theory = modal.shallow_cable(gf.load_scene("example1"))
    assert theory.beyond_crossover
    assert theory.vertical_symmetric_hz > theory.vertical_antisymmetric_hz


def test_a_deep_sag_is_refused():
    with pytest.raises(
        gf.SceneError, match=r"sag of 13 m is more than an eighth of span.length = 100"
    ):
        modal.shallow_cable(span(**{"span": {"length": 100.0, "sag": 13.0}}))


def test_a_taut_string_has_the_ratio_one():
    scene = span(**{"span": {"length": 100.0, "sag": 0.005}, "conductor.axial_stiffness": 1e4})
    assert modal.shallow_cable(scene).ratio == pytest.approx(1.0, abs=1e-6)
    assert math.isclose(modal.shallow_cable(scene).lambda_squared, 0.0, abs_tol=1e-4)


@pytest.mark.parametrize("rise", [0.0, 0.3, 0.6, 0.9])
def test_no_span_between_rigid_ends_is_lost_to_round_off(rise):
    # pi/l l - pi is negative in doubles for 49 of the whole spans up to 1000 m: 75, 175, 300, 315,
    # ...
    scene = gf.load_scene("example3").with_values({"span.sag": None, "numerics.elements": 4})
    for length in (75.0, 175.0, 300.0, 315.0, 345.0, 350.0, 600.0, *map(float, range(20, 680, 60))):
        numbers = scene.span.model_copy(
            update={"length": length, "height_difference": rise * length}
        )
        found = modal.shallow_cable(scene.model_copy(update={"span": numbers}))
        chord = math.hypot(1.0, rise) * length
        mass = scene.conductor.mass_per_length + scene.ice.mass_per_length
        speed = math.sqrt(scene.span.horizontal_tension * math.hypot(1.0, rise) / mass)
        assert found.horizontal_hz == pytest.approx(
            speed / (2.0 * chord), rel=1e-12
        )  # a string between rigid ends


def test_a_bracket_without_a_root_is_an_error_and_no_answer():
    assert bracketed_root(lambda x: x - 1.0, 0.0, 1.0 - 1e-12) == 1.0 - 1e-12
    assert bracketed_root(lambda x: 1.0 - x, 1.0 + 1e-12, 5.0) == 1.0 + 1e-12
    with pytest.raises(ValueError, match=r"no change of sign between 0\.0"):
        bracketed_root(lambda x: x + 1.0, 0.0, 1.0)
