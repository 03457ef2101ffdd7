"""Branches of example 3: names, events, files, figure, command, and simulations from them."""

import json
from dataclasses import replace

import numpy as np
import pytest
import xarray as xr
from typer.testing import CliRunner

import gallop_fmu as gf
import modal
from modal.cli.main import app
from modal.continuation.diagram import Diagram
from modal.continuation.path import Settings
from modal.continuation.starts import equilibria, orbits
from modal.linear.mode_basis import still_air_modes
from modal.motions.branches import _mesh_doubts, _remarks
from modal.motions.full_model import full_scene, run_from
from modal.motions.span_model import SpanModel
from modal.motions.span_problem import NumberFamily, SpanProblem, WindFamily
from modal.motions.table import branch_table
from modal.plots.branch_figure import branch_figure


@pytest.fixture(scope="module")
def scene():
    return gf.load_scene("example3").with_values({"numerics.elements": 8, "wind.speed": 5.2})


@pytest.fixture(scope="module")
def found(scene):
    return modal.branches(scene, "wind.speed", 4.5, 5.3, simulate=1)


def test_branches_have_their_names_and_events(found, scene):
    assert found.plot().axes
    data = found.dataset
    assert data["name"].values.tolist() == [
        "rest",
        "one loop",
        "two loops",
        "one loop with swing at half frequency",
    ]
    onsets = modal.critical_wind_speed(scene, count=3)
    galloping = sorted(one.wind_speed for one in onsets if one.mode.family == "vertical")
    hopf = data.event_value.values[data.event_kind.values == "Hopf"]
    assert hopf[:2] == pytest.approx(galloping[:2], rel=1e-4)  # observed 2e-6
    swing = data.event_value.values[data.event_kind.values == "period doubling"]
    # harmonic balance in another reduced model; observed 3e-4
    assert swing == pytest.approx([modal.screen(scene).onset_wind_speed], rel=1e-3)
    assert not found.remarks


def test_stable_motions_are_those_of_the_full_model(found):
    """Runs that start beside stable motions return to them, others leave unstable ones."""
    data = found.dataset
    assert np.nanmax(data.reduction_error.values) < 3e-3
    returned = left = 0
    for k in range(data.sizes["run"]):
        run = data.isel(run=k)
        number = run.run_branch.item()
        if data.kind.values[number] != "orbit":
            continue
        of_branch = data.isel(point=data.branch_of_point.values == number)
        nearest = int(np.argmin(np.abs(of_branch.value.values - run.run_value.item())))
        motion = of_branch.isel(point=nearest)
        if run.run_start_is_stable.item():
            returned += 1
            assert run.run_outcome == "periodic"
            # observed 1e-3 and 9e-3
            assert run.run_u2_high.item() == pytest.approx(motion.u2_amplitude.item(), rel=0.005)
            assert run.run_u3_high.item() == pytest.approx(motion.u3_amplitude.item(), rel=0.02)
        elif motion.growth.item() > 1.02:
            left += 1
            assert abs(run.run_u2_high.item() - motion.u2_amplitude.item()) > 0.01
    assert returned == 2
    assert left


def test_beating_beyond_the_torus_is_found():
    """Example 3 in 6.5 m/s: 0.696 / 0.289 m, and 0.47 m at the quarter points (a prototype)."""
    scene = gf.load_scene("example3")
    model = SpanModel(scene, still_air_modes(scene))
    state = np.zeros(2 * model.size)
    for family, symmetric, amplitude in (("vertical", True, 0.5), ("vertical", False, 0.4)):
        number = next(
            i
            for i, known in enumerate(model.family)
            if known == family and model.is_symmetric[i] == symmetric
        )
        state[number] = amplitude / np.max(np.abs(model.shapes[number, :, 1]))
    state[model.horizontal] = 0.2 / model.middle[model.horizontal, 2]
    end, _, _ = run_from(full_scene(scene, "wind.speed", 6.5, model), model, state, 400)
    assert end.outcome == "beating"
    assert end.u2.whole == pytest.approx(0.696, rel=0.01)  # observed 0.698
    assert end.u3.whole == pytest.approx(0.289, rel=0.02)  # observed 0.285
    assert end.quarter.whole == pytest.approx(0.47, rel=0.02)  # observed 0.474


def test_a_beat_that_a_finer_mesh_does_not_have_is_not_confirmed(found):
    """In remarks and in the table of events; a period doubling takes the place of a torus."""
    branch = found.diagram.branches[1]
    (doubling,) = branch.of_kind("period doubling")
    torus = replace(doubling, kind="torus", value=1.0j)
    diagram = Diagram([replace(branch, events=[torus])], [], [])
    settings, problem = Settings(4.5, 5.3), doubling.point.equations.problem
    assert not _mesh_doubts(found.diagram, settings)
    doubts = _mesh_doubts(diagram, settings)
    (remark,) = _remarks(diagram, ["one loop"], problem.model, "m/s", doubts)
    assert "begins to beat" in remark
    assert "this is not confirmed, because the multiplier" in remark
    table = branch_table(problem, diagram, ["one loop"], [0.0], [], "", "m/s", doubts)
    assert table.event_meaning.values[0].endswith("second frequency (not confirmed)")


