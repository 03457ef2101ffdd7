"""The [line] table: values computed from it, other sections, and refusals."""

import math
import re
import tomllib

import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

import gallop_fmu as gf
from gallop_fmu.input.annotated_toml import annotated_toml
from gallop_fmu.line.conductors import conductors, find_conductor
from gallop_fmu.line.ice_shapes import ice_section
from gallop_fmu.scene.dotted_paths import leaves
from gallop_fmu.scene.sag_tension import changed_tension

LINE = {
    "conductor": "Drake",
    "span": 300.0,
    "ruling_span": 250.0,
    "stringing_percent": 20.0,
    "stringing_temperature": 20.0,
    "temperature": -5.0,
    "ice_thickness": 0.012,
    "attack_angle_deg": 190.0,
    "wind_speed": 6.0,
    "coefficients": "example3",
    "insulator_length": 2.0,
    "insulator_weight": 600.0,
}


def line_scene(sections=None, **changes):
    line = {key: value for key, value in {**LINE, **changes}.items() if value is not None}
    return gf.Scene.from_dict({"line": line, **(sections or {})})


def test_the_scene_has_the_values_computed_from_the_line():
    scene, drake = line_scene(), find_conductor("Drake")
    ice = ice_section("crescent", drake.diameter, 0.012, 900.0)
    assert scene.conductor.mass_per_length == drake.mass_per_length
    assert scene.ice.mass_per_length == ice.mass_per_length
    assert scene.ice.first_moment_x2 == pytest.approx(
        ice.first_moment * math.sin(math.radians(190.0))
    )
    assert scene.ice.first_moment_x3 == pytest.approx(
        -ice.first_moment * math.cos(math.radians(190.0))
    )
    tension = changed_tension(
        0.2 * drake.rated_strength,
        span=250.0,
        weight=drake.mass_per_length * 9.81,
        new_weight=(drake.mass_per_length + ice.mass_per_length) * 9.81,
        axial_stiffness=drake.axial_stiffness,
        temperature_change=-25.0,
        expansion=drake.thermal_expansion,
    )
    assert scene.span.horizontal_tension == pytest.approx(tension, rel=1e-12)
    assert scene.supports.right.adjacent_span == 250.0
    assert scene.supports.left.adjacent_tension == scene.span.horizontal_tension
    assert scene.aerodynamics == gf.load_scene("example3").aerodynamics
    assert scene.wind.air_density == pytest.approx(
        1.2929 * 273.15 / 268.15, rel=1e-3
    )  # observed: 5e-4


def tension_by_integration(
    *, span, height, tension, weight, new_weight, stiffness, expansion, temperature_change
):
    """Change of state with ds0 = ds/(1 + T/EA), integrated over the catenary by quadrature."""

    def rest_length(horizontal, per_length):
        c = horizontal / per_length
        middle = math.asinh(0.5 * height / (c * math.sinh(0.5 * span / c)))

        def rest(x):  # ds/dx = cosh, T = H cosh
            slope = math.cosh(x / c + middle)
            return slope / (1.0 + horizontal * slope / stiffness)

        return quad(rest, -0.5 * span, 0.5 * span, epsabs=1e-10, epsrel=1e-12)[0]

    wanted = rest_length(tension, weight) * math.exp(expansion * temperature_change)
    return brentq(lambda guess: rest_length(guess, new_weight) - wanted, 1e3, 2e5)


