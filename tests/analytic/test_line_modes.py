"""Natural modes of lines against OpenSees, closed forms and exact relations.

Numbers marked OpenSees are those of an independent model of straight bars (LINE: level sections,
conductors of mass per unstretched length, no twist), in Hz. Its meshes of 80 to 320 elements a span
are up to 0.04 % too stiff for the modes listed here; ours of 30 elements are within 0.002 % of
finer ones.
"""

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from tests.support.line_scenes import in_plane, of_family, zebra

OPENSEES = 5e-4
"""Bound on relative deviations from OpenSees; observed below."""


@pytest.fixture(scope="module")
def one_span():
    return modal.natural_modes(zebra(), 8)


def test_one_span_has_the_frequencies_of_opensees(one_span):
    """Observed: 4.2e-4, of a mode with three loops."""
    vertical, across = in_plane(one_span), of_family(one_span, "horizontal")
    assert vertical[:3] == pytest.approx([0.36672, 0.49544, 0.68960], rel=OPENSEES)
    assert across[:2] == pytest.approx([0.18410, 0.36807], rel=OPENSEES)


def test_a_line_of_one_span_has_the_modes_of_the_span():
    line = zebra(elements=8)
    span = gf.Scene.from_dict(
        {
            "title": "span",
            "span": {"length": 300.0, "horizontal_tension": 19785.0, "gravity": 9.81},
            "supports": {"left": {"kind": "rigid"}, "right": {"kind": "rigid"}},
            "conductor": line.conductor.model_dump(mode="json", exclude_none=True),
            "numerics": {"elements": 8},
        }
    )
    wanted, found = modal.natural_modes(span, 12), modal.natural_modes(line, 12)
    for one, other in zip(wanted, found, strict=True):
        assert other.frequency_hz == pytest.approx(one.frequency_hz, rel=1e-10)  # seen: 1e-12
        assert (other.family, other.loops) == (one.family, (one.loops,))


def test_spans_between_posts_do_not_take_part_in_each_other():
    """Equal frequencies of three equal spans do not mix their modes."""
    found = modal.natural_modes(zebra(3, string=None, elements=8), 12)
    for three in (found[k : k + 3] for k in range(0, 12, 3)):
        assert len({mode.family for mode in three}) == 1
        taking_part = np.sort([np.argmax(mode.span_shares) for mode in three])
        assert taking_part.tolist() == [0, 1, 2]
        for mode in three:
            assert mode.span_shares.max() > 1.0 - 1e-12
            assert sum(loops > 0 for loops in mode.loops) == 1
            assert mode.frequency_hz == pytest.approx(three[0].frequency_hz, rel=1e-11)


def test_modes_have_unit_mass_and_shares_add_up():
    from gallop_fmu.engine.mesh import Mesh

    scene = zebra(2, string=None, elements=6)
    mesh = Mesh(gf.Model(scene))
    mass = mesh.assemble(mesh.model.tangent(mass=1.0, inputs=mesh.still))
    for mode in modal.natural_modes(scene, 6):
        shape = mode.shape.ravel()
        assert shape @ (mass @ shape) == pytest.approx(1.0, rel=1e-12)
        for shares in (mode.span_shares, mode.phase_shares, mode.subconductor_shares):
            assert shares.sum() == pytest.approx(1.0, rel=1e-12)
        assert sum(mode.shares.values()) == pytest.approx(1.0, rel=1e-12)
        assert mode.device_share < 1e-12


def test_tension_share_of_a_mode_is_its_stiffening_by_the_sag(one_span):
    """Antisymmetric modes have no first-order change of tension; the stiffened ones have."""
    shares = {mode.loops[0]: mode.tension_share for mode in one_span if mode.family == "vertical"}
    assert shares[2] < 1e-4
    symmetric = [m.tension_share for m in one_span if m.family == "vertical" and m.loops[0] == 3]
    assert symmetric == pytest.approx([0.208, 0.636], abs=0.01)  # between one and three loops


@pytest.mark.parametrize("count", [0, True, 10000, 2.0])
def test_an_impossible_number_of_modes_is_refused(count):
    with pytest.raises(gf.SceneError, match="must be a whole number from 1 to"):
        modal.natural_modes(zebra(elements=4), count)


REFUSALS = {
    "screen": (modal.screen, "frequency_ratio"),
    "two_mode_estimate": (modal.two_mode_estimate, "frequency_ratio"),
    "shallow_cable": (modal.shallow_cable, "natural_modes"),
    "mode superposition": (modal.mode_superposition, "simulate the line"),
    "a report": (lambda scene: modal.write_report(scene, "x.html"), "line_criteria"),
    "linear_model": (modal.linear_model, "critical_wind_speed"),
    "suggest_design_changes": (modal.suggest_design_changes, "with_values"),
    "ratio_map": (lambda scene: modal.ratio_map(scene, "span.sag", [1.0]), "with_values"),
    "track_modes": (lambda scene: modal.track_modes(scene, "wind.speed", [1.0]), "with_values"),
}


@pytest.mark.parametrize("name", REFUSALS)
def test_functions_of_one_span_say_what_to_use_for_a_line(name):
    function, instead = REFUSALS[name]
    with pytest.raises(gf.SceneError, match=f"{name} takes a scene of one span") as found:
        function(zebra(2, string=None, elements=4))
    assert "a section of 2 spans" in str(found.value)
    assert instead in str(found.value)
