"""Natural frequencies of sections, bundles and phases against OpenSees and a lumped chain.

The stored values are extrapolated from two meshes, to about 1e-5 Hz.
"""

import numpy as np
import pytest

import modal
from support.line_references import line_scene, stored

SECTIONS = [
    "section_frequencies_zebra_1_span",
    "section_frequencies_zebra_2_spans",
    "section_frequencies_zebra_3_spans",
    "section_frequencies_example2_3_spans",
    "section_frequencies_drake_3_spans",
    "new_section_frequencies_1",
    "new_section_frequencies_2",
    "new_section_frequencies_3",
]
BUNDLES = ["bundle_frequencies_quad_200m", "bundle_frequencies_triple_300m"]
DRAWN_BUNDLES = ["new_bundle_frequencies_1", "new_bundle_frequencies_2"]
FAMILIES = {"vertical": "vertical", "horizontal": "horizontal", "torsion": "bundle torsion"}
IN_PLANE = ("vertical", "tension-neutral", "longitudinal")


def modes_by_family(case, count, elements=30):
    """Frequencies [Hz] of the lowest modes by family, without twist of subconductors."""
    found = {}
    for mode in modal.natural_modes(line_scene(case, elements), count=count):
        found.setdefault(mode.family, []).append(mode.frequency_hz)
    return found


def extrapolated(case, key):
    """Frequencies [Hz] of the stored case, for zero mesh size."""
    if "repeated" in case:
        return np.array(case["repeated"][f"{key}_extrapolated"])
    return np.array(case["results"][key])


@pytest.mark.parametrize("name", SECTIONS)
def test_section(name):
    case = stored(name)
    found = modes_by_family(case, 26)
    in_plane = sorted(f for family in IN_PLANE for f in found.get(family, ()))
    for key, values in (("in_plane", in_plane), ("out_of_plane", found["horizontal"])):
        wanted = extrapolated(case, key)
        assert values[: len(wanted)] == pytest.approx(wanted, rel=1e-5), key  # observed 6.8e-6


@pytest.mark.parametrize("name", BUNDLES + DRAWN_BUNDLES)
def test_bundle_without_twist(name):
    case = stored(name)
    found = modes_by_family(case, 14)
    for key, family in FAMILIES.items():
        wanted = extrapolated(case, key)
        assert found[family][: len(wanted)] == pytest.approx(wanted, rel=1.2e-5), family  # 9.1e-6


def test_twin_bundle_with_elastic_clamps():
    case = stored("bundle_frequencies_twin_drake")
    found = modes_by_family(case, 12)
    for key, family in FAMILIES.items():
        wanted = extrapolated(case, key)
        assert found[family][: len(wanted)] == pytest.approx(wanted, rel=5.5e-5), family  # 4.1e-5


def test_section_of_twin_bundles_with_yokes():
    case = stored("new_bundle_section_frequencies")
    wanted = case["results"]["all"]
    modes = modal.natural_modes(line_scene(case, 30), count=len(wanted))
    assert [mode.frequency_hz for mode in modes] == pytest.approx(wanted, rel=7e-5)  # 5.5e-5


def test_interphase_spacers_stiffen_opposed_motion_only():
    case = stored("interphase_frequencies_zebra")
    for row in case["repeated"]["opposed_in_plane"]:
        case["scene"]["devices"] = [
            {"kind": "interphase_spacer", "station": station, "mass": 0.0}
            for station in row["spacers_at"]
        ]
        modes = modal.natural_modes(line_scene(case, 30), count=16)
        found = [mode for mode in modes if mode.family == "vertical"]
        frequencies = np.array([mode.frequency_hz for mode in found])
        for wanted in row["frequencies_extrapolated"]:
            assert np.abs(frequencies / wanted - 1.0).min() < 5e-5, (row["spacers_at"], wanted)
        together = np.sum(np.abs(frequencies / 0.3666436 - 1.0) < 5e-5)
        assert together == (1 if len(row["spacers_at"]) == 2 else 2)
