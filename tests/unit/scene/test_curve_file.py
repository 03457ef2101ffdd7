"""Coefficient curves from CSV files: degrees, radians, closed turns and refusals."""

import math

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.scene.curve_file import read_curve
from gallop_fmu.scene.table_coefficients import TableCoefficients


def curve_text(angles, header="angle_deg,lift,drag,moment", degrees=None):
    rows = [header]
    for angle, deg in zip(angles, degrees or angles, strict=True):
        a = math.radians(deg)
        rows.append(f"{angle},{math.sin(a):.6f},{1.2 - 0.2 * math.cos(2 * a):.6f},0.0")
    return "\n".join(rows) + "\n"


def loaded(tmp_path, text):
    (tmp_path / "curve.csv").write_text(text)
    return TableCoefficients.model_validate({"file": "curve.csv"}, context={"folder": tmp_path})


TURN = [10.0 * k for k in range(37)]


@pytest.mark.parametrize("header", ["angle_rad", "angle [rad]", "Angle (rad)", "ANGLE_RAD [rad]"])
@pytest.mark.parametrize("digits", [3, 4, 16])
@pytest.mark.parametrize("closed", [True, False])
def test_radians_are_the_same_curve_as_degrees(tmp_path, header, digits, closed):
    degrees = TURN if closed else TURN[:-1]
    radians = [f"{math.radians(deg):.{digits}f}" for deg in degrees]
    text = curve_text(radians, f"{header},lift,drag,moment", degrees)
    there, here = loaded(tmp_path, text), loaded(tmp_path, curve_text(TURN))
    assert (there.beyond, there.range_deg) == ("periodic", (0.0, 360.0))
    alpha = np.linspace(-7.0, 7.0, 501)
    # Observed: 5e-4 with three digits, of which the angles are rounded to 0.03 deg.
    np.testing.assert_allclose(
        there.curve().lift(alpha), here.curve().lift(alpha), rtol=0, atol=2.0 * 10.0**-digits + 1e-9
    )


def test_columns_may_be_in_any_order_with_a_note_above(tmp_path):
    text = "# tunnel test 7\ndrag;moment;lift;angle [deg]\n1;0;0;0\n2;0;1;90\n"
    assert loaded(tmp_path, text).lift == (0.0, 1.0)
    assert loaded(tmp_path, text).angle_deg == (0.0, 90.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (
            curve_text(TURN, "angle,lift,drag,moment"),
            r"column 'angle' must say the unit; call it angle_deg or angle_rad",
        ),
        (
            curve_text(TURN, "angle [grad],lift,drag,moment"),
            r"column 'angle \[grad\]' must say the unit",
        ),
        (
            curve_text([math.radians(deg) for deg in TURN], degrees=TURN),
            r"cover 6.283 deg in 37 rows, as a turn in radians does; call the column angle_rad",
        ),
        (
            curve_text([*TURN, 360.0]),
            r"rows 38 and 39 both give angle_deg = 360; remove one of them",
        ),
        (
            curve_text(TURN, "angle_rad,lift,drag,moment"),
            r"more than a turn",
        ),
        (
            curve_text([a for a in TURN if not 90 < a < 180]),
            r"no coefficients between 90 and 180 deg: a gap of 90 deg .* median step is 10 deg",
        ),
        (
            curve_text(TURN).replace("360.0,-0.000000", "360.0,0.500000"),
            r"lift is 0 at 0 deg and 0.5 at 360 deg, the same angle; make them equal",
        ),
        ("angle_deg,angle_rad,lift,drag,moment\n0,0,0,1,0\n", "it has 'angle_rad'"),
    ],
)
def test_a_curve_that_cannot_be_meant_is_refused(tmp_path, text, words):
    (tmp_path / "curve.csv").write_text(text)
    with pytest.raises(gf.SceneError, match=words):
        gf.Scene.from_dict(
            {
                **gf.load_scene("example3").model_dump(exclude_none=True, exclude={"sources"}),
                "aerodynamics": {"kind": "table", "file": "curve.csv"},
            },
            tmp_path,
        )


def test_missing_rows_are_warned_of(tmp_path):
    narrow = loaded(tmp_path, curve_text([a for a in TURN if not 90 < a < 130]))
    assert narrow.beyond == "periodic"
    (warning,) = narrow.warnings()
    assert "no values between 90 and 130 deg (median step: 10 deg)" in warning

    open_turn = loaded(tmp_path, curve_text(TURN[:-2]))
    assert open_turn.beyond == "error"
    (warning,) = open_turn.warnings()
    assert "covers all but 20 deg of a turn" in warning
    assert loaded(tmp_path, curve_text(TURN[:10])).warnings() == []


def test_the_last_angle_of_a_turn_may_be_rounded(tmp_path):
    (tmp_path / "curve.csv").write_text(curve_text([*TURN[:-1], 359.9], degrees=TURN))
    assert read_curve(tmp_path / "curve.csv").columns["angle_deg"][-1] == 360.0
    (tmp_path / "curve.csv").write_text(curve_text([0.0, 90.0, 180.0, 270.0, 359.0]))
    assert read_curve(tmp_path / "curve.csv").columns["angle_deg"][-1] == 359.0


def test_a_curve_in_radians_is_taken_beside_line_data(tmp_path):
    degrees = TURN[:-1]
    radians = [f"{math.radians(deg):.5f}" for deg in degrees]
    (tmp_path / "ice.csv").write_text(curve_text(radians, "angle_rad,lift,drag,moment", degrees))
    line = {
        "conductor": "Drake",
        "span": 300.0,
        "stringing_percent": 20.0,
        "ice_thickness": 0.01,
        "wind_speed": 5.0,
        "coefficients": "ice.csv",
    }
    scene = gf.Scene.from_dict({"line": line}, tmp_path)
    assert scene.aerodynamics.beyond == "periodic"
    assert scene.aerodynamics.angle_deg[-1] == pytest.approx(350.0, abs=1e-3)
    held = gf.Scene.from_dict({"line": line, "aerodynamics": {"outside": "hold"}}, tmp_path)
    assert held.aerodynamics.beyond == "hold"


def test_coarse_steps_are_warned_of():
    coefficients = {"kind": "table", "angle_deg": [0.0, 60.0, 120.0], "lift": [0.0, 1.0, 0.0]}
    coefficients |= {"drag": [1.0] * 3, "moment": [0.0] * 3}
    curve = {"aerodynamics": coefficients, "ice.attack_angle_deg": 20.0}
    scene = gf.load_scene("example3").with_values(curve)
    assert any("steps of up to 60 deg" in each for each in scene.warnings)
