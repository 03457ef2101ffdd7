"""Risk atlas: distributions, statistics, files, lines, bad input."""

import json
from functools import partial

import numpy as np
import pytest
from distributed import LocalCluster
from scipy import stats

import gallop_fmu as gf
import modal
from modal.cli.main import app
from modal.plots import risk_figure
from modal.risk.draws import REPEATS, draw
from modal.risk.outcomes import found_by_simulation
from modal.risk.quantities import quantities
from modal.risk.statistics import convergence, probability, quantile, sobol_shares
from modal.risk.winter_file import read_winter
from modal.screening.many_spans import EstimateTask
from tests.support.cubic_galloping import scene
from tests.support.sweeps import same

UNIFORM = {"distribution": "uniform", "loc": 2.0, "scale": 6.0}


@pytest.mark.parametrize("sampling", ["sobol", "latin_hypercube"])
def test_intervals_contain_the_probability(sampling):
    """Of 95 % intervals 92 to 100 % do, over 200 seeds; those of repeats are exact on average."""
    share, inside, width = 0.27, 0, []
    for seed in range(200):
        drawn = draw(2, 256, seed, sampling)
        event = (drawn.points[:, 0] * (0.5 + 0.5 * drawn.points[:, 1]) < share).astype(float)
        found = probability(event, drawn)
        inside += found.lowest <= 2.0 * np.log(2.0) * share <= found.highest
        width.append(found.highest - found.lowest)
    assert 0.92 * 200 <= inside
    plain = 2.0 * 1.96 * np.sqrt(0.374 * 0.626 / 256)
    assert np.mean(width) < 0.8 * plain  # fewer draws than independent ones


def test_intervals_of_one_quantity_contain_the_probability():
    """Repeats of 32 strata often have the same number of events; 97 % of intervals are right."""
    shares = np.random.default_rng(0).uniform(0.05, 0.95, 400)
    inside = 0
    for seed, share in enumerate(shares):
        drawn = draw(1, 256, seed)
        found = probability((drawn.points[:, 0] < share).astype(float), drawn)
        inside += found.lowest <= share <= found.highest
    assert 0.93 * len(shares) <= inside
    assert found.highest - found.lowest < 0.03


def test_an_interval_of_no_event_is_that_of_a_binomial_variable():
    drawn = draw(1, 256, 0)
    found = probability(np.zeros(256), drawn)
    assert found.value == found.lowest == 0.0
    assert found.highest == pytest.approx(3.0 / 256, rel=0.01)  # the rule of three


def test_unresolved_draws_widen_the_interval():
    drawn = draw(1, 256, 0)
    event = (drawn.points[:, 0] < 0.25).astype(float)
    whole = probability(event, drawn)
    event[::16] = np.nan
    found = probability(event, drawn)
    assert found.value == pytest.approx(whole.value, abs=0.02)
    assert found.lowest < whole.value - 0.01
    assert found.highest > whole.value + 0.03
    assert probability(np.full(256, np.nan), drawn).highest == 1.0


def test_quantiles_and_too_few_draws():
    drawn = draw(1, 4096, 1)
    values = stats.expon.ppf(drawn.points[:, 0])
    found = quantile(values, 0.99, drawn)
    assert found.value == pytest.approx(stats.expon.ppf(0.99), rel=0.01)
    assert found.lowest < stats.expon.ppf(0.99) < found.highest
    assert np.isnan(quantile(values, 0.999, drawn).value)  # 4 draws beyond
    values[np.argsort(values)[-60:]] = np.inf
    assert quantile(values, 0.99, drawn).value == np.inf