def test_tables_and_figure(found, tmp_path):
    for name in ("branches.nc", "branches.csv"):
        found.save(tmp_path / name)
    read = xr.load_dataset(tmp_path / "branches.nc", engine="h5netcdf")
    xr.testing.assert_identical(read.value, found.dataset.value)
    assert read.value.attrs["units"] == "m/s"
    header, first, *_ = (tmp_path / "branches.csv").read_text().splitlines()
    assert header.startswith("branch_of_point,name,value [m/s],period [s],u2_amplitude [m]")
    assert first.startswith("0,rest,4.5,")
    with pytest.raises(gf.SceneError, match="suffix"):
        found.save(tmp_path / "branches.txt")
    figure = branch_figure(found.dataset)
    figure.canvas.draw()
    styles = {line.get_linestyle() for line in figure.axes[0].lines}
    assert {"-", "--"} <= styles
    assert "two loops" in repr(found)


def test_the_command(scene, tmp_path):
    files = [tmp_path / name for name in ("a.png", "a.nc")]
    arguments = ["branches", "example3", "--set", "numerics.elements=6"]
    arguments += ["--over", "wind.speed", "4.5", "4.7"]
    for path in files:
        arguments += ["-o", str(path)]
    done = CliRunner().invoke(app, [*arguments, "--json"])
    assert done.exit_code == 0, done.output
    content = json.loads(done.stdout)
    assert content["name"] == ["rest", "one loop"]
    assert all(path.stat().st_size for path in files)
    done = CliRunner().invoke(app, arguments[:-4])
    assert "an oscillation begins" in done.stdout


def test_onset_over_the_attack_angle_is_that_over_the_wind(scene):
    """The onset at 170 deg, where it changes with the angle, is found again over the angle."""
    oblique = scene.with_values({"ice.attack_angle_deg": 170.0})
    model = SpanModel(oblique, still_air_modes(oblique))
    problem = SpanProblem(WindFamily(model), model, 4.6)
    rest = equilibria(problem, np.zeros(problem.size), 4.5, Settings(4.4, 5.2, max_step=0.5))
    (hopf,) = rest.of_kind("Hopf")[:1]
    windy = oblique.with_values({"wind.speed": hopf.parameter})
    family = NumberFamily(windy, "ice.attack_angle_deg", model, 1e-3)
    problem = SpanProblem(family, model, hopf.parameter)
    state = hopf.point.states[0]
    rest = equilibria(problem, state, 169.0, Settings(168.5, 171.0, max_step=0.5))
    found = [event.parameter for event in rest.of_kind("Hopf")]
    assert found == pytest.approx([170.0], abs=1e-5)


def test_onset_of_the_swing_over_damping_is_that_over_the_wind(scene, found):
    """In the wind of the onset, the swing begins at the present damping."""
    (doubling,) = found.diagram.branches[1].of_kind("period doubling")
    point = doubling.point
    windy = scene.with_values({"wind.speed": doubling.parameter})
    model = point.equations.problem.model
    family = NumberFamily(windy, "damping.translation", model, 1e-4)
    problem = SpanProblem(family, model, doubling.parameter)
    settings = Settings(0.995, 1.005, tolerance=1e-3, max_step=2.0, first_step=0.5)
    states = point.at(np.arange(80) / 80)
    over = orbits(problem, states, point.period, 0.998, settings)
    (again,) = over.of_kind("period doubling")
    assert again.parameter == pytest.approx(1.0, abs=2e-6)
    less, more = (one.is_stable for one in (over.points[0], over.points[-1]))
    assert (less, more) == (False, True)  # more damping: no swing


@pytest.mark.parametrize(
    ("changes", "options", "message"),
    [
        ({"aerodynamics": None, "wind": {}}, {}, "aerodynamics is not given"),
        ({}, {"start": 5.0, "stop": 4.0}, "must be below"),
        ({}, {"over": "wind.air_density"}, "range of wind.air_density is not given"),
        ({"wind.speed": 0.0}, {}, "range of wind.speed is not given"),
        ({"wind.direction_deg": 10.0}, {}, "uniform wind towards"),
    ],
)
def test_what_cannot_be_done_is_refused(scene, changes, options, message):
    with pytest.raises(gf.SceneError, match=message):
        modal.branches(scene.with_values(changes), **options)


def test_rotated_equilibria_are_found_and_stable_where_the_energy_has_a_minimum():
    """A soft span in a moment sin(alpha): equilibria near 0, and rotated away by the wind."""
    angle = np.arange(0.0, 361.0, 15.0)
    turn = np.sin(np.radians(angle))
    turn[-1] = 0.0
    scene = gf.load_scene("example3").with_values(
        {
            "span.length": 400.0,
            "span.sag": None,
            "numerics.elements": 8,
            "ice.attack_angle_deg": 0.0,
            "ice.first_moment_x2": 0.0,
            "ice.first_moment_x3": 0.0,
            "aerodynamics": {
                "kind": "table",
                "angle_deg": angle.tolist(),
                "lift": [0.0] * len(angle),
                "drag": [1.0] * len(angle),
                "moment": turn.tolist(),
            },
        }
    )
    found = modal.branches(scene, "wind.speed", 10.0, 14.0)
    data = found.dataset
    static = [k for k, kind in enumerate(data.kind.values) if kind == "equilibrium"]
    twists = {}
    for k in static:
        at = data.isel(point=np.flatnonzero(data.branch_of_point.values == k))
        twists[data["name"].values[k]] = (float(at.theta_mean.values[-1]), bool(at.is_stable[-1]))
    assert {"rest", "rest, turned over"} <= set(twists)
    assert twists["rest"] == (pytest.approx(0.0, abs=1e-6), False)  # divergence
    turned, stable = twists["rest, turned over"]
    assert stable
    assert np.pi / 2 < abs(turned) < np.pi
