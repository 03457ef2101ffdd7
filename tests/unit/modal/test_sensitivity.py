"""Sensitivity of a span: events and motions against scenes that are computed again."""

import json
import re

import numpy as np
import pytest
from scipy.optimize import brentq
from typer.testing import CliRunner

import gallop_fmu as gf
import modal
from modal.cli.main import app
from modal.continuation.equations import OrbitEquations
from modal.continuation.path import Settings, Stepper
from modal.foundation.scene_variation import number_of, varied
from modal.motions.motion_models import similar_model
from modal.motions.span_problem import SpanProblem, WindFamily
from support.galloping_lines import section_of_example2

NUMBERS = ("span.horizontal_tension", "damping.translation", "ice.attack_angle_deg")
STEP = {"ice.attack_angle_deg": 0.2}


@pytest.fixture(scope="module")
def found():
    scene = gf.load_scene("example3").with_values({"numerics.elements": 8, "wind.speed": 5.1})
    return modal.branches(scene, "wind.speed", 4.5, 5.15)


@pytest.fixture(scope="module")
def table(found):
    return modal.sensitivity(found, [*NUMBERS, "ice.mass_per_length", "span.length"])


def sides(scene, path):
    """Scenes with a number less and greater, and the step."""
    value = number_of(scene, path)
    step = STEP.get(path, 2e-3 * abs(value))
    return [varied(scene, path, value + sign * step) for sign in (-1.0, 1.0)], step


def solved(scene, point, wind):
    """Orbit near a point, of another scene in another wind, with the weights of u2 at mid-span."""
    base = point.equations.problem.model
    model = similar_model(scene, base)
    problem = SpanProblem(WindFamily(model), base, wind)
    old = point.equations
    equations = OrbitEquations(problem, old.parameter_scale, old.period_scale, old.mesh)
    guess, hold = point.x.copy(), np.zeros_like(point.x)
    guess[-1], hold[-1] = wind, old.parameter_scale
    return Stepper(Settings(0.0, 1.0)).correct(equations, guess, guess, hold, 0.0), model


@pytest.mark.parametrize("path", NUMBERS)
def test_onset_of_galloping_is_that_of_the_full_model(table, found, path):
    (low, high), step = sides(found.scene, path)
    winds = [
        min(one.wind_speed or np.inf for one in modal.critical_wind_speed(scene, count=3))
        for scene in (low, high)
    ]
    derivative = table.dataset.derivative.isel(quantity=0).sel(number=path).item()
    # observed 4e-4 for the angle, 1e-5 for the others: twelve modes are not all
    assert derivative == pytest.approx((winds[1] - winds[0]) / (2.0 * step), rel=2e-3)


@pytest.mark.parametrize("path", NUMBERS[:2])
def test_onset_of_the_swing_is_that_of_orbits_found_again(table, found, path):
    name = "period doubling of branch 1 (one loop), begin of one loop with swing at half frequency"
    one = table.dataset.sel(quantity=name, number=path)
    (doubling,) = found.diagram.branches[1].of_kind("period doubling")
    both, step = sides(found.scene, path)

    def onset(scene):
        def growth(wind):  # of the multiplier that passes -1
            return float(solved(scene, doubling.point, wind)[0].levels[0])

        return brentq(growth, 4.99, 5.09, xtol=1e-7)

    difference = (onset(both[1]) - onset(both[0])) / (2.0 * step)
    assert one.derivative.item() == pytest.approx(difference, rel=1e-3)  # observed 6e-5


@pytest.mark.parametrize("path", ["span.length", "damping.translation"])
def test_amplitude_frequency_and_growth_are_those_of_orbits_found_again(table, found, path):
    data = table.dataset
    number = data["motion"].values.tolist().index("one loop with swing at half frequency")
    branch = data.branch.values[number]
    near = min(found.diagram.branches[branch].points, key=lambda point: abs(point.parameter - 5.1))
    both, step = sides(found.scene, path)
    values = []
    for scene in both:
        point, model = solved(scene, near, 5.1)
        weights = model.watched_at(np.eye(model.size)).u2[:, 0]
        move = point.at(np.arange(4096) / 4096)[:, : model.size] @ weights
        values.append((0.5 * np.ptp(move), 1.0 / point.period, point.levels[0] / point.period))
    differences = (np.array(values[1]) - values[0]) / (2.0 * step)
    name = "branch 3 (one loop with swing at half frequency)"
    for what, difference in zip(
        ("vertical amplitude", "frequency", "growth rate"), differences, strict=True
    ):
        one = data.sel(quantity=f"{what} of {name}", number=path)
        assert one.derivative.item() == pytest.approx(difference, rel=5e-3), what


