"""Bad input is refused with the field, the value given and what is allowed."""

import math
import re

import pytest

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.input.scene_files import load_scene
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.supports import RigidSupport

POSITIVE = [
    ("span.length", "m"),
    ("span.sag", "m"),
    ("conductor.diameter", "m"),
    ("conductor.mass_per_length", "kg/m"),
    ("conductor.axial_stiffness", "N"),
    ("conductor.torsional_stiffness", "N m2/rad"),
    ("conductor.torsional_inertia", "kg m"),
    ("supports.left.stiffness_x1", "N/m"),
    ("supports.right.stiffness_x3", "N/m"),
    ("wind.air_density", "kg/m3"),
    ("numerics.time_step", "s"),
    ("run.stop_time", "s"),
]


@pytest.mark.parametrize("value", [0.0, -3.0, math.nan, math.inf])
@pytest.mark.parametrize(("path", "unit"), POSITIVE)
def test_positive_quantities(path, unit, value):
    with pytest.raises(SceneError) as caught:
        load_scene("example2").with_values({path: value})
    message = str(caught.value)
    assert message.startswith(f"{path} = {value}: must be ")
    assert "greater than 0" in message
    assert f"[{unit}]; " in message
    assert "\n" not in message


@pytest.mark.parametrize(
    ("path", "value", "allowed"),
    [
        ("ice.mass_per_length", -0.1, "must be at least 0 [kg/m]"),
        ("ice.attack_angle_deg", 361.0, "must be at least -360 and at most 360 [deg]"),
        ("wind.speed", 151.0, "must be at least -150 and at most 150 [m/s]"),
        ("wind.speed", "fast", "must be a finite number at least -150 and at most 150 [m/s]"),
        ("wind.speed", True, "must be a finite number at least -150 and at most 150 [m/s]"),
        ("numerics.elements", 1, "must be at least 2 and at most 5000 [1]"),
        ("numerics.elements", 15.5, "must be a whole number at least 2 and at most 5000 [1]"),
        ("numerics.time_step", 1.5, "must be greater than 0 and at most 1 [s]"),
        ("damping.twist.low_ratio", 1.0, "must be at least 0 and less than 1 [1]"),
        ("aerodynamics.lift.1", math.nan, "must be a finite number [1]"),
        ("aerodynamics.outside", "stop", "must be 'error', 'hold' or 'periodic'"),
        ("supports.left.kind", "hinge", "must be one of 'rigid', 'springs', 'adjacent_span'"),
    ],
)
def test_quantities_with_a_range(path, value, allowed):
    with pytest.raises(SceneError, match=re.escape(f"{path} = {value!r}: {allowed}")):
        load_scene("example2").with_values({path: value})


@pytest.mark.parametrize(
    ("value", "problem"),
    [
        (["x"], "aerodynamics.lift.0 = 'x': must be a finite number [1]; "),
        ([], "aerodynamics.lift = []: must have at least 1 value; "),
        ([1.0] * 5, "aerodynamics.lift = [1.0, 1.0, 1.0, 1.0, 1.0]: must have at most 4 values; "),
    ],
)
def test_arrays_of_wrong_length_or_content_have_one_problem(value, problem):
    with pytest.raises(SceneError) as caught:
        load_scene("example2").with_values({"aerodynamics.lift": value})
    assert str(caught.value) == problem + "lift polynomial, ascending powers of radians"


@pytest.mark.parametrize(
    ("path", "closest"),
    [
        ("wind.sped", "wind.speed"),
        ("wind.lenght", "span.length"),
        ("time_step", "numerics.time_step"),
        ("span.length.x", "span.length"),
        ("supports.left.stiffnes_x1", "supports.left.stiffness_x1"),
    ],
)
def test_unknown_key_names_the_closest(path, closest):
    with pytest.raises(SceneError) as caught:
        load_scene("example2").with_values({path: 1.0})
    assert str(caught.value) == f"{path}: unknown key; the closest valid one is {closest}"


