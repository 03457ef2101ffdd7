"""Mode superposition of lines: against the kernel's loads, one span, linear theory, simulation."""

import json
import math
from dataclasses import replace

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from gallop_fmu.engine.mesh import Mesh
from modal.linear.eigensolution import nearest_to_zero
from modal.plots import comparison_figure
from modal.superposition.modal_model import ModalModel, mean_wind
from modal.superposition.mode_superposition import linear_motion, nonlinear_motion
from support.line_references import line_scene, stored
from support.line_runs import relative_rms, strongest_frequency

PULSE = {"kind": "pulse", "peak": 1.0, "rise": 1.0, "fall_start": 1.5, "fall": 0.5}
CURVE = {
    "kind": "polynomial",
    "valid_from_deg": -60,
    "valid_to_deg": 80,
    "lift": [0.1, -1.5, 0.3],
    "drag": [1.0, 0.2],
    "moment": [0.05, 0.3],
}
SPOILER = {
    "kind": "polynomial",
    "valid_from_deg": -40,
    "valid_to_deg": 40,
    "lift": [0.0, 0.7],
    "drag": [0.8],
    "moment": [0.0],
}


def uneven_line(**changes):
    """Three spans of a twin bundle with their own ice and wind, and each kind of what holds it."""
    scene = gf.LineScene.from_dict(
        {
            "title": "uneven",
            "section": {
                "horizontal_tension": 22000.0,
                "spans": [
                    {"length": 120.0},
                    {
                        "length": 150.0,
                        "height_difference": 8.0,
                        "ice": {
                            "mass_per_length": 0.4,
                            "attack_angle_deg": 25.0,
                            "first_moment_x2": 1e-4,
                        },
                        "wind": {"speed": 9.0},
                    },
                    {"length": 100.0, "elements": 5},
                ],
                "suspensions": [
                    {"kind": "string", "length": 2.1, "weight": 490.0},
                    {"kind": "post"},
                ],
            },
            "bundle": {"subconductors": 2, "spacing": 0.4, "spacers": 2},
            "conductor": {
                "diameter": 0.0281,
                "mass_per_length": 1.53,
                "axial_stiffness": 13.3e6,
                "torsional_stiffness": 100.0,
                "torsional_inertia": 2e-4,
            },
            "ice": {
                "mass_per_length": 0.5,
                "attack_angle_deg": 10.0,
                "first_moment_x2": 2e-4,
                "first_moment_x3": 1e-4,
            },
            "aerodynamics": CURVE,
            "wind": {"speed": 6.0},
            "devices": [
                {
                    "kind": "interval",
                    "span": 1,
                    "from_station": 0.25,
                    "to_station": 0.75,
                    "ice": "none",
                    "aerodynamics": SPOILER,
                },
                {"kind": "pendulum", "span": 2, "station": 0.5, "mass": 20.0, "arm": 0.5},
                {"kind": "damper", "span": 3, "station": 0.3, "damping": 20.0},
            ],
            "numerics": {"elements": 6, "time_step": 0.02},
            "run": {"record_every": 1},
        }
    )
    return scene.with_values(changes)


def some_modes(scene, vertical=2, horizontal=2, torsional=1):
    return ModalModel.of(scene, vertical=vertical, horizontal=horizontal, torsional=torsional)


def three_spans(elements=10, **changes):
    """The galloping section of three spans on strings."""
    case = stored("section_galloping_example2_3_spans")
    scene = line_scene(case, numerics={"elements": elements, "time_step": 0.02})
    return scene.with_values(changes)


def test_the_wind_load_is_that_of_the_simulation():
    """Curves, attack angles and wind differ by span and interval; twist is included."""
    model = some_modes(uneven_line())
    random, wind = np.random.default_rng(4), np.array([6.0, 9.0, 6.0])
    assert mean_wind(model.scene).tolist() == wind.tolist()
    engine, still = model.mesh.model, model.mesh.still
    assert len(set(engine.section_of_element.tolist())) == 3
    for scale in (0.05, 0.3):
        q, rate = scale * random.standard_normal((2, len(model.modes)))
        u, v = model.shapes @ q, model.shapes @ rate
        by_kernel = engine.residual(u, v, inputs=still)
        by_kernel -= engine.residual(u, v, inputs=replace(still, wind_speed=wind))
        wanted = np.einsum("nim,ni->m", model.shapes, by_kernel)
        found = model.wind_load(np.concatenate([q, rate]), wind).force
        assert np.abs(found - wanted).max() < 2e-13 * np.abs(wanted).max()  # observed 1e-14


