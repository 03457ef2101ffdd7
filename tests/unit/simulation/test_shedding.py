"""Ice that falls in the runs of spans and lines: table, dataset, warnings, energy, text."""

import json

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import gallop_fmu as gf
from gallop_fmu.cli.main import app
from gallop_fmu.engine.model import Model
from gallop_fmu.simulation.energy_balance import MOTION_CHANNELS, energy_balance
from gallop_fmu.simulation.simulate import simulate
from support.sections import DRAKE, section

ICE = {"mass_per_length": 1.2, "torsional_inertia": 4e-4, "first_moment_x3": -2e-3}
TWO_PHASES = [{"name": "a"}, {"name": "b", "offset": [4.0, 0.0]}]


def span(*shedding, **tables):
    """A span of Drake with ice."""
    data = {
        "title": "ice that falls",
        "span": {"length": 300.0, "height_difference": 20.0, "horizontal_tension": 35e3},
        "conductor": DRAKE,
        "ice": {"mass_per_length": 1.5},
        "numerics": {"elements": 12, "time_step": 0.02},
        "run": {"stop_time": 6.0},
    }
    return gf.Scene.from_dict({**data, **tables, "shedding": list(shedding)})


def part(start, stop, **when):
    return {"from_station": start, "to_station": stop, **(when or {"time": 1.0})}


@pytest.fixture(scope="module")
def fallen():
    """A quarter falls by its time, another one where the first shakes it, the rest stays."""
    parts = [part(0.25, 0.5), part(0.5, 0.75, acceleration=1.0), part(0.8, 1.0, time=99.0)]
    return simulate(span(*parts), record_nodes="all")


@pytest.fixture(scope="module")
def line():
    """Two phases; ice falls from the middle span of the lower one, in two parts."""
    parts = [{"span": 2, "phase": 1, **part(0.0, 0.4)}, {"span": 2, "phase": 1, **part(0.4, 1.0)}]
    scene = section(
        ice={"mass_per_length": 1.0},
        phases=TWO_PHASES,
        shedding=parts,
        numerics={"elements": 12},
        run={"stop_time": 5.0},
    )
    return gf.simulate(scene)


def test_table_of_a_span(fallen):
    table, data = fallen.sheddings, fallen.dataset
    assert table["shedding"].tolist() == [1, 2, 3]
    assert table["ice"].tolist() == [1.5] * 3
    assert table["time"][0] == 1.0
    assert 1.0 < table["time"][1] < 1.5
    assert np.isnan(table["time"][2])
    assert table.attrs["units"]["highest_rise"] == "m"
    after = data["u2"].sel(time=slice(table["time"][0], None))
    worst = after.where(after == after.max(), drop=True)
    assert table["highest_rise"][0] == after.max()
    assert table["highest_rise_time"][0] == worst.time.item()
    assert table["highest_rise_station"][0] == pytest.approx(worst.node.item() / 24)
    assert table["lowest_rise"][0] == after.min() < 0.0
    assert table["final_rise"][0] == table["final_rise"][1] == data["u2_settled"].sel(node=12)
    assert "unbalanced_pull" not in table


def test_final_rise_is_that_of_the_span_with_the_ice_that_is_left(fallen):
    """Another way: the equilibrium of a model whose ice has fallen at the start."""
    times = np.where(np.isfinite(fallen.sheddings["time"]), 0.0, np.inf)
    model = Model(fallen.scene, shedding_times=times)
    u = model.rest().motion()[0]
    assert fallen.dataset["u2_settled"].values == pytest.approx(u[:, 1], abs=1e-8)
    assert fallen.dataset["left_f1_settled"].item() == pytest.approx(
        model.rest().observe_span()[1], rel=1e-9
    )


def test_mid_span_is_at_half_of_the_length(fallen):
    """Parts of any length: half of the elements lie on either side of mid-span."""
    scene = span(part(0.03, 0.31), part(0.52, 0.9))
    model = Model(scene)
    assert model.middle == scene.numerics.elements == 12
    assert model.map.chains[0].stations[12] == 0.5
    x = model.equilibrium().x
    step = np.linalg.norm(np.diff(x, axis=0), axis=1)  # chords, a little shorter than the arc
    assert step[:12].sum() == pytest.approx(step[12:].sum(), rel=1e-4)
    assert [piece.from_station for piece in model.map.sheddings] == [0.03, 0.52]