def test_unknown_key_in_a_file_is_refused_together_with_other_problems(tmp_path):
    bad = (
        load_scene("zebra")
        .to_toml()
        .replace("gravity = ", "gravty = ")
        .replace("length = 322.8", "length = -322.8")
    )
    (tmp_path / "bad.toml").write_text(bad)
    with pytest.raises(SceneError) as caught:
        load_scene(tmp_path / "bad.toml")
    first, *problems = str(caught.value).splitlines()
    assert first.endswith("bad.toml:")
    assert problems == [
        (
            "  span.length = -322.8: must be greater than 0 and at most 10000 [m]; "
            "horizontal distance between the supports"
        ),
        "  span.gravty: unknown key; the closest valid one is span.gravity",
    ]


def test_missing_value_names_the_alternatives(minimal):
    del minimal["conductor"]["diameter"]
    with pytest.raises(
        SceneError,
        match=(
            r"conductor\.diameter: missing, must be .* greater than 0 and at most 1 \[m\]; diameter"
        ),
    ):
        Scene.from_dict(minimal)


def test_sag_and_tension_that_contradict_each_other(minimal):
    # m g L^2/(8 H) = 4.0 m at H = 4598.4 N.
    minimal["span"] = {"length": 100.0, "sag": 4.0, "horizontal_tension": 4598.4 * 1.049}
    Scene.from_dict(minimal)
    minimal["span"]["horizontal_tension"] = 4598.4 * 1.06
    with pytest.raises(
        SceneError, match=r"sag = 4\.0 m and .*4874\.3.* contradict .* sag of 3\.774 m.* 5%"
    ):
        Scene.from_dict(minimal)


@pytest.mark.parametrize(
    ("tension", "part"), [(1.0, "thousandth"), (14.0, "hundredth"), (140.0, "tenth")]
)
def test_a_tension_that_no_span_has_is_refused_before_a_catenary_is_computed(
    minimal, tension, part
):
    minimal["span"] = {"length": 100.0, "horizontal_tension": tension}
    message = (
        rf"^span.horizontal_tension = {tension:g} N is less than a {part} of the weight of the span"
        r" \(1472 N\)"
    )
    with pytest.raises(SceneError, match=message + "; is it in kN"):
        Scene.from_dict(minimal)
    minimal["span"]["sag"] = 4.0
    with pytest.raises(SceneError, match=message):
        Scene.from_dict(minimal)
    del minimal["span"]["horizontal_tension"]
    with pytest.raises(SceneError, match=message):
        Scene.from_dict(minimal).with_values({"span.horizontal_tension": tension, "span.sag": None})


def test_a_tension_of_an_adjacent_span_in_kilonewtons_is_asked_about(minimal):
    adjacent = {"kind": "adjacent_span", "adjacent_span": 100.0, "adjacent_tension": 5.0}
    minimal["supports"] = {"left": {**adjacent, "insulator_length": 2.0, "insulator_weight": 500.0}}
    message = (
        r"^supports.left.adjacent_tension = 5 N is less than a hundredth of the weight of the span"
        r" \(1472 N\); is"
    )
    with pytest.raises(SceneError, match=message):
        Scene.from_dict(minimal)


def test_a_sag_in_centimetres_is_asked_about(minimal):
    minimal["span"]["sag"] = 501.0
    with pytest.raises(
        SceneError, match=r"^span.sag = 501 m is more than 5 times span.length = 100 m; is it in cm"
    ):
        Scene.from_dict(minimal)


def test_sag_of_an_inclined_span_is_measured_from_the_chord(minimal):
    # Slope 3/4: the same tension sags 1/cos = 1.25 times as much.
    minimal["span"] = {
        "length": 100.0,
        "height_difference": 75.0,
        "sag": 5.0,
        "horizontal_tension": 4598.4,
    }
    Scene.from_dict(minimal)
    minimal["span"]["sag"] = 4.0
    with pytest.raises(SceneError, match="contradict"):
        Scene.from_dict(minimal)


def test_ice_counts_in_the_comparison_of_sag_and_tension(minimal):
    minimal["span"]["horizontal_tension"] = 4598.4
    minimal["ice"] = {"mass_per_length": 0.5}
    with pytest.raises(SceneError, match=r"sag of 5\.333 m"):
        Scene.from_dict(minimal)