@pytest.mark.parametrize(
    ("span", "height", "thickness", "cooling", "expected"),
    [
        (300.0, 200.0, 0.012, 20.0, 35130.0),
        (300.0, 200.0, 0.030, 15.0, 37476.0),
        (300.0, 200.0, 0.050, 15.0, 41258.0),
        (100.0, 65.0, 0.050, 15.0, 37684.0),
        (300.0, 90.0, 0.030, 15.0, 38080.0),
    ],
)
def test_the_change_of_state_is_that_of_the_slope(span, height, thickness, cooling, expected):
    sloping = {
        "conductor": "Drake",
        "span": span,
        "height_difference": height,
        "stringing_percent": 20.0,
    }
    line = {**sloping, "ice_thickness": thickness, "temperature": 15.0 - cooling}
    scene, drake = gf.Scene.from_dict({"line": line}), find_conductor("Drake")
    known = tension_by_integration(
        span=span,
        height=height,
        tension=0.2 * drake.rated_strength,
        weight=9.81 * drake.mass_per_length,
        new_weight=9.81 * (drake.mass_per_length + scene.ice.mass_per_length),
        stiffness=drake.axial_stiffness,
        expansion=drake.thermal_expansion,
        temperature_change=-cooling,
    )
    assert scene.span.horizontal_tension == pytest.approx(
        known, rel=1e-3
    )  # observed at most 5e-4: stretch T/EA
    assert scene.span.horizontal_tension == pytest.approx(expected, rel=2e-5)
    assert "in the span from" in scene.sources["span.horizontal_tension"]
    level = gf.Scene.from_dict({"line": {**line, "height_difference": 0.0}}).span.horizontal_tension
    ruled = gf.Scene.from_dict({"line": {**line, "ruling_span": span}})
    assert ruled.span.horizontal_tension == level  # the custom with a ruling span
    assert "in a level ruling span of" in ruled.sources["span.horizontal_tension"]


@pytest.mark.parametrize(
    ("tension", "part"),
    [
        (1e-300, "thousandth"),
        (0.1, "thousandth"),
        (5.0, "hundredth"),
        (28.0, "hundredth"),
        (300.0, "tenth"),
    ],
)
def test_a_tension_in_kilonewtons_is_asked_about(tension, part):
    message = (
        rf"^line.stringing_tension = {tension:g} N is less than a {part} of the weight of the span"
        r" \(4790 N\); is it"
    )
    with pytest.raises(gf.SceneError, match=message + " in kN"):
        gf.Scene.from_dict(
            {"line": {"conductor": "Drake", "span": 300.0, "stringing_tension": tension}}
        )


def test_a_percentage_of_the_strength_that_bears_no_span_is_refused():
    message = (
        r"= 1.1 % of the rated strength, 1541 N, is less than a tenth of the weight of the span"
        r" \(1.597e\+04 N\); check"
    )
    with pytest.raises(gf.SceneError, match=message):
        gf.Scene.from_dict(
            {"line": {"conductor": "Drake", "span": 1000.0, "stringing_percent": 1.1}}
        )


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"ice_density": 0.9},
            (
                r"ice_density = 0.9 kg/m3: no line has less than 50 .* is it in g/cm3 \(then 900"
                r" kg/m3\)\?$"
            ),
        ),
        (
            {"ice_thickness": 12.0},
            r"ice_thickness = 12.0: must be .* at most 1 \[m\].* is it in mm \(then 0.012 m\)\?$",
        ),
        (
            {"ice_thickness": 0.6},
            (
                r"ice_thickness = 0.6 m: no line has .* more than 0.5 m; is it in cm \(then 0.006"
                r" m\)\?$"
            ),
        ),
        (
            {"stringing_percent": 0.2},
            r"stringing_percent = 0.2 %: no line has .*; is it a fraction \(then 20 %\)\?$",
        ),
        (
            {"span": 0.3, "ruling_span": None},
            r"span = 0.3 m: no line has .*; is it in km \(then 300 m\)\?$",
        ),
        (
            {"temperature": 268.15},
            r"temperature = 268.15: must be .*; is it in K \(then -5 degC\)\?$",
        ),
        (
            {"insulator_length": 2100.0},
            r"insulator_length = 2100 m: no line .*; is it in mm \(then 2.1 m\)\?$",
        ),
        (
            {"insulator_weight": 0.6},
            r"insulator_weight = 0.6 N: no line .*; is it in kN \(then 600 N\)\?$",
        ),
    ],
)
def test_an_impossible_value_is_asked_about(changes, message):
    with pytest.raises(gf.SceneError, match="^line." + message):
        line_scene(**changes)