def test_shares_are_those_of_the_ishigami_function():
    """Sobol and Levitan 1999: first 0.3139, 0.4424, 0, total 0.5576, 0.4424, 0.2437."""
    drawn = draw(3, 4096, 3, shares=True)
    x = np.pi * (2.0 * drawn.points - 1.0)
    values = np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])
    first, total = sobol_shares(values, drawn)
    for found, true in zip(first + total, (0.3139, 0.4424, 0, 0.5576, 0.4424, 0.2437), strict=True):
        assert found.lowest <= true <= found.highest
        assert found.value == pytest.approx(true, abs=0.03)
    values[:200] = np.nan
    assert sobol_shares(values, drawn) is None
    assert sobol_shares(np.zeros(len(values)), drawn) is None


def test_draws_are_uniform_and_repeatable():
    first, again = draw(2, 64, 5, shares=True), draw(2, 64, 5, shares=True)
    assert np.array_equal(first.points, again.points)
    assert not np.array_equal(first.points, draw(2, 64, 6, shares=True).points)
    names = np.array(first.matrix)
    assert sorted(set(first.matrix)) == ["A", "A1", "A2", "B"]
    for repeat in range(REPEATS):
        of = {n: first.points[(first.repeat == repeat) & (names == n)] for n in set(first.matrix)}
        assert np.array_equal(of["A1"][:, 0], of["B"][:, 0])
        assert np.array_equal(of["A1"][:, 1], of["A"][:, 1])
        strata = np.sort(np.floor(4 * of["A"][:, 0]))
        assert strata.tolist() == [0.0, 1.0, 2.0, 3.0]


def test_convergence_ends_with_all_draws():
    drawn = draw(1, 128, 0, shares=True)
    event = (drawn.points[:, 0] < 0.4).astype(float)
    series = convergence(event, drawn)
    assert list(series) == [16, 32, 64]
    event_of_a = np.mean(event[np.array(drawn.matrix) == "A"])
    assert series[64].value == event_of_a  # the matrix B stands behind A


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({}, "no random quantity"),
        ({"wind.speed": 3.0}, r"wind\.speed = 3\.0: must be a frozen continuous distribution"),
        ({"wind.speed": stats.poisson(2.0)}, "must be a frozen continuous distribution"),
        ({"wind.speed": {"distribution": "weibul"}}, "did you mean dweibull"),
        ({"wind.speed": {"c": 2.0}}, "distribution = 'None'"),
        ({"wind.speed": {"distribution": "weibull_min"}}, "weibull_min needs c"),
        ({"wind.speed": {**UNIFORM, "width": 2.0}}, "uniform has the parameters loc, scale"),
        ({"wind.speed": {**UNIFORM, "loc": "2"}}, "must be a number"),
        ({"wind.speed": {**UNIFORM, "loc": np.inf}}, "must be finite"),
        ({"wind.speed": {**UNIFORM, "scale": -1.0}}, "is not a distribution"),
    ],
)
def test_wrong_distributions_are_refused(given, words):
    with pytest.raises(gf.SceneError, match=words):
        quantities(given)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"draws": 100}, "draws = 100: must be a power of two, at least 32"),
        ({"draws": 32, "shares": True}, "at least 64"),
        ({"sampling": "halton"}, "sampling = 'halton'"),
        ({"method": "guess"}, "method = 'guess'"),
        ({"events_per_winter": 0.0}, "events_per_winter"),
        ({"clearance": -1.0}, r"clearance = -1\.0"),
        (
            {"table": [{"name": "a", "label.clearance": "far"}]},
            r"span a: label\.clearance = far: must be a positive number",
        ),
        (
            {"table": [{"name": "a", "wind.speed": 3.0}]},
            r"wind\.speed: given in the table and as random",
        ),
    ],
)
def test_wrong_arguments_are_refused(options, words):
    with pytest.raises(gf.SceneError, match=words):
        modal.risk_atlas("example3", {"wind.speed": UNIFORM}, **options)