def test_first_moments_up_to_a_positive_definite_mass_matrix():
    # sqrt(I mu) = sqrt(0.5702e-4 1.53) = 9.340e-3 kg, next to which S_x2 = 0.459e-3 kg counts
    # little.
    scene = load_scene("example2")
    assert scene.with_values({"ice.first_moment_x2": -9.32e-3}).ice.first_moment_x2 == -9.32e-3
    with pytest.raises(SceneError, match="positive definite mass matrix"):
        scene.with_values({"ice.first_moment_x2": -9.34e-3})


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        (
            {"span.sag": None, "span.horizontal_tension": None},
            r"give sag \[m\] or horizontal_tension \[N\]",
        ),
        (
            {"span.height_difference": -126.0},
            r"height_difference = -126\.0 must be less than length = 125\.88 m",
        ),
        (
            {"ice.first_moment_x2": -0.145},
            r"ice\.first_moment_x2 = -0\.145 .*must be less than .*8\.724e-05",
        ),
        (
            {"aerodynamics": None},
            "wind is given but aerodynamics is not; give a coefficient curve",
        ),
        (
            {"ice.attack_angle_deg": 85.0},
            r"ice\.attack_angle_deg = 85\.0 is outside .* from -60\.0 to 80\.0 deg",
        ),
        ({"ice.attack_angle_deg": 181.0}, r"ice\.attack_angle_deg = 181\.0 is outside"),
        (
            {"wind.history": {"kind": "constant", "value": 1.0}},
            r"wind: speed = 4\.1 m/s and history are both given",
        ),
        (
            {
                "wind": {
                    "history": {
                        "kind": "harmonic",
                        "mean": 3.0,
                        "amplitude": 154.0,
                        "frequency_hz": 0.1,
                    }
                }
            },
            r"history reaches -151\.0 m/s; it must stay within -150 to 150 m/s",
        ),
        (
            {"damping.twist.high_ratio": 0.01},
            r"high_ratio = 0\.01 would excite .* at least 0\.01895",
        ),
        (
            {"damping.twist.high_frequency": 5.0},
            r"low_frequency = 5\.29 Hz must be less than high_frequency = 5\.0 Hz",
        ),
        (
            {"loads": [{"force": [0, 1, 0]}]},
            "neither of position and evenly_spaced given; give exactly one",
        ),
        ({"loads": [{"force": [0, 1], "position": 0.5}]}, r"loads\.0\.force\.2: missing"),
        (
            {
                "wind": {
                    "history": {
                        "kind": "pulse",
                        "peak": 9.0,
                        "rise": 2.0,
                        "fall_start": 1.0,
                        "fall": 1.0,
                    }
                }
            },
            r"fall_start = 1\.0 s is before the end of the rise at 2\.0 s",
        ),
        (
            {"sources": {"span.lenght": "map"}},
            r"sources\.span\.lenght: unknown key; the closest valid one is span\.length",
        ),
    ],
)
def test_values_that_do_not_fit_together(changes, message):
    with pytest.raises(SceneError, match=message):
        load_scene("example2").with_values(changes)


@pytest.mark.parametrize("angle", [-300.0, 350.0, 80.0, -60.0])
def test_attack_angle_is_compared_after_whole_turns(angle):
    assert (
        load_scene("example2").with_values({"ice.attack_angle_deg": angle}).ice.attack_angle_deg
        == angle
    )