def test_an_unusual_value_is_warned_of_and_the_warning_survives_saving():
    scene = line_scene(ice_thickness=0.15)
    (warning,) = scene.warnings
    assert warning.startswith("line.ice_thickness = 0.15 m is outside the usual 0.001 to 0.08 m; ")
    assert gf.Scene.from_dict(tomllib.loads(scene.to_toml())).warnings == scene.warnings
    assert line_scene().warnings == ()


@pytest.mark.parametrize("changes", [{"ice_shape": "radial"}, {"ice_thickness": 0.0}])
def test_a_round_section_with_a_curve_that_has_lift_is_warned_of(changes):
    (warning,) = line_scene(**changes).warnings
    assert warning.startswith("the first moments of the ice are 0, as for round or no ice")
    assert (
        "the coefficient curve has lift up to 2.12, which a round section does not have" in warning
    )
    level = {
        "kind": "polynomial",
        "valid_from_deg": 0.0,
        "valid_to_deg": 360.0,
        "lift": [0.0],
        "drag": [1.0],
    }
    assert line_scene({"aerodynamics": {**level, "moment": [0.0]}}, **changes).warnings == ()


def test_other_sections_are_merged_with_the_line(tmp_path):
    sections = {
        "aerodynamics": {"outside": "hold"},
        "damping": {"translation": {"low_ratio": 0.004}},
    }
    scene, plain = line_scene(sections), line_scene()
    assert scene.aerodynamics == plain.aerodynamics.model_copy(update={"outside": "hold"})
    assert scene.sources["aerodynamics.outside"] == "set by the user"
    assert scene.sources["aerodynamics"] == plain.sources["aerodynamics"]
    assert scene.damping.translation.low_ratio == 0.004
    assert scene.damping.translation.high_ratio == plain.damping.translation.high_ratio
    moved = line_scene({"supports": {"right": {"insulator_length": 3.0}}})
    assert moved.supports.left == plain.supports.left
    assert moved.supports.right == plain.supports.right.model_copy(update={"insulator_length": 3.0})


def test_a_table_of_a_full_turn_needs_no_value_for_outside(tmp_path):
    rows = [f"{10 * k},{-0.5 * math.sin(math.radians(10 * k))},1,0" for k in range(36)]
    (tmp_path / "ice.csv").write_text("\n".join(["angle_deg,lift,drag,moment", *rows]))
    line = {**LINE, "coefficients": "ice.csv", "attack_angle_deg": 355.0}
    scene = gf.Scene.from_dict({"line": line}, folder=tmp_path)
    assert (scene.aerodynamics.beyond, scene.aerodynamics.range_deg) == ("periodic", (0.0, 360.0))
    (tmp_path / "ice.csv").write_text(
        "\n".join(["angle_deg,lift,drag,moment", *rows, "360,0.02,1,0"])
    )
    noisy = gf.Scene.from_dict({"line": line}, folder=tmp_path)
    assert noisy.warnings == (
        (
            "aerodynamics.lift is -0 at 0 deg and 0.02 at 360 deg, the same angle: the mean of both"
            " is used"
        ),
    )
    turning = scene.with_values({"ice.attack_angle_deg": 0.0, "numerics.elements": 4})
    result = gf.simulate(turning, 5.0)
    assert (
        result.midspan().theta.min() < 0.0 < result.midspan().theta.max()
    )  # across the seam, both ways


@pytest.mark.parametrize("tension", [480.0, 600.0, 1200.0, 28e3])
def test_every_other_tension_has_a_change_of_state(tension):
    line = {
        "conductor": "Drake",
        "span": 300.0,
        "stringing_tension": tension,
        "ice_thickness": 0.05,
    }
    assert gf.Scene.from_dict({"line": line}).span.horizontal_tension > 480.0


def test_every_value_has_a_source():
    scene = line_scene()
    untold = [
        leaf.path
        for leaf in leaves(scene)
        if leaf.path not in ("title", "description", "notes", "sources", "loads", "shedding")
        and leaf.value is not None
        and not any(
            leaf.path == source or leaf.path.startswith(source + ".") for source in scene.sources
        )
    ]
    assert untold == []


