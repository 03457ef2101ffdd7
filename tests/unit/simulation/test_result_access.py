"""What a result offers at once: histories as attributes, a table, figures, completion."""

import copy
import pickle
import subprocess
import sys

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from support.line_scenes import section, zebra


@pytest.fixture(scope="module")
def result():
    return gf.simulate("example3", 4.0)


@pytest.fixture(scope="module")
def line_result():
    seed = {"initial": {"seed_vertical": 0.1, "seed_horizontal": 0.05}}
    return gf.simulate(zebra(3, elements=4, **seed), 4.0)


def test_channels_are_attributes(result):
    assert result.u2.equals(result.midspan()["u2"])
    assert result.u2.attrs["units"] == "m"
    assert result.wind_speed.equals(result.dataset["wind_speed"])


def test_channels_of_a_line_are_over_its_spans(line_result):
    assert line_result.u2.dims == ("time", "line_span")
    for span in (1, 2, 3):
        own = line_result.bundle(span)["u2"].values
        assert np.array_equal(line_result.u2.sel(line_span=span).values, own)
    assert line_result.string_pull.dims == ("time", "tower", "line_phase")


def test_channels_of_phases_and_bundles():
    scene = section(
        19785.0,
        [300.0],
        15.90,
        44.389e6,
        elements=4,
        phases=[{"name": "a"}, {"name": "b", "offset": [5.0, 0.0]}],
        bundle={"subconductors": 2, "spacing": 0.4},
        initial={"seed_vertical": 0.1},
    )
    found = gf.simulate(scene, 1.0)
    assert found.theta.dims == ("time", "line_phase")
    own = found.bundle(1, 2)["theta"].values
    assert np.array_equal(found.theta.sel(line_phase=2).values, own)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("a2", r"a2 was not recorded; the run has u1, u2"),
        ("stedy", r"Result has no attribute or channel 'stedy'; closest: steady"),
        ("_private", r"Result has no attribute or channel '_private'$"),
    ],
)
def test_missing_attributes_are_named(result, name, message):
    with pytest.raises(AttributeError, match=message):
        getattr(result, name)
    assert not hasattr(result, name)


def test_a_run_without_mid_span_has_no_attribute_of_it():
    found = gf.simulate("example3", 0.5, record_nodes=[3])
    with pytest.raises(AttributeError, match=r"mid-span node .* was not recorded; simulate with"):
        found.u2  # noqa: B018


def test_an_error_inside_a_property_is_its_own(result, monkeypatch):
    monkeypatch.setattr(type(result), "outcome", property(lambda self: self.report.nothing))
    with pytest.raises(AttributeError, match="'Report' object has no attribute 'nothing'"):
        result.outcome  # noqa: B018


def test_completion_shows_what_is_public(result, line_result):
    assert {"u2", "theta", "wind_speed", "steady", "plot", "to_dataframe"} <= set(dir(result))
    assert "a2" not in dir(result)
    assert {"u3", "string_pull", "strings", "bundle"} <= set(dir(line_result))
    for found in (result, line_result):
        assert not [name for name in dir(found) if name.startswith("_")]
        assert all(hasattr(found, name) for name in dir(found))


def test_a_result_can_be_copied_and_pickled(result):
    for again in (copy.copy(result), pickle.loads(pickle.dumps(result))):
        assert again.u2.equals(result.u2)


def test_the_table_has_mid_spans_and_units(result, line_result):
    frame = result.to_dataframe()
    assert frame.index.name == "time"
    assert frame["u2"].to_numpy().tolist() == result.u2.values.tolist()
    assert frame.attrs["units"]["u2"] == "m"
    of_line = line_result.to_dataframe()
    own = line_result.bundle(2)["u2"].values
    assert of_line["span[2].u2"].to_numpy().tolist() == own.tolist()
    assert of_line.attrs["units"]["tower[1].string_pull"] == "N"


def test_results_draw_themselves(result, line_result):
    assert len(result.plot().subfigs) + len(result.plot().axes) > 0
    assert result.trace(windows={"end": (2.0, 4.0)}).axes
    assert len(line_result.plot().axes) == 5  # three spans, leans across and along
    assert line_result.trace().axes
    with pytest.raises(gf.SceneError, match="phase 2 does not exist"):
        line_result.plot(phase=2)


def test_notebooks_show_the_figures(result):
    """IPython calls `_repr_png_`; it knows the figures of pyplot only."""
    figure = pickle.loads(pickle.dumps(result.trace()))
    assert figure._repr_png_().startswith(b"\x89PNG")


def test_leans_that_were_not_recorded_are_not_drawn():
    scene = zebra(2, elements=4, initial={"seed_vertical": 0.1})
    found = modal.mode_superposition(scene, 2.0, vertical=1, horizontal=1, torsional=0)
    assert len(found.plot().axes) == 2


def test_modal_objects_draw_themselves():
    scene = gf.load_scene("example3").with_values({"numerics.elements": 8})
    assert modal.natural_modes(scene, 1)[0].plot().axes
    assert modal.required_slope(scene, [4.0, 6.0], count=2).plot().axes
    assert modal.screen(scene, 5.6).plot().axes
    assert modal.compare(scene, 5.0).plot().subfigs


def test_matplotlib_is_loaded_when_a_figure_is_drawn():
    code = (
        "import sys, gallop_fmu as gf, modal; r = gf.simulate('example3', 0.5); dir(r); r.u2;"
        "assert 'matplotlib' not in sys.modules; r.plot(); assert 'matplotlib' in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