CURVE = {"angle_deg": [0, 90, 180], "lift": [0, 1, 0], "drag": [1, 2, 1], "moment": [0, 0, 0]}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"angle_deg": [0, 180, 90]}, r"angle_deg must increase; row 3 has 90\.0 after 180\.0"),
        ({"angle_deg": [0, 90, 90]}, r"angle_deg must increase; row 3 has 90\.0 after 90\.0"),
        (
            {"angle_deg": [0, math.nan, 90]},
            r"\.angle_deg\.1 = nan: must be a finite number \[deg\]",
        ),
        ({"drag": [1, 2, math.nan]}, r"\.drag\.2 = nan: must be a finite number \[1\]"),
        (
            {key: value[:1] for key, value in CURVE.items()},
            "angle_deg has 1 point; give at least two",
        ),
        ({"drag": [1, 2]}, "drag has 2 values, angle_deg has 3"),
        ({"angle_deg": [0, 90, 361]}, "more than a turn; give at most 360 deg"),
        (
            {"outside": "periodic"},
            r"range of exactly 360 deg, or of one step less .* covers 180\.0 deg",
        ),
        (
            {"angle_deg": [0, 90, 360], "lift": [0, 1, 0.06]},
            (
                r"lift is 0 at 0 deg and 0.06 at 360 deg, the same angle; make them equal, or set"
                r" outside = \"error\""
            ),
        ),
        ({"file": "ice.csv"}, "'ice.csv' and angle_deg, lift, drag, moment are both given"),
    ],
)
def test_bad_coefficient_tables(changes, message, minimal):
    with pytest.raises(SceneError, match=f"^aerodynamics.*{message}"):
        Scene.from_dict({**minimal, "aerodynamics": {"kind": "table", **CURVE, **changes}})


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "angle_deg,lift,drag,moment\n0,0,1,0\n40,0,1,0\n35,0,1,0\n",
            "ice.csv: angle_deg must increase; row 4 has 35.0",
        ),
        (
            "angle_deg,lift,drag,moment\n0,0,1,0\n\n40,nan,1,0\n",
            "ice.csv: lift in row 4 is 'nan', must be a finite",
        ),
        (
            "angle_deg,lift,drag,moment\n0,0,1,0\n40,,1,0\n",
            "ice.csv: lift in row 3 is '', must be a finite number",
        ),
        (
            "angle_deg,lift,drag,moment\n0,0,1,0\n40,1,0\n",
            "ice.csv: row 3 has 3 cells, 4 are required",
        ),
        ("angle_deg,lift,drag,moment\n0,0,1,0\n", "ice.csv: angle_deg has 1 point"),
        (
            "alpha,CL,CD,CM\n0,0,1,0\n",
            "must name angle_deg,lift,drag,moment; it has 'alpha'. Rename the",
        ),
        ("", "the file is empty"),
        (None, "ice.csv: no such file"),
    ],
)
def test_bad_coefficient_files(text, message, minimal, tmp_path):
    if text is not None:
        (tmp_path / "ice.csv").write_text(text)
    with pytest.raises(SceneError, match=re.escape(message)):
        Scene.from_dict(
            {**minimal, "aerodynamics": {"kind": "table", "file": "ice.csv"}}, folder=tmp_path
        )


@pytest.mark.parametrize(
    ("table", "message"),
    [
        (
            {"time": [0, 1, 2, 30], "value": [1, 1, 1, 1]},
            r"gap of 28 s in time before row 4 \(from 2 to 30 s\); at most 10 s",
        ),
        (
            {"time": [0, 1, 2, 5], "value": [1, 1, 1, 1], "max_gap": 2},
            "gap of 3 s .* at most 2 s are interpolated",
        ),
        ({"time": [0, 2, 1], "value": [1, 1, 1]}, r"time must increase; row 3 has 1\.0 after 2\.0"),
        (
            {"time": [0, 1, 1, 1], "value": [1] * 4},
            r"time must increase; row 4 has 1\.0 after 1\.0",
        ),
        (
            {"time": [0, math.nan], "value": [1, 1]},
            r"wind\.history\.time\.1 = nan: must be a finite number \[s\]",
        ),
        ({"time": [0, 1], "value": [1, math.nan]}, r"wind\.history\.value\.1 = nan"),
        ({"time": [0], "value": [1]}, "time has 1 point; give at least two"),
        ({"time": [0, 1], "value": [1]}, "value has 1 values, time has 2"),
    ],
)
def test_bad_wind_tables(table, message, minimal):
    with pytest.raises(SceneError, match=message):
        Scene.from_dict({**minimal, "wind": {"history": {"kind": "table", **table}}})


def test_gap_in_a_wind_file_names_file_and_row(minimal, tmp_path):
    (tmp_path / "mast.csv").write_text("time,value\n0,1\n1,1\n2,1\n3,1\n60,1\n")
    table = {"kind": "table", "file": "mast.csv"}
    with pytest.raises(
        SceneError, match=r"wind\.history: mast\.csv: gap of 57 s in time before row 6"
    ):
        Scene.from_dict({**minimal, "wind": {"history": table}}, folder=tmp_path)
    with pytest.raises(
        SceneError, match="wind is given but aerodynamics is not"
    ):  # the gap is now accepted
        Scene.from_dict({**minimal, "wind": {"history": {**table, "max_gap": 60}}}, folder=tmp_path)


