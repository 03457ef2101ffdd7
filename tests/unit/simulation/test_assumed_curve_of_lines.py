"""Lines, bundles and FMUs with the assumed coefficient curve."""

import fmpy
import numpy as np
import pytest

import gallop_fmu as gf
import modal
from gallop_fmu.fmu.variables import fmu_variables
from gallop_fmu.line.section_table import section_data

TOWERS = "name,span length,string length,string weight\n1,180,,\n2,150,2.4,600\n3,,,\n"


@pytest.fixture
def line(tmp_path):
    (tmp_path / "towers.csv").write_text(TOWERS)
    options = {
        "section": "towers.csv",
        "conductor": "Drake",
        "stringing_percent": 20.0,
        "ice_thickness": 0.003,
        "wind_speed": 8.0,
    }
    scene = gf.LineScene.from_dict(section_data(options, tmp_path), tmp_path)
    return scene.with_values({"numerics.elements": 4})


def test_an_interval_of_a_line_may_have_another_assumed_curve(line):
    part = {
        "kind": "interval",
        "span": 1,
        "from_station": 0.25,
        "to_station": 0.75,
        "aerodynamics": {"kind": "assumed", "ice_thickness_ratio": 0.0},
    }
    uneven = line.with_values({"devices": [part]})
    assert sum("ASSUMED" in warning for warning in uneven.warnings) == 2
    runs = [gf.simulate(scene, stop_time=5.0) for scene in (line, uneven)]
    assert all(any("ASSUMED" in warning for warning in run.warnings) for run in runs)
    assert runs[0].dataset.attrs["coefficient_curve"].startswith("ASSUMED")
    own, other = (run.dataset.u2.values for run in runs)
    assert np.abs(own - other).max() > 1e-6


def test_the_equivalent_conductor_of_a_bundle_has_the_curve_with_a_warning(line):
    bundle = line.with_values({"bundle": {"subconductors": 2, "spacing": 0.4, "spacers": 1}})
    found = modal.equivalent_bundle(bundle).scene
    alpha = np.linspace(-3.0, 3.0, 61)
    # Observed: 1e-4, from the interpolation of the table.
    np.testing.assert_allclose(
        found.aerodynamics.curve().lift(alpha),
        2.0 * bundle.aerodynamics.curve().lift(alpha),
        rtol=0,
        atol=2e-4,
    )
    assert any("ASSUMED" in warning for warning in found.warnings)


def test_an_fmu_moves_as_the_simulation_and_has_no_parameter_for_the_ice(line, tmp_path):
    span = gf.Scene.from_dict(
        {
            "line": {
                "conductor": "Drake",
                "span": 150.0,
                "stringing_percent": 20.0,
                "ice_thickness": 0.003,
                "wind_speed": 8.0,
            },
            "numerics": {"elements": 4},
        }
    )
    for scene in (line, span):
        assert not any("ice_thickness_ratio" in variable.name for variable in fmu_variables(scene))
    file = gf.export_fmu(span, tmp_path / "span.fmu")
    rows = fmpy.simulate_fmu(str(file), stop_time=5.0, output_interval=0.05)
    own = gf.simulate(span, stop_time=5.0).midspan().u2.values
    np.testing.assert_array_equal(rows["midspan.x2"] - rows["midspan.x2"][0], own - own[0])
