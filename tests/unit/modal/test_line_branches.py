"""Branches of lines: names, places, files, figure, command, and what is refused."""

import json

import numpy as np
import pytest
from typer.testing import CliRunner

import gallop_fmu as gf
import modal
from modal.cli.main import app
from modal.motions.line_model import LineModel
from modal.motions.span_problem import NumberFamily, SpanProblem
from support.galloping_lines import STRING, section_of_example2


@pytest.fixture(scope="module")
def scene():
    return section_of_example2(2, elements=4)


@pytest.fixture(scope="module")
def found(scene):
    return modal.branches(scene, "wind.speed", 0.36, 0.379)


def test_motions_of_a_section_have_names_places_and_onsets(found, scene):
    data = found.dataset
    assert data["name"].values[0] == "rest"
    assert "one loop" in data["name"].values
    assert any("spans against each other" in name for name in data["name"].values)
    hopf = data.event_value.values[data.event_kind.values == "Hopf"]
    modes = modal.natural_modes(scene.with_values({"wind.speed": float(hopf[0])}), 10, wind="mean")
    # at the first onset, the mode that grows fastest neither grows nor decays
    assert max(mode.eigenvalue.real for mode in modes) == pytest.approx(0.0, abs=1e-6)
    assert data.sizes["span"] == 2
    assert data.sizes["tower"] == 1
    assert data.u2_by_span.max() == pytest.approx(data.u2_amplitude.max().item())
    assert np.nanmax(data.reduction_error.values) < 5e-3  # observed
    assert len(found.plot().axes) == 4


def test_the_command_takes_a_line(scene, tmp_path):
    path = tmp_path / "line.toml"
    path.write_text(scene.to_toml())
    arguments = ["branches", str(path), "--over", "wind.speed", "0.37", "0.376", "--json"]
    done = CliRunner().invoke(app, [*arguments, "-o", str(tmp_path / "line.png")])
    assert done.exit_code == 0, done.output
    assert json.loads(done.stdout)["name"] == ["rest"]


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"aerodynamics": None, "wind": {"speed": 0.0}}, "aerodynamics is not given"),
        ({"wind.direction_deg": 10.0}, "uniform wind towards"),
        ({"section.spans.1.wind": {"speed": 3.0}}, r"section.spans.1.wind is given"),
        (
            {
                "ice.mass_per_length": 0.1,
                "shedding": [{"time": 1.0, "span": 1, "from_station": 0.2, "to_station": 0.4}],
            },
            "periodic motions keep their ice",
        ),
    ],
)
def test_what_cannot_be_done_is_refused(scene, changes, message):
    with pytest.raises(gf.SceneError, match=message):
        modal.branches(scene.with_values(changes), start=0.3, stop=0.4)


def test_another_number_has_the_same_onset(scene, found):
    """Longer strings: the coordinates of the reduced models are continuous."""
    onset = float(found.dataset.event_value.values[0])
    windy = scene.with_values({"wind.speed": onset})
    model = LineModel(windy)
    problem = SpanProblem(
        NumberFamily(windy, "section.suspensions.0.length", model, 1e-4), model, onset
    )
    rates = problem.rates(np.zeros((1, problem.size)), STRING["length"])
    q = np.zeros((1, problem.size))
    values = problem.family.at(STRING["length"] + 0.01)[0].motion(
        q[:, : model.size], q[:, : model.size], onset
    )
    change = (values.acceleration - rates.value[:, model.size :]) / 0.01
    slope = rates.by_parameter[:, model.size :]
    assert change == pytest.approx(slope, abs=0.02 * np.max(np.abs(slope)))