def test_the_slopes_are_derivatives_of_the_wind_load():
    model, wind, step = some_modes(uneven_line()), np.array([6.0, 9.0, 6.0]), 1e-6
    count = len(model.modes)
    rest = np.concatenate([model.equilibrium(wind), np.zeros(count)])
    ahead, behind = (
        np.array([model.wind_load(rest + sign * step * e, wind).force for e in np.eye(2 * count)])
        for sign in (1.0, -1.0)
    )
    slopes = np.hstack(model.wind_slopes(rest[:count], wind))
    assert np.abs(slopes.T - (ahead - behind) / (2.0 * step)).max() < 1e-9 * np.abs(slopes).max()


def test_a_line_of_one_span_is_the_span():
    span = gf.load_scene("example3").with_values(
        {
            "span.sag": None,
            "span.horizontal_tension": 15000.0,
            "initial.wind": "mean_wind_equilibrium",
            "run.record_every": 1,
        }
    )
    data = span.model_dump(mode="json")
    section = {"horizontal_tension": 15000.0, "strung_with_ice": True, "suspensions": []}
    section |= {"gravity": span.span.gravity, "spans": [{"length": span.span.length}]}
    shared = ("title", "conductor", "ice", "aerodynamics", "wind", "damping", "initial", "numerics")
    line = gf.LineScene.from_dict({"section": section} | {name: data[name] for name in shared})
    counts = {"vertical": 3, "horizontal": 3, "torsional": 3, "record_every": 1}
    one, other = (modal.mode_superposition(scene, 5.0, **counts) for scene in (span, line))
    assert isinstance(other, gf.LineResult)
    for name in ("u2", "u3", "theta", "v2", "angle_of_attack"):
        wanted, found = one.midspan()[name].values, other.midspan()[name].values
        assert np.abs(found - wanted).max() < 1e-10 * np.ptp(wanted), name  # observed 2e-12


def pulse_errors(scene, full, count):
    """Relative RMS differences of all histories of mid-spans and clamps that move."""
    found = modal.mode_superposition(
        scene, full.report.time, vertical=count, horizontal=count, torsional=0
    )
    assert found.dataset.node.values.tolist() == full.dataset.node.values.tolist()
    pairs = [
        (found.dataset[name].values[:, k], full.dataset[name].values[:, k])
        for name in ("u2", "u3")
        for k in range(full.dataset.sizes["node"])
    ]
    largest = max(np.ptp(wanted) for _, wanted in pairs)
    return max(relative_rms(*pair) for pair in pairs if np.ptp(pair[1]) > 1e-2 * largest)


def test_a_small_pulse_moves_it_as_it_moves_the_simulation():
    """The stored pulse divided by 300: at full size the response is not linear."""
    case = stored("section3_pulse")
    load = case["scene"]["load"]
    placed = {
        "span": load["span"],
        "position": load["station_of_rest_length"],
        "force": [force / 300.0 for force in load["force"]],
        "law": PULSE,
    }
    numerics = {"elements": 20, "time_step": 0.025, "integrator": "gauss6"}
    scene = line_scene(case, loads=[placed], numerics=numerics)
    full = gf.simulate(scene, 10.0)
    few, more, most = (pulse_errors(scene, full, count) for count in (5, 10, 20))
    assert few > 4.0 * more > 12.0 * most  # observed 0.080, 0.0141, 0.0026
    assert most < 3e-3


@pytest.fixture(scope="module")
def small_motion():
    """A line about its equilibrium in the wind; the first symmetric vertical mode is excited."""
    scene = three_spans(**{"initial.wind": "mean_wind_equilibrium"})
    return scene.with_values({"initial.seed_vertical": 1e-5, "initial.seed_horizontal": 0.0})


