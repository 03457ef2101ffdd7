"""The command ``gallop-fmu curves``."""

import json
import math

import pytest

from gallop_fmu.scene.curve_catalogue import packaged_curves


def test_list_has_name_status_and_range(invoke):
    rows = {row["name"]: row for row in json.loads(invoke("curves", "--json").stdout)}
    assert set(rows) == {"assumed", *packaged_curves()}
    assert (rows["assumed"]["status"], rows["assumed"]["range_deg"]) == ("assumed", [-180.0, 180.0])
    assert rows["example2"]["status"] == "reconstructed"
    listed = invoke("curves").stdout
    for name, row in rows.items():
        assert name in listed
        assert row["status"] in listed


@pytest.mark.parametrize("name", ["assumed", *packaged_curves()])
def test_a_curve_is_described_with_source_and_limits(invoke, name):
    printed = invoke("curves", name, "--json")
    found = json.loads(printed.stdout)
    assert found["source"]
    assert found["validity"]
    assert found["den_hartog_unstable_deg"]
    assert any("not measured" in text for text in found["warnings"]) is (
        found["status"] != "published"
    )
    text = invoke("curves", name).output
    assert f"status: {found['status']}" in text
    assert found["source"] in text


def test_range_of_den_hartog_of_the_assumed_curve(invoke):
    # cos 2a > D (1 + s sin^2 a)/(2 L (1 - exp(-s/s0))), here with s = 0.1: below 30.7 deg.
    found = json.loads(invoke("curves", "assumed", "--thickness-ratio", "0.1", "--json").stdout)
    size = 1.25 * (1.0 - math.exp(-2.0))
    limit = math.degrees(math.asin(math.sqrt((2.0 * size - 1.0) / (4.0 * size + 0.1))))
    assert found["den_hartog_unstable_deg"][1] == pytest.approx([-limit, limit], abs=0.5)


def test_a_file_is_described_and_drawn(invoke, tmp_path):
    file, picture = tmp_path / "curve.csv", tmp_path / "curve.svg"
    file.write_text("angle_rad,lift,drag,moment\n-0.5,0.9,1,0\n0,0,1,0\n0.5,-0.9,1,0\n")
    result = invoke("curves", str(file), "--plot", str(picture))
    assert result.exit_code == 0
    assert "range: -28.6479 to 28.6479 deg; outside: an error" in result.stdout
    assert "CD + dCL/dalpha is negative: -28.6479" in result.stdout
    assert picture.read_text().count("<svg") == 1


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["nope"], "'nope': no curve has this name; there are assumed, example2"),
        (["no.csv"], "no.csv: no such file"),
        (["assumed", "--thickness-ratio", "5"], "ice_thickness_ratio = 5.0: must be"),
        (["--plot", "curve.png"], "--plot: needs the name of a curve"),
        (["example2", "--plot", "curve.gif"], "curve.gif"),
    ],
)
def test_what_cannot_be_shown_is_refused(invoke, words, message):
    result = invoke("curves", *words)
    assert result.exit_code == 2
    assert message in result.stderr


def test_new_without_coefficients_writes_the_word_assumed(invoke, tmp_path):
    scene = tmp_path / "mine.toml"
    words = "--conductor Drake --span 200 --stringing-percent 20 --ice-thickness 0.004"
    result = invoke("new", str(scene), *words.split(), "--wind-speed", "6")
    assert result.exit_code == 0
    assert "ASSUMED, not measured" in result.output
    assert 'kind = "assumed"' in scene.read_text()
    assert "ASSUMED, not measured" in scene.read_text()
    run = invoke("run", str(scene), "--stop-time", "2")
    assert run.exit_code == 0
    assert "ASSUMED, not measured" in run.output