@pytest.mark.parametrize("integrator", [None, "newmark", "gauss6"])
def test_only_generalised_alpha_has_a_spectral_radius(integrator):
    with pytest.raises(
        SceneError, match=r"spectral_radius = 0\.8: only integrator = \"generalised_alpha\" has one"
    ):
        load_scene("example3").with_values(
            {"numerics.integrator": integrator, "numerics.spectral_radius": 0.8}
        )


@pytest.mark.parametrize(
    "content", ["hunter2\n", "root:x:0:0:root:/root:/bin/bash\n", "time,value\nhunter2,1\n"]
)
def test_a_file_that_is_no_table_is_not_quoted(tmp_path, content):
    """A foreign scene may name any file of its user."""
    (tmp_path / "password").write_text(content)
    history = {"kind": "table", "file": str(tmp_path / "password")}
    with pytest.raises(SceneError, match=r"password: .* something else") as refusal:
        load_scene("example3").with_values({"wind.speed": None, "wind.history": history})
    assert "hunter2" not in str(refusal.value)
    assert "root" not in str(refusal.value).replace(str(tmp_path), "")


ADJACENT = {
    "kind": "adjacent_span",
    "adjacent_span": 120.0,
    "adjacent_tension": 20e3,
    "insulator_length": 2.0,
    "insulator_weight": 500.0,
    "motion": {"x1": {"kind": "constant", "value": 0.1}},
}


def test_a_kind_can_be_set_by_its_path(minimal):
    scene = Scene.from_dict({**minimal, "supports": {"left": ADJACENT, "right": ADJACENT}})
    dead_end = scene.with_values({"supports.left.kind": "rigid"})
    assert dead_end.supports.left == RigidSupport(motion=scene.supports.left.motion)
    assert dead_end.supports.right == scene.supports.right
    stiffness = {"supports.left.stiffness_x1": 1e5, "supports.left.stiffness_x3": 1e4}
    kind = {"supports.left.kind": "springs"}
    assert scene.with_values({**stiffness, **kind}) == scene.with_values({**kind, **stiffness})
    assert scene.with_values({**kind, **stiffness}).supports.left.stiffness_x3 == 1e4
    with pytest.raises(
        SceneError, match=r"^supports.left.stiffness_x1: missing, .*\nsupports.left.stiffness_x3"
    ):
        scene.with_values(kind)
    assert scene.with_values({"supports.left.kind": "adjacent_span"}) == scene
    with pytest.raises(
        SceneError, match=r"supports.left.kind = 'rope': must be one of 'rigid', 'springs', 'adj"
    ):
        scene.with_values({"supports.left.kind": "rope"})


@pytest.mark.parametrize(
    ("path", "message"),
    [
        (
            "supports.left.stiffness_x1",
            "only supports.left.kind = 'springs' has this value; set the kind too, or",
        ),
        (
            "supports.left.adjacent_span",
            "only supports.left.kind = 'adjacent_span' has this value; set the kind too",
        ),
        ("loads.3.law.peak", "only loads.3.law.kind = 'pulse' has this value"),
        ("loads.0.torque", "loads.0 is not given in this scene; give the whole section"),
    ],
)
def test_a_key_that_exists_is_never_called_unknown(minimal, path, message):
    scene = Scene.from_dict(minimal)
    for refused in (lambda: scene.with_values({path: 1.0}), lambda: scene.unit_of(path)):
        with pytest.raises(SceneError, match=f"^{path}: {message}"):
            refused()


def test_files_that_name_the_mesh_of_release_0_1_0_load_and_half_a_span_is_refused():
    data = load_scene("example3").model_dump(mode="json", exclude_none=True)
    data["numerics"]["mesh"] = "whole_span"
    assert Scene.from_dict(data) == load_scene("example3")
    data["numerics"]["mesh"] = "half_span"
    with pytest.raises(SceneError, match="only whole spans are computed"):
        Scene.from_dict(data)