def growth(result, span):
    """Growth rate [1/s] of u2 at mid-span from 150 s to 250 s, when one mode is left."""
    u2, time = result.midspan(span).u2.values, result.dataset.time.values
    early, late = (np.ptp(u2[(time > end - 20.0) & (time <= end)]) for end in (150.0, 250.0))
    return math.log(late / early) / 100.0


def nearest(values, eigenvalue):
    """The one of the values that is nearest to an eigenvalue [1/s]."""
    return values[np.argmin(np.abs(values - eigenvalue))]


def without_displacement(model, wind):
    """Lowest eigenvalues [1/s] of all unknowns, about the equilibrium without its displacement.

    Mode superposition has the twist in the wind load, and no displacement in the structure.
    """
    hanging = model.shapes @ model.equilibrium(wind)
    hanging[:, :3] = 0.0
    mesh = model.mesh
    blowing = replace(mesh.still, wind_speed=wind.item() if wind.size == 1 else wind)
    matrices = [
        mesh.tangent(hanging, **{part: 1.0}, inputs=blowing)
        for part in ("mass", "damping", "stiffness")
    ]
    free = np.flatnonzero(mesh.free)
    return nearest_to_zero(*(matrix[free][:, free] for matrix in matrices), 40)[0]


def test_small_motion_grows_as_in_linear_theory_and_the_simulation(small_motion):
    """They differ because the wind blows the line aside, which a linear structure ignores."""
    model, wind = some_modes(small_motion, 3, 3, 3), mean_wind(small_motion)
    own = np.linalg.eigvals(model.linear_system(wind)[0])
    middle = [chain.middle for chain in model.mesh.model.map.chains]
    in_wind = modal.natural_modes(small_motion, 12, "mean")
    in_phase = max(in_wind, key=lambda mode: abs(mode.shape[middle, 1].sum())).eigenvalue
    simple = nearest(own, in_phase)
    assert simple.real == pytest.approx(in_phase.real, rel=1.5e-2)  # observed -1.3 %
    assert simple.imag == pytest.approx(in_phase.imag, rel=3e-3)  # observed -0.25 %

    same = nearest(without_displacement(model, wind), in_phase)
    assert simple.real == pytest.approx(same.real, rel=3e-4)
    assert simple.imag == pytest.approx(same.imag, rel=1e-5)

    runs = nonlinear_motion(model, 250.0), gf.simulate(small_motion, 250.0)
    for span in (1, 2, 3):
        by_modes, full = (growth(run, span) for run in runs)
        assert by_modes == pytest.approx(simple.real, rel=5e-4)  # observed 2e-4
        assert full == pytest.approx(in_phase.real, rel=2.5e-3)  # observed 1.8e-3


@pytest.fixture(scope="module")
def twin():
    """The stored twin bundle with spacers, and what a lumped chain found."""
    case = stored("bundle_galloping_twin_horizontal")
    scene = line_scene(case, numerics={"elements": 10, "time_step": 0.02})
    return scene, case["repeated"]["meshes"][-1] if "repeated" in case else case["results"]


def test_small_motion_of_a_bundle_grows_as_in_the_full_model(twin):
    model, wind = some_modes(twin[0], 3, 3, 3), mean_wind(twin[0])
    own, full = np.linalg.eigvals(model.linear_system(wind)[0]), without_displacement(model, wind)
    modes = modal.natural_modes(twin[0], 6, "mean")
    assert "bundle torsion" in [mode.family for mode in modes]
    for mode in modes:
        simple, same = (nearest(values, mode.eigenvalue) for values in (own, full))
        assert abs(simple - same) < 3e-6 * abs(same)  # observed 1e-6


def test_the_plateau_of_a_bundle_needs_the_nonlinear_structure(twin):
    """A single conductor differs by 1 % in the plateau (`literature/test_superposition.py`)."""
    scene, chain = twin
    found = modal.mode_superposition(
        scene, 600.0, vertical=1, horizontal=1, torsional=1, record_every=3
    )
    steady = found.steady(50.0)
    u2, twist = chain["u2_mid_spans"][-1][0], chain["twist_mid_spans"][-1][0]
    assert steady["u2"].amplitude == pytest.approx(0.944 * u2, rel=3e-3)  # 1.388 m, not 1.471 m
    assert steady["section_twist"].amplitude == pytest.approx(1.11 * twist, rel=6e-3)