def test_table_has_units_and_small_errors(table, tmp_path):
    data = table.dataset
    assert np.max(data.error.values) < 1e-3
    assert data.relative.sel(number="ice.attack_angle_deg").isnull().all()
    assert data["number_unit"].values.tolist() == ["N", "1", "deg", "kg/m", "m"]
    # 1 % more damping: onset at 1 % more wind, less than that of the mean twist
    assert data.relative.isel(quantity=0).sel(number="damping.translation") == pytest.approx(
        1.07, abs=0.01
    )
    assert "Hopf of branch 0 (rest), begin of one loop = 4.587 m/s" in repr(table)
    assert not table.remarks
    for name in ("a.nc", "a.csv"):
        assert table.save(tmp_path / name).stat().st_size
    header, *rows = (tmp_path / "a.csv").read_text().splitlines()
    assert header.startswith("quantity,number,derivative,relative,error,value,unit")
    assert len(rows) == data.sizes["quantity"] * data.sizes["number"]
    with pytest.raises(gf.SceneError, match="suffix"):
        table.save(tmp_path / "a.txt")


LINE_NUMBERS = ("section.horizontal_tension", "section.suspensions.0.length", "damping.translation")


@pytest.fixture(scope="module")
def line():
    """Two unequal spans on a string, which gallop from 2.37 m/s."""
    data = section_of_example2(2, elements=6).model_dump(mode="json", exclude_none=True)
    data["section"]["spans"][1]["length"] = 112.0
    damping = dict.fromkeys(
        ("damping.translation.low_ratio", "damping.translation.high_ratio"), 4e-3
    )
    scene = gf.LineScene.from_dict(data).with_values({**damping, "wind.speed": 2.55})
    return modal.branches(scene, "wind.speed", 2.3, 2.6)


def test_a_line_is_differentiated_as_a_span_is(line):
    """By numbers of its strung state, and factors; amplitudes are those of the largest span."""
    found = modal.sensitivity(line, LINE_NUMBERS)
    data = found.dataset
    assert not found.remarks
    name = next(name for name in data["quantity"].values if name.startswith("vertical amplitude"))
    (place,) = [int(word) for word in re.findall(r"in span (\d)", name.split(" of ")[0])]
    branch = int(data.branch.sel(quantity=name))
    near = min(line.diagram.branches[branch].points, key=lambda point: abs(point.parameter - 2.55))
    for path in LINE_NUMBERS:
        both, step = sides(line.scene, path)
        onsets, values = [], []
        for scene in both:
            onsets.append(
                min(one.wind_speed or np.inf for one in modal.critical_wind_speed(scene, count=4))
            )
            point, model = solved(scene, near, 2.55)
            watched = model.watched_at(point.at(np.arange(4096) / 4096)[:, : model.size])
            values.append((0.5 * np.ptp(watched.u2, axis=0)[place - 1], 1.0 / point.period))
        one = data.sel(number=path)
        onset = one.derivative.values[np.argmin(np.where(data.unit == "m/s", data.value, np.inf))]
        change = (onsets[1] - onsets[0]) / (2.0 * step)
        small = 1e-3 * onsets[0] / number_of(line.scene, path)
        assert onset == pytest.approx(change, rel=2e-3, abs=small), path
        for what, change in zip(
            (name, name.replace(name.split(" of ")[0], "frequency")),
            (np.array(values[1]) - values[0]) / (2.0 * step),
            strict=True,
        ):
            derivative = one.derivative.sel(quantity=what).item()
            assert derivative == pytest.approx(change, rel=5e-3), (path, what)


def test_what_cannot_be_differentiated_is_refused(found):
    for numbers, message in (
        (["span.width"], "span.width"),
        (["wind.speed"], "the branches are over this number"),
        (["supports.stiffness_x1"], "supports.left.stiffness_x1"),
        ([], "numbers is empty"),
    ):
        with pytest.raises(gf.SceneError, match=message):
            modal.sensitivity(found, numbers)
    with pytest.raises(gf.SceneError, match="start and stop belong to the branches"):
        modal.sensitivity(found, start=4.0)


def test_the_command(tmp_path):
    words = ["sensitivity", "example3", "--set", "numerics.elements=6"]
    words += ["--start", "4.5", "--stop", "4.65"]
    words += ["--numbers", "damping.translation", "--numbers", "ice.attack_angle_deg"]
    done = CliRunner().invoke(app, [*words, "-o", str(tmp_path / "a.csv"), "--json"])
    assert done.exit_code == 0, done.output
    content = json.loads(done.stdout)
    assert content["number"] == ["damping.translation", "ice.attack_angle_deg"]
    assert (tmp_path / "a.csv").exists()
    done = CliRunner().invoke(app, words)
    assert "begin of one loop" in done.stdout
    assert "damping.translation" in done.stdout