@pytest.mark.parametrize(("start", "elements"), [(0.25, 16), (0.0, 15)])
def test_odd_numbers_of_elements_are_made_even_for_a_part(start, elements):
    """Mid-span must be a node between two elements; the whole span needs none."""
    scene = span(part(start, 1.0), numerics={"elements": 15})
    assert scene.elements == elements == Model(scene).elements == Model(scene).middle
    result = simulate(scene, 2.0)
    assert result.midspan()["u2"].max() > 0.1
    assert result.steady()["u2"].amplitude > 0.0
    assert gf.sweep(scene, {"shedding.0.time": [0.5]}, stop_time=1.0).dataset.u2_highest > 0.05


@pytest.mark.parametrize("held", [{}, {"sag": 8.0}])
def test_places_of_a_span_are_fractions_of_its_length(held):
    """In the parabola that is held as well as on the catenary."""
    given = {"length": 300.0, "height_difference": 20.0, "horizontal_tension": 35e3, **held}
    if held:
        given["horizontal_tension"] = 43.1e3
    model = Model(span(part(0.2, 0.7), span=given))
    x = model.equilibrium().x
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(x, axis=0), axis=1))])
    chain = model.map.chains[0]
    found = length[2 * np.array(chain.corners)] / length[-1]
    assert found == pytest.approx(chain.fractions, abs=1e-4)  # chords; observed 3e-5
    assert chain.fractions == (0.0, 0.2, 0.5, 0.7, 1.0)


def test_dataset(fallen, tmp_path):
    data = fallen.dataset
    assert data["shed_time"].dims == ("shedding",)
    assert data["shed_time"].attrs["units"] == "s"
    assert data["shedding_from_station"].values.tolist() == [0.25, 0.5, 0.8]
    assert data["shed_kinetic_energy"][0] == pytest.approx(0.0, abs=1e-20)  # it was at rest
    assert "shed_time" not in fallen.midspan()
    assert "u2_settled" not in fallen.midspan()
    fallen.save(tmp_path / "run.nc")
    with xr.open_dataset(tmp_path / "run.nc") as read:
        xr.testing.assert_equal(read["shed_time"].load(), data["shed_time"])
    fallen.save(tmp_path / "run.csv")
    assert "settled" not in (tmp_path / "run.csv").read_text().partition("\n")[0]


def test_table_of_a_line(line):
    table, data = line.sheddings, line.dataset
    assert table["span"].tolist() == [2, 2]
    assert table["from_station"].tolist() == [0.0, 0.4]
    mid_span = line.midspan(2, 1)
    assert table["highest_rise"][1] == mid_span["u2"].max()
    late = data["tower_force_x1"].sel(time=slice(1.0, None))
    assert table["unbalanced_pull"][0] == np.abs(late[:, 1:3]).max()
    assert table["final_unbalanced_pull"][0] == np.abs(data["tower_force_x1_settled"][1:3]).max()
    nearest = line.clearances.set_index("span").loc[2]
    assert table["smallest_clearance"][0] == nearest["smallest"] < 1.0
    assert table["clearance_time"][0] == nearest["time"] > 1.0
    assert nearest["at_rest"] == pytest.approx(4.0, abs=0.02)  # of meshes that differ
    assert line.towers["force_x1_settled"][1:3].notna().all()
    assert np.all(line.strings["pull_settled"] > 0.0)
    assert line.strings.attrs["units"]["lean_along_settled"] == "rad"
    assert not any("shedding" in text for text in line.warnings)


def test_clearance_is_that_after_the_fall():
    """A phase that comes close before its ice falls."""
    push = {"kind": "pulse", "peak": 1.0, "start": 0.0, "rise": 0.2, "fall_start": 0.6, "fall": 0.2}
    load = {"span": 1, "phase": 1, "position": 0.5, "force": [0.0, 1e3, 0.0], "law": push}
    scene = section(
        (300.0,),
        phases=TWO_PHASES,
        ice={"mass_per_length": 0.1},
        loads=[load],
        shedding=[{"span": 1, "phase": 2, "time": 3.0}],
        run={"stop_time": 4.0},
    )
    result = gf.simulate(scene)
    assert result.clearances["time"][0] < 3.0
    assert result.sheddings["clearance_time"][0] >= 3.0
    assert result.sheddings["smallest_clearance"][0] > result.clearances["smallest"][0]


def test_warnings_where_no_ice_fell(fallen):
    [late] = [text for text in fallen.warnings if text.startswith("shedding")]
    assert late == (
        "shedding.2 (shedding 3): No ice fell in the run: its time is 99 s and the run ends at 6 s."
        " Run longer (run.stop_time, --stop-time), or give an earlier time."
    )
    result = simulate(span(part(0.0, 1.0, acceleration=500.0)), 1.0)
    [quiet] = [text for text in result.warnings if text.startswith("shedding")]
    assert "its limit of acceleration, 500 m/s2, was not exceeded" in quiet
    assert "u2_settled" not in result.dataset