def test_the_scene_is_plain_numbers_and_survives_saving(tmp_path):
    scene = line_scene()
    scene.save(tmp_path / "plain.toml")
    assert "line" not in tomllib.loads((tmp_path / "plain.toml").read_text())
    assert gf.load_scene(tmp_path / "plain.toml") == scene
    (tmp_path / "noted.toml").write_text(annotated_toml(scene))
    assert gf.load_scene(tmp_path / "noted.toml") == scene


def test_every_number_of_an_annotated_file_has_its_unit():
    scene = line_scene()
    text = annotated_toml(scene)
    assert "length = 300.0  # horizontal distance between the supports [m]\n" in text
    assert "# lift polynomial, ascending powers of radians [1]\nlift = [\n" in text
    numbers = re.findall(r"^\w+ = [-\d].*$", text.partition("[span]")[2], re.MULTILINE)
    assert len(numbers) > 40
    assert all(re.search(r"  # .+ \[.+\]$", row) for row in numbers)


def test_explicit_values_override_the_line():
    history = {"kind": "constant", "value": 3.0}
    scene = line_scene(
        {
            "title": "mine",
            "conductor": {"torsional_stiffness": 160.0},
            "wind": {"history": history},
            "run": {"stop_time": 30.0},
            "sources": {"conductor.torsional_stiffness": "measured"},
        }
    )
    assert scene.title == "mine"
    assert scene.conductor.torsional_stiffness == 160.0
    assert scene.conductor.diameter == 0.02813
    assert scene.sources["conductor.torsional_stiffness"] == "measured"
    assert (scene.wind.speed, scene.wind.mean_speed) == (None, 3.0)
    assert (scene.run.stop_time, scene.sources["run.stop_time"]) == (30.0, "set by the user")
    assert "wind.speed" not in scene.sources
    with pytest.raises(gf.SceneError, match=r"speed = 5.0 m/s and history are both given"):
        line_scene({"wind": {"speed": 5.0, "history": history}})


def test_an_explicit_curve_replaces_the_whole_curve():
    flat = {
        "kind": "table",
        "angle_deg": [0.0, 360.0],
        "lift": [0.0, 0.0],
        "drag": [1.0, 1.0],
        "moment": [0.0, 0.0],
    }
    scene = line_scene({"aerodynamics": flat, "supports": {"left": {"kind": "rigid"}}})
    assert (scene.aerodynamics.kind, scene.sources["aerodynamics"]) == ("table", "set by the user")
    assert (scene.supports.left.kind, scene.supports.right.kind) == ("rigid", "adjacent_span")
    assert scene.sources["supports.left"] == "set by the user"


def test_a_bare_dead_ended_line_needs_three_numbers():
    scene = gf.Scene.from_dict(
        {"line": {"conductor": "zebra", "span": 300.0, "stringing_tension": 20e3}}
    )
    assert scene.supports.left.kind == "rigid"
    assert scene.ice.mass_per_length == 0.0
    assert scene.wind.speed == 0.0
    assert scene.span.horizontal_tension > 20e3  # strung at 15 degrees, hangs at 0


def test_no_thickness_is_no_ice_for_a_d_too():
    ice = line_scene(ice_shape="d_shape", ice_thickness=0.0).ice
    assert (ice.mass_per_length, ice.torsional_inertia, ice.first_moment_x3) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("name", conductors())
def test_every_conductor_hangs(name):
    line = {
        "conductor": name,
        "span": 250.0,
        "stringing_tension": 100.0 * find_conductor(name).mass_per_length * 150.0,
    }
    scene = gf.Scene.from_dict(
        {"line": {**line, "ice_thickness": 0.01}, "numerics": {"elements": 4}}
    )
    assert gf.Model(scene).equilibrium().sag > 1.0


