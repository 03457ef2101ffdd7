"""Devices in modes and statics of lines: pendulums, interphase spacers, torque on a bundle."""

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from tests.support.line_references import line_scene, stored
from tests.support.line_scenes import in_plane, of_family, section, zebra


def test_a_pendulum_lowers_the_frequency_of_a_torsion_bar():
    """Closed form of the stored case; a heavy conductor keeps the clamp in its place.

    Seen: 4e-6 of the first frequencies, 3e-6 of the second.
    """
    case = stored("pendulum_frequencies_example3")
    bar = case["scene"]["torsional_stiffness"], case["scene"]["torsional_inertia"]

    def symmetric(devices):
        scene = section(*(1e12, [125.88], 1e6, 1e15), elements=24, torsion=bar, devices=devices)
        found = [m for m in modal.natural_modes(scene, 10) if m.family == "torsional"]
        middle = (len(found[0].shape) - 1) // 2
        turning = [abs(m.shape[middle, 3]) > 1e-6 * abs(m.shape[:, 3]).max() for m in found]
        return [m.frequency_hz for m, turns in zip(found, turning, strict=True) if turns]

    assert symmetric([])[0] == pytest.approx(case["results"]["bare"], rel=1e-5)
    for pendulum in case["results"]["cases"]:
        device = {"kind": "pendulum", "span": 1, "station": 0.5}
        device |= {"mass": pendulum["mass"], "arm": pendulum["arm"]}
        wanted = pendulum["frequencies"]
        assert symmetric([device])[: len(wanted)] == pytest.approx(wanted, rel=1e-5)


def two_phases(spacers_at):
    spacer = {"kind": "interphase_spacer", "span": 1, "phases": [1, 2], "stiffness": 1e9}
    return zebra(
        elements=24,
        phases=[{"name": "a", "offset": [0.0, 0.0]}, {"name": "b", "offset": [5.0, 0.0]}],
        devices=[{**spacer, "station": station} for station in spacers_at],
    )


@pytest.mark.parametrize("case", [0, 1, 2])
def test_interphase_spacers_stop_opposed_modes_alone(case):
    """Seen: 5.1e-5 of OpenSees, extrapolated, for four loops."""
    given = stored("interphase_frequencies_zebra")
    fine = given["repeated"]["opposed_in_plane"][case]
    found = modal.natural_modes(two_phases(fine["spacers_at"]), 20)
    vertical = np.array(in_plane(found))
    for opposed in fine["frequencies_extrapolated"]:
        assert np.min(np.abs(vertical / opposed - 1.0)) < 7e-5
    across = np.array(of_family(found, "horizontal"))
    for untouched in given["results"]["untouched"]:  # not extrapolated: 2.1e-4
        assert np.min(np.abs(np.concatenate([vertical, across]) / untouched - 1.0)) < 3e-4
    moved = [m for m in found if m.family == "vertical" and min(m.phase_shares) > 0.01]
    assert bool(moved) == bool(fine["spacers_at"])


def test_torque_on_a_spacer_turns_a_quad_bundle():
    """OpenSees with a torque that follows the frame; seen: 2.6e-4."""
    case = stored("bundle_torque_quad_300m")
    stiff = {"bundle.clamp_torsional_stiffness": 1e5, "conductor.torsional_stiffness": 1e-2}
    turns = []
    for torque in case["results"]["torque_n_m"]:
        load = {"span": 1, "position": 0.5, "force": [0.0, 0.0, 0.0], "torque": torque / 4.0}
        model = gf.Model(line_scene(case, elements=16, loads=[load]).with_values(stiff))
        u, _, _ = model.rest().motion()
        middle = [chain.middle for chain in model.map.chains]
        before = model.equilibrium().x[middle, 1:]
        after = before + u[middle, 1:3]
        (y0, z0), (y1, z1) = ((p - p.mean(axis=0)).T for p in (before, after))
        turns.append(np.degrees(np.arctan2(np.sum(y0 * z1 - z0 * y1), np.sum(y0 * y1 + z0 * z1))))
    assert turns == pytest.approx(case["repeated"]["turn_deg_follower_torque"], rel=5e-4)


def test_a_section_turned_end_for_end_has_mirrored_modes():
    """Uneven and inclined spans, twin bundles with yokes, a pendulum."""

    def line(mirrored):
        order = slice(None, None, -1 if mirrored else 1)
        sign = -1.0 if mirrored else 1.0
        spans = [(220.0, 6.0), (180.0, -4.0), (250.0, 9.0)][order]
        strings = [(2.4, 600.0), (2.0, 450.0)][order]
        return gf.LineScene.from_dict(
            {
                "title": "line",
                "section": {
                    "horizontal_tension": 21e3,
                    "spans": [{"length": s, "height_difference": sign * h} for s, h in spans],
                    "suspensions": [
                        {"kind": "string", "length": length, "weight": weight}
                        for length, weight in strings
                    ],
                },
                "bundle": {"subconductors": 2, "spacing": 0.4, "spacers": 2},
                "conductor": {
                    "diameter": 0.03,
                    "mass_per_length": 1.6,
                    "axial_stiffness": 30e6,
                    "torsional_stiffness": 200.0,
                    "torsional_inertia": 3e-4,
                },
                "devices": [
                    {
                        "kind": "pendulum",
                        "span": 3 if mirrored else 1,
                        "station": 0.7 if mirrored else 0.3,
                        "mass": 10.0,
                        "arm": 0.4,
                    }
                ],
                "numerics": {"elements": 10},
            }
        )

    found, mirrored = (modal.natural_modes(line(kind), 12) for kind in (False, True))
    for one, other in zip(found, mirrored, strict=True):
        assert other.frequency_hz == pytest.approx(one.frequency_hz, rel=1e-9)
        assert other.span_shares[::-1] == pytest.approx(one.span_shares, abs=1e-6)
        assert (other.family, other.loops[::-1]) == (one.family, one.loops)