def test_linear_theory_is_mode_superposition_at_small_amplitude(small_motion):
    model = some_modes(small_motion, 3, 3, 3)
    linear = linear_motion(model, mean_wind(small_motion), 20.0)
    nonlinear = nonlinear_motion(model, 20.0)
    for name in ("u2", "u3", "theta"):
        a, b = (result.midspan(2)[name].values for result in (linear, nonlinear))
        assert np.abs(a - b).max() < 5e-4 * np.ptp(a), name  # observed 6e-6, 3e-5, 3e-4


def test_a_bundle_with_spacers_moves_as_in_the_simulation():
    """A small pulse on one subconductor: bundle torsion and sub-span motion are included."""
    placed = {"span": 1, "subconductor": 1, "position": 0.4, "law": PULSE, "force": [0, 0.5, 1]}
    calm = {"wind.speed": 0.0, "section.spans.1.wind": None, "loads": [placed]}
    scene = uneven_line(**calm, **{"initial.seed_vertical": 0.0, "initial.seed_horizontal": 0.0})
    full = gf.simulate(scene, 5.0)
    found = modal.mode_superposition(scene, 5.0, vertical=6, horizontal=6, torsional=5)
    bounds = {"u2": 1.8e-2, "u3": 2.5e-2, "theta": 9e-3}
    for name, bound in bounds.items():  # observed 1.4e-2, 2.1e-2, 7.0e-3: sub-spans need more modes
        a, b = (result.dataset[name].values for result in (found, full))
        assert relative_rms(a, b) < bound, name


def test_a_step_evaluates_the_wind_once_for_each_cross_section(monkeypatch):
    """The work of a step: three cross-sections here, one where ice and curve are the same."""
    calls = []
    evaluate = Mesh.aero_load
    monkeypatch.setattr(
        Mesh, "aero_load", lambda *given, **more: calls.append(1) or evaluate(*given, **more)
    )
    for scene, sections in ((uneven_line(), 3), (three_spans(), 1)):
        model = some_modes(scene, 1, 1, 1)
        work = []
        for duration in (0.2, 0.4):  # 10 and 20 steps; the rest is for the recorded nodes
            calls.clear()
            nonlinear_motion(model, duration)
            work.append(len(calls))
        assert work[1] - work[0] == 10 * sections


def test_each_span_has_its_own_wind_over_time():
    ramp = {"kind": "ramp", "initial": 2.0, "final": 8.0, "start": 1.0, "duration": 2.0}
    scene = uneven_line(**{"section.spans.1.wind": {"history": ramp}})
    found = modal.mode_superposition(scene, 4.0, vertical=2, horizontal=2, torsional=1)
    full = gf.simulate(scene, 4.0)
    assert found.dataset.wind_speed.dims == ("time", "line_span")
    assert found.dataset.wind_speed.values == pytest.approx(full.dataset.wind_speed.values)


def test_the_result_has_the_labels_of_a_simulated_line():
    scene = uneven_line()
    found = modal.mode_superposition(scene, 1.0, vertical=2, horizontal=2, torsional=1)
    full = gf.simulate(scene, 1.0)
    for name in ("node", "span", "phase", "subconductor", "station", "x1", "x2", "x3"):
        assert np.array_equal(found.dataset[name], full.dataset[name]), name
    for name in set(found.dataset.data_vars):
        assert found.dataset[name].dims == full.dataset[name].dims, name
        assert found.dataset[name].attrs == full.dataset[name].attrs, name
    assert "6 bundle torsion, 6 sub-span modes" in found.dataset.attrs["model"]
    assert found.spans.span.tolist() == [1, 2, 3]


def test_a_run_that_leaves_a_curve_names_the_place_and_its_own_limit():
    scene = uneven_line(**{"initial.seed_vertical": 3.0})
    with pytest.raises(gf.SimulationError) as caught:
        modal.mode_superposition(scene, 5.0, vertical=2, horizontal=2, torsional=1)
    report = caught.value.report
    assert report.outcome is gf.Outcome.ANGLE_OUT_OF_RANGE
    assert report.place.startswith("in span ")
    assert any(math.isclose(math.degrees(report.limit), end) for end in (-60, 80, -40, 40))


