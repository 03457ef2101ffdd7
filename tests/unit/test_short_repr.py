"""Results of `modal` and of runs describe themselves in a few lines, and in notebooks."""

import pickle
import tomllib

import pytest

import gallop_fmu as gf
import modal
from support.lines import LINE


def test_modes_and_ratio_are_one_line_each():
    scene = gf.load_scene("example3")
    first = modal.natural_modes(scene, count=2)[0]
    assert repr(first) == "Mode(0.3775 Hz, horizontal, symmetric, 1 loop, damping 1.60 %)"
    ratio = modal.frequency_ratio(scene)
    assert repr(ratio) == "FrequencyRatio(vertical 0.6954 Hz, horizontal 0.3775 Hz, ratio 1.8421)"


def test_a_list_of_modes_has_a_line_a_row_and_a_picture_for_each():
    modes = modal.natural_modes("example3", count=4)
    assert repr(modes[:2]).splitlines()[1] == (
        " Mode(0.6954 Hz, vertical, symmetric, 1 loop, damping 1.60 %)]"
    )
    assert modes[1:3] == list(modes)[1:3]
    assert len(pickle.loads(pickle.dumps(modes))[1:].plot().axes) == 3
    assert modes._repr_html_().count("<tr>") == 5
    of_line = modal.natural_modes(gf.LineScene.from_dict(tomllib.loads(LINE)), count=2)
    assert of_line._repr_html_().count("<tr>") == 3
    assert [len(drawn.axes) for drawn in (of_line.plot(), of_line[0].plot())] == [4, 2]


def test_an_atlas_and_a_screening_are_tables_in_notebooks():
    wind = {"wind.speed": {"distribution": "uniform", "loc": 2.0, "scale": 6.0}}
    html = modal.risk_atlas("example3", wind, draws=32, workers=1)._repr_html_()
    assert html.index(">galloping</th>") < html.index(">swing</th>") < html.index(">clash</th>")
    assert " to " in html
    html = modal.screen("example3", 5.6)._repr_html_()
    assert "<td style='text-align:left'>swing from a wind of</td>" in html
    assert ">5.039</td>" in html


@pytest.mark.parametrize("package", [gf, modal])
def test_packages_complete_to_their_public_names_only(package):
    assert set(dir(package)) == set(package.__all__)


def test_result_shows_its_text_and_its_dataset_in_notebooks():
    result = gf.simulate(gf.load_scene("example3"), stop_time=5.0)
    html = result._repr_html_()
    assert "completed at 5 s" in html
    assert "xarray.Dataset" in html
    assert "<pre>Result of" in html
    assert repr(result.steady()["u2"]).startswith("Oscillation(amplitude 0.004")
    lines = repr(result.steady()).splitlines()
    assert [line.split(":")[0] for line in lines[1:5]] == ["  u2", "  u3", "  theta", "  tension"]
    assert " rad at " in lines[3]
    assert lines[5:] == ["  and 17 more channels: u1, ..., substeps"]