def test_a_csv_of_a_full_turn_is_periodic(tmp_path):
    rows = [
        "angle_deg,lift,drag,moment",
        "0,0,1,0",
        "90,0.5,1.1,0.1",
        "270,-0.5,1.1,-0.1",
        "360,0,1,0",
    ]
    (tmp_path / "ice.csv").write_text("\n".join(rows))
    line = {**LINE, "coefficients": "ice.csv"}
    scene = gf.Scene.from_dict({"line": line}, folder=tmp_path)
    assert scene.aerodynamics.beyond == "periodic"
    assert scene.aerodynamics.angle_deg == (0.0, 90.0, 270.0, 360.0)
    (tmp_path / "ice.csv").write_text("\n".join(rows[:-1]))
    assert (
        gf.Scene.from_dict({"line": line}, folder=tmp_path).aerodynamics.beyond == "error"
    )  # steps of 180 deg


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"conductor": "Drak"}, r"line.conductor: 'Drak' is not a code word.*closest: Drake"),
        ({"span": -1.0}, r"line.span = -1.0: must be greater than 0 and at most 10000 \[m\]"),
        ({"spam": 1.0}, r"line.spam: unknown key; the closest valid one is line.span"),
        (
            {"stringing_percent": None},
            r"line: neither of stringing_tension.*give exactly one",
        ),
        ({"stringing_tension": 28e3}, r"line: both of stringing_tension.*give exactly one"),
        (
            {"conductor": "Araucaria"},
            r"line.stringing_percent = 20.0: the table has no confirmed rated strength of"
            " Araucaria",
        ),
        (
            {"coefficients": "exampl"},
            r"line.coefficients = 'exampl': neither a CSV file nor.*assumed, example2.*closest: ex",
        ),
        ({"coefficients": "no.csv"}, r"no.csv: no such file"),
        ({"insulator_weight": None}, r"line: only one of insulator_length"),
        (
            {"insulator_length": None, "insulator_weight": None, "adjacent_span": 9.0},
            r"needs suspension strings",
        ),
        (
            {"stringing_percent": None, "stringing_tension": 200e3},
            r"more than the rated strength of Drake, 140120 N",
        ),
        (
            {"ice_thickness": 0.1, "ice_shape": "radial"},
            r"line: the tension of the iced conductor is .* more than the rated strength",
        ),
        ({"ice_shape": "star"}, r"line.ice_shape = 'star': must be 'radial', 'crescent'"),
        (
            {"attack_angle_deg": 0.0},
            r"ice.attack_angle_deg = 0.0 is outside the coefficient curve",
        ),
    ],
)
def test_a_bad_line_names_the_field_and_the_cure(changes, message):
    with pytest.raises(gf.SceneError, match=message):
        line_scene(**changes)


def test_without_coefficients_a_line_in_wind_has_the_assumed_curve():
    scene, drake = line_scene(coefficients=None), find_conductor("Drake")
    assert scene.aerodynamics.kind == "assumed"
    assert scene.aerodynamics.ice_thickness_ratio == pytest.approx(0.012 / drake.diameter)
    assert "ASSUMED, not measured" in scene.sources["aerodynamics"]
    assert any("ASSUMED" in warning for warning in scene.warnings)
    assert line_scene(coefficients="assumed").aerodynamics == scene.aerodynamics
    assert line_scene(coefficients=None, wind_speed=None).aerodynamics is None
    assert "ASSUMED" in annotated_toml(scene)


@pytest.mark.parametrize(
    ("changes", "drag"), [({"ice_shape": "radial"}, 1.853), ({"ice_thickness": 0.0}, 1.0)]
)
def test_round_ice_without_coefficients_has_drag_alone(changes, drag):
    # 1 + 2 t/d with t = 12 mm and d = 28.13 mm.
    scene = line_scene(coefficients=None, **changes)
    assert scene.aerodynamics.lift == (0.0,)
    assert scene.aerodynamics.drag[0] == pytest.approx(drag, abs=1e-3)
    assert "ASSUMED" in scene.sources["aerodynamics"]


def test_a_line_takes_a_published_curve_by_its_name():
    scene = line_scene(coefficients="square_prism_parkinson_smith", attack_angle_deg=0.0)
    assert scene.aerodynamics.name == "square_prism_parkinson_smith"
    assert "Parkinson" in scene.sources["aerodynamics"]