def test_the_file_of_a_winter(tmp_path):
    path = tmp_path / "winter.toml"
    path.write_text(
        "events_per_winter = 2\n[random.wind]\n"
        'speed = {distribution = "uniform", loc = 2.0, scale = 6.0}\n'
    )
    winter = read_winter(path)
    assert winter == ({"wind.speed": UNIFORM}, 2.0)
    for text, words in (
        ("rate = 2\n", "rate: the file has events_per_winter"),
        ("events_per_winter = '2'\n", "must be a number"),
        ("[random]\nwind = 3\n", "must be a distribution such as"),
        ("random = 3\n", "must be a table"),
    ):
        path.write_text(text)
        with pytest.raises(gf.SceneError, match=words):
            read_winter(path)


LINE = """\
title = "two spans"

[section]
horizontal_tension = 60e3
spans = [{length = 100.0}, {length = 125.0}]
suspensions = [{kind = "string", length = 2.0, weight = 500.0}]

[conductor]
diameter = 0.0235
mass_per_length = 1.66
axial_stiffness = 2.5e6
torsional_stiffness = 1e5
torsional_inertia = 1.56e-4

[wind]
speed = 5.0

[aerodynamics]
kind = "polynomial"
valid_from_deg = -90.0
valid_to_deg = 90.0
lift = [0.0, -2.0, 0.0, 6.0]
drag = [1.0]
moment = [0.0]

[damping.translation]
low_ratio = 0.004
low_frequency = 0.5
high_ratio = 0.004
high_frequency = 1.0

[numerics]
elements = 4
time_step = 0.05
"""


def test_spans_of_a_line_by_simulation(tmp_path):
    (tmp_path / "line.toml").write_text(LINE)
    wind = {"wind.speed": {"distribution": "uniform", "loc": 1.0, "scale": 1.0}}
    found = modal.risk_atlas(
        tmp_path / "line.toml", wind, draws=32, method="simulate", stop_time=45.0, workers=1
    )
    data = found.dataset
    assert data.span.values.tolist() == ["span 1", "span 2"]
    assert data.galloping.values.tolist() == [0.0, 0.0]  # all below the critical wind
    assert np.all(data.galloping_highest > 0.05)
    assert np.isnan(data.clash.values).all()
    assert data.clash_highest.values.tolist() == [1.0, 1.0]


def test_simulated_motions_are_sorted():
    import xarray as xr

    motions = ["steady", "at rest", "still growing (vertical +3 %/min)", "turned over at 3 s", ""]
    rows = xr.Dataset(
        {
            "motion": ("run", np.array(motions, dtype=object)),
            "outcome": ("run", np.array([*["completed"] * 4, "invalid_scene"], dtype=object)),
            "message": ("run", np.array(["", "", "", "", "too long"], dtype=object)),
            "u2_amplitude": ("run", [1.2, 0.0, 0.4, 0.3, np.nan]),
            "u3_amplitude": ("run", [0.4, 0.0, 0.0, 0.0, np.nan]),
            "u2_frequency_hz": ("run", [0.5, np.nan, 0.5, 0.5, np.nan]),
            "u3_frequency_hz": ("run", [0.25, np.nan, 0.5, 0.5, np.nan]),
        }
    )
    found = found_by_simulation(rows)
    np.testing.assert_equal(found.gallops, [1.0, 0.0, 1.0, np.nan, np.nan])
    np.testing.assert_equal(found.amplitude, [1.2, 0.0, np.nan, np.nan, np.nan])
    np.testing.assert_equal(found.swings, [1.0, 0.0, np.nan, np.nan, np.nan])
    assert found.reasons == {
        "motion still growing": 1,
        "motion turned over at 3 s": 1,
        "too long": 1,
    }