def test_a_failed_start_has_no_times():
    """A seed that shortens the cable by more than its elastic elongation."""
    given = {"length": 95.0, "horizontal_tension": 20e3}
    scene = span(part(0.0, 1.0), span=given, initial={"seed_vertical": 3.0})
    result = simulate(scene, 5.0, on_failure="return")
    assert not result.started
    assert np.isnan(result.sheddings["time"]).all()


WIND = {
    "wind": {"speed": 8.0},
    "ice": ICE,
    "aerodynamics": {
        **{"kind": "polynomial", "lift": [0.0, -1.2], "drag": [1.0], "moment": [0.0, -0.3]},
        **{"valid_from_deg": -180.0, "valid_to_deg": 180.0},
        "outside": "hold",
    },
    "damping": {
        name: {"low_ratio": 0.01, "low_frequency": 0.2, "high_ratio": 0.01, "high_frequency": 5.0}
        for name in ("translation", "twist")
    },
    "loads": [
        {
            **{"position": 0.4, "force": [0.0, 200.0, 300.0], "torque": 5.0},
            "law": {
                **{"kind": "pulse", "peak": 1.0, "start": 0.0, "rise": 1.0},
                **{"fall_start": 1.0, "fall": 1.0},
            },
        }
    ],
}


@pytest.mark.parametrize("kind", ["span", "line"])
def test_energy_balance(kind):
    """Ice that falls by time and by acceleration takes its energy along."""
    parts = [part(0.0, 0.5, time=1.0), part(0.5, 1.0, acceleration=2.0)]
    numerics = {"elements": 8, "time_step": 0.01, "newton_tolerance": 1e-11}
    if kind == "span":
        scene = span(*parts, **{**WIND, "numerics": numerics})
    else:
        loads = [{"span": 1, **load} for load in WIND["loads"]]
        falls = [{"span": 1, **one} for one in parts]
        tables = {**WIND, "loads": loads, "shedding": falls, "numerics": numerics}
        scene = section((120.0, 150.0), **tables)
    result = gf.simulate(scene, 3.0, record_nodes="all", channels=MOTION_CHANNELS)
    found = energy_balance(result)
    energy = result.sheddings[["kinetic_energy", "potential_energy"]].to_numpy().sum()
    assert np.isfinite(result.sheddings["time"]).all()
    assert found.shed[0] == 0.0
    assert found.shed[-1] == pytest.approx(energy)
    assert abs(energy) > 0.01 * found.turnover
    assert found.worst < 2e-4  # observed 1.2e-4 and
    without = np.abs(found.imbalance - found.shed).max() / found.turnover
    assert without > 0.01


def test_given_times_take_the_place_of_those_of_the_scene():
    scene = span(part(0.0, 0.5, acceleration=2.0), part(0.5, 1.0, time=0.5))
    state = Model(scene, inputs=False, shedding_times=[0.2, np.inf]).start()
    state.advance(1.0)
    assert state.shedding_times().tolist() == [0.2, np.inf]
    with pytest.raises(ValueError, match="must be 2 times in s"):
        Model(scene, shedding_times=[0.2])


def test_command_line(tmp_path):
    path = tmp_path / "span.toml"
    span(part(0.25, 0.75), part(0.0, 0.25, time=99.0)).save(path)
    text = CliRunner().invoke(app, ["run", str(path), "--stop-time", "3"]).output
    assert "0.25-0.75" in text
    assert "not" in text
    assert "No ice fell in the run" in " ".join(text.split())
    found = CliRunner().invoke(app, ["run", str(path), "--stop-time", "3", "--json"]).output
    rows = json.loads(found)["sheddings"]
    assert rows[0]["time"] == 1.0
    assert rows[1]["time"] is None


def test_sweep(tmp_path):
    scene = span(part(0.25, 0.75))
    runs = gf.sweep(scene, {"shedding.0.time": [1.0, 99.0]}, stop_time=4.0)
    single = simulate(scene, 4.0).sheddings.iloc[0]
    rows = runs.dataset
    assert rows.highest_rise.values[0] == pytest.approx(single.highest_rise)
    assert rows.final_rise.values[0] == pytest.approx(single.final_rise)
    assert rows.highest_rise.attrs["units"] == "m"
    assert np.isnan(rows.shed_time.values[1])
    assert "No ice fell" in rows.warnings.values[1]
    line = section(
        (300.0, 280.0), ice={"mass_per_length": 1.0}, shedding=[{"span": 1, "time": 0.5}]
    )
    row = gf.sweep(line, {"shedding.0.time": [0.5]}, stop_time=3.0).dataset.isel(run=0)
    assert row.unbalanced_pull > 500.0
    assert row.shed_time == 0.5