MOTION = {"x2": {"kind": "harmonic", "amplitude": 0.01, "frequency_hz": 1.0}}
REFUSED = {
    "section.left_end.motion is given": {"section.left_end": {"kind": "rigid", "motion": MOTION}},
    "section.suspensions.1.motion is given": {
        "section.suspensions.1": {"kind": "post", "motion": MOTION}
    },
    "wind.direction_deg is given": {"wind.direction_deg": 20.0},
    "wind speed = -9 m/s": {"section.spans.1.wind": {"speed": -9.0}},
    "wind.turbulence or wind.table is given": {
        "wind.turbulence": {"spectrum": "kaimal", "intensity": 0.1, "length_scale": 60.0}
    },
    "shedding is given": {"shedding": [{"span": 2, "time": 1.0}]},
}


@pytest.mark.parametrize("message", REFUSED)
def test_scenes_that_are_refused(message):
    with pytest.raises(gf.SceneError, match=message):
        modal.mode_superposition(uneven_line(**REFUSED[message]), 1.0)


def test_a_mesh_with_too_few_modes_is_refused():
    message = r"torsional = 40, 240 in the whole line: this mesh has only \d+ torsional modes"
    with pytest.raises(gf.SceneError, match=message):
        modal.mode_superposition(uneven_line(), 1.0, vertical=0, horizontal=0, torsional=40)


def test_strings_swing_only_in_the_nonlinear_model():
    """Three spans gallop; then the simulated strings swing at half the frequency (a 2:1 resonance).

    On a linear structure the drag moves the clamps a little, at twice the frequency.
    """
    scene = three_spans()
    full = gf.simulate(scene, 450.0, record_every=4)
    simple = modal.mode_superposition(
        scene, 450.0, vertical=3, horizontal=3, torsional=3, record_every=4
    )
    sizes, ratios = [], []
    for result in (full, simple):
        late = result.dataset.time.values > 350.0
        clamp = int(result.map.node_of_junction[result.map.tower(1).junctions[0]])
        across = result.dataset.u3.sel(node=clamp).values[late]
        up = result.midspan(1).u2.values[late]
        sizes.append(0.5 * np.ptp(across))
        time = result.dataset.time.values[late]
        ratios.append(strongest_frequency(time, across) / strongest_frequency(time, up))
    assert sizes == pytest.approx([0.57, 0.068], rel=0.02)  # observed 0.5746 and 0.0679 m
    assert ratios == pytest.approx([0.5, 2.0], rel=0.01)


@pytest.fixture(scope="module")
def comparison():
    return modal.compare(three_spans(**{"run.record_every": 2}), 30.0)


def test_a_comparison_of_a_line_has_each_mid_span(comparison):
    assert comparison.places == ((1, 1), (2, 1), (3, 1))
    assert len(comparison.divergences) == 3 * 2 * 3 * 2  # mid-spans, models, channels, levels
    amplitudes = comparison.amplitudes(2)
    steady = comparison.superposition.steady(span=2)
    assert amplitudes["superposition"]["u2"].amplitude == steady["u2"].amplitude
    assert comparison.divergence("linear", "u3", 0.2, span=3).span == 3
    with pytest.raises(gf.SceneError, match="span is missing; give a number from 1 to 3"):
        comparison.amplitudes()
    again = json.loads(json.dumps(comparison.as_dict(), allow_nan=False))
    assert [row["span"] for row in again["models"]["linear"]["spans"]] == [1, 2, 3]
    assert "span 3:" in str(comparison)


def test_linear_modes_of_a_line_have_its_families(comparison):
    fastest = comparison.linear_modes[0]
    assert fastest.growth_rate > 0.0
    assert {"tension-neutral", "vertical"} <= {mode.family for mode in comparison.linear_modes}


def test_the_figure_of_a_line_names_its_span(comparison):
    figure = comparison_figure(comparison, span=3)
    assert figure.get_supxlabel().startswith("Motion of span 3 in the nonlinear simulation")
    middle = comparison.nonlinear.bundle(3).u2.values
    first = figure.subfigs[0].axes[0].lines[0].get_ydata()
    assert np.array_equal(first, middle)
    with pytest.raises(gf.SceneError, match="span = 4, phase = None: the scene has spans 1 to 3"):
        comparison_figure(comparison, span=4)