def test_the_command_prints_writes_draws_and_resumes(invoke, tmp_path):
    run = partial(invoke, app=app)
    scene().save(tmp_path / "span.toml")
    (tmp_path / "winter.toml").write_text(
        'events_per_winter = 2.0\n[random.wind]\nspeed = {distribution = "uniform", scale = 8.0}\n'
    )
    places = [
        {
            "type": "Feature",
            "id": name,
            "geometry": {"type": "Point", "coordinates": [10.0, number]},
            "properties": {"span.length": 120.0 + number, "label.clearance": "2.5"},
        }
        for number, name in enumerate(("A", "B"))
    ]
    (tmp_path / "spans.geojson").write_text(
        json.dumps({"type": "FeatureCollection", "features": places})
    )
    words = ["atlas", "span.toml", "--random", "winter.toml", "--table", "spans.geojson"]
    words += ["--draws", "32", "--workers", "1", "-o", "runs.nc"]
    first = run(*words, "--summary", "risk.geojson", "--plot", "risk.png")
    assert first.exit_code == 0, first.output
    assert "[% of winters]" in first.stdout
    assert (tmp_path / "risk.png").read_bytes()[:4] == b"\x89PNG"
    features = json.loads((tmp_path / "risk.geojson").read_text())["features"]
    assert [each["geometry"]["coordinates"] for each in features] == [[10.0, 0], [10.0, 1]]
    assert 0.3 < features[0]["properties"]["galloping"] < 0.8
    again = run(*words, "--json", "--summary", "risk.csv")  # takes all runs over
    spans = json.loads(again.stdout)["spans"]
    assert spans[0]["galloping"] == features[0]["properties"]["galloping"]
    assert (tmp_path / "risk.csv").read_text().startswith("span,galloping,")


def test_shares_in_the_figure(tmp_path):
    random = {"wind.speed": UNIFORM, "wind.air_density": stats.norm(1.29, 0.02)}
    found = modal.risk_atlas(scene(), random, draws=64, shares=True, workers=1)
    share = found.dataset.first_share.isel(span=0)
    assert share.sel(quantity="wind.speed") > 0.8 > 0.1 > share.sel(quantity="wind.air_density")
    assert len(risk_figure(found).subfigs[1].axes) == 3
    assert len(found.plot().subfigs[1].axes) == 3
    assert "independent of each other" in found.remarks[1]


@pytest.mark.parametrize("method", ["estimate", "simulate"])
def test_rows_are_the_same_on_threads_processes_and_a_cluster(method):
    """Modes that one group of draws shares, and where it is computed, do not change a bit."""
    wind = {"wind.speed": {"distribution": "uniform", "loc": 0.5, "scale": 6.0}}
    atlas = partial(modal.risk_atlas, scene(), wind, draws=32, method=method, stop_time=4.0, seed=3)
    one = atlas(workers=1)
    with LocalCluster(
        n_workers=1, threads_per_worker=2, processes=False, protocol="tcp", dashboard_address=None
    ) as dask:
        others = [atlas(workers=2), atlas(cluster=dask.scheduler_address)]
    for other in others:
        assert same(other.runs, one.runs)
        assert other.dataset.identical(one.dataset)
    if method == "estimate":
        for run in range(0, 32, 11):
            row = one.runs.dataset.isel(run=run)
            alone = modal.two_mode_estimate(scene(speed=row["wind.speed"].item()))
            assert row.estimated_vertical.fillna(0.0).item() == alone.vertical_amplitude


def test_modes_are_reused_at_other_wind_speeds_only():
    """In a group, each scene has the row that it has alone; each differs in one value from base."""
    base = gf.load_scene("example3")
    changes = (
        {"wind.speed": 5.2},
        {"wind.air_density": 1.1},
        {"ice.attack_angle_deg": 178.0},
        {"span.sag": 2.2},
        {"aerodynamics.lift": [0.0, -4.0, 0.0, 3.0]},
        {"wind.profile": {"kind": "power", "attachment_height": 20.0, "exponent": 0.2}},
    )
    group = [scene for change in changes for scene in (base, base.with_values(change))]
    task = EstimateTask(None)
    rows = task(group, lambda: True)
    alone = [task([each], lambda: True)[0] for each in group]
    for row in (*rows, *alone):
        row.pop("seconds")
        assert row["outcome"] == "completed", row["message"]
    assert rows == alone
    assert len({row["estimated_vertical"] for row in rows}) == len(changes) + 1
