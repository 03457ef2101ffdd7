"""The HTML report: well-formed, self-contained, complete, escaped; it lists what is missing."""

import json
import re
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser

import numpy as np
import pytest
from matplotlib.figure import Figure
from typer.testing import CliRunner

import gallop_fmu as gf
import modal
from gallop_fmu.cli.main import app as fmu_app
from modal.cli.main import app
from modal.report.findings import Missing, examine, static_equilibrium
from modal.report.page import page
from modal.report.plots import outermost, svg
from modal.report.tables import source_of, value_text

QUICK = {"numerics.elements": 6, "numerics.time_step": 0.02, "run.record_every": 2}
VOID = {"meta", "input", "br"}
CALM = {"wind.speed": 0.0, "aerodynamics": "none"}
EVIL = '<script>alert("1")</script> & "5 < 6"'


class Page(HTMLParser):
    """Checks the nesting of a page and collects what the tests ask for."""

    def __init__(self, text):
        super().__init__()
        self.open, self.ids, self.addresses, self.scripts, self.cells, self.text = (
            [],
            [],
            [],
            0,
            [],
            "",
        )
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        given = dict(attrs)
        self.ids += [given["id"]] if "id" in given else []
        self.addresses += [
            value
            for name, value in attrs
            if name in ("src", "href", "xlink:href", "srcset", "action")
        ]
        self.scripts += tag == "script"
        if tag not in VOID:
            self.open.append(tag)
        if tag == "tr":
            self.cells.append([])
        if tag in ("td", "th"):
            self.cells[-1].append("")

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        self.handle_endtag(tag)

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("script", "style"):
            self.text += data
        if {"td", "th"} & set(self.open):
            self.cells[-1][-1] += data


@pytest.fixture(scope="module")
def full():
    """Example 3 on a coarse mesh, with all sections of the report."""
    scene = gf.load_scene("example3").with_values(
        {**QUICK, "title": f"{EVIL} title", "description": EVIL}
    )
    scene = scene.model_copy(update={"sources": {**scene.sources, "wind.speed": f"{EVIL} source"}})
    findings = examine(scene, 20.0)
    return findings, page(findings)


@pytest.fixture
def unpainted(monkeypatch):
    """Pages without figures, which are the slow part."""
    monkeypatch.setattr("modal.report.plots.svg", lambda figure, name, width=None: "<svg></svg>")


@pytest.fixture(scope="module")
def calm(tmp_path_factory):
    """The bare line without wind and curve, from the command."""
    out = tmp_path_factory.mktemp("calm") / "calm.html"
    changes = [f"--set={key}={value}" for key, value in {**QUICK, **CALM}.items()]
    done = CliRunner().invoke(
        app, ["report", "zebra", "-o", str(out), "--stop-time", "2", *changes]
    )
    assert done.exit_code == 0, done.output
    assert f"wrote {out}" in done.stdout
    return out.read_text("utf-8")


def test_is_well_formed_with_each_identifier_once(full, calm):
    for text in (full[1], calm):
        found = Page(text)
        assert len(found.ids) == len(set(found.ids))
        for target in re.findall(r'(?:href="#|url\(#)([^")]+)', text):
            assert target in found.ids


def test_needs_nothing_else(full):
    _, text = full
    assert all(address.startswith("#") for address in Page(text).addresses)
    assert not re.search(
        r"https?://(?!www\.w3\.org/2000/svg)", text
    )  # the name of SVG is no address to fetch
    assert not re.search(r"@import|url\((?!#)", text)
    assert len(text) < 3e6


def test_every_value_of_the_scene_is_listed_with_unit_and_source(full):
    findings, text = full
    rows = [tuple(row) for row in Page(text).cells]
    numbers = findings.scene.numbers()
    assert len(numbers) > 30
    for path, (value, unit, meaning) in numbers.items():
        found = [row for row in rows if row[0] == path.split(".", 1)[1] and row[3:4] == (meaning,)]
        assert (value_text(value), "" if unit == "1" else unit) in [row[1:3] for row in found], path
        assert {row[4] for row in found} & {source_of(findings.scene, path), "as above"}, path


def test_text_from_files_is_escaped(full):
    _, text = full
    found = Page(text)
    assert "<script>alert" not in text
    # Frames, two of the animation, and what opens all tables for printing; not the title's.
    assert found.scripts == 4
    for place in ("title", "source"):
        assert f"{EVIL} {place}" in found.text


def test_values_are_those_of_the_functions(full):
    findings, text = full
    shown = " ".join(Page(text).text.split())
    pair, screening, midspan = findings.frequencies, findings.screening, findings.result.midspan()
    assert (
        f"vertical mode {pair.vertical_hz:.4f} Hz, horizontal {pair.horizontal_hz:.4f} Hz" in shown
    )
    assert f"Risk at 5.5 m/s: {screening.risk}. Reason: {screening.reason}" in shown
    assert f"{findings.onsets[1].wind_speed:.3f}" in shown
    assert f"{float(midspan.u2.max()):.4g}" in shown
    assert f"{findings.static_in_wind.sag:.4f}" in shown
    assert not isinstance(findings.modes_in_wind, Missing)
    assert "not computed" not in shown
    for label in ("static", "coefficients", "criteria", "screening", "histories"):
        assert f'id="{label}-' in text
        assert f'id="{label}-narrow-' in text


def test_frames_are_the_motion_of_the_run(full):
    findings, text = full
    frames = json.loads(re.search(r'id="frames">(.*?)</script>', text)[1])
    data, middle = findings.result.midspan(), frames["middle"]
    times = np.array(frames["time"])
    assert times[-1] == pytest.approx(20.0, abs=1e-9)
    expected = data.sel(time=times, method="nearest")
    height = np.array(frames["height"])[:, middle]
    assert np.allclose(
        height - findings.static_in_still_air.x[6, 1], expected.u2, atol=6e-5
    )  # rounded to 0.1 mm
    assert np.allclose(np.array(frames["across"])[:, middle], expected.u3, atol=6e-5)
    assert np.allclose(frames["twist"], expected.theta, atol=6e-5)


def test_without_wind_the_report_states_it(calm):
    shown = Page(calm).text
    for what in (
        "Static state in the mean wind",
        "Modes in the mean wind",
        "Risk of a swing",
    ):
        assert re.search(rf"{what}: not computed\.\s+The scene has no wind", shown)
    for what in ("Critical winds", "Stability criteria"):
        assert re.search(rf"{what}: not computed\.\s+the scene has no aerodynamics", shown)
    assert "The nonlinear simulation ran to its end: completed at 2 s" in shown
    assert "Nothing moves: the span stays in static equilibrium." in shown


def test_shows_why_a_part_is_refused(unpainted):
    scene = gf.load_scene("example3").with_values({**QUICK, "damping.translation": None})
    findings = examine(scene, 1.0)
    shown = Page(
        page(replace(findings, ellipses={**findings.ellipses, "Davison": Missing("no sag")}))
    ).text
    assert re.search(r"Critical winds: not computed\.\s+damping\.translation is not given", shown)
    assert re.search(r"Risk of a swing: not computed\.\s+the structural damping ratio", shown)
    assert re.search(r"Ellipse of Davison: not computed\.\s+no sag", shown)


def test_shows_a_run_up_to_its_early_end(tmp_path, unpainted):
    """The attack angle leaves a short curve; the command writes the page and returns 1."""
    changes = {"damping.translation": None, "initial.seed_vertical": 0.05}
    scene = gf.load_scene("example3").with_values(
        {
            **QUICK,
            **changes,
            "aerodynamics.valid_from_deg": 179.0,
            "aerodynamics.valid_to_deg": 181.0,
        }
    )
    scene.save(tmp_path / "short.toml")
    out = tmp_path / "report.html"
    ended = CliRunner().invoke(
        app, ["report", str(tmp_path / "short.toml"), "-o", str(out), "--stop-time", "60"]
    )
    assert ended.exit_code == 1, ended.output
    assert "left the validity range" in ended.stderr
    shown = Page(out.read_text("utf-8")).text
    assert re.search(
        r"The simulation ended early\.\s+At [\d.]+ s in element .*What to do: give a curve", shown
    )
    assert "Motion at mid-span" in shown


def test_a_span_that_cannot_start_has_a_page_all_the_same(tmp_path, unpainted):
    """Lifted by 5 m, the cable is compressed from the start."""
    changes = {**QUICK, "wind.speed": 0.0, "aerodynamics": None, "initial.seed_vertical": 5.0}
    path = modal.write_report(gf.load_scene("zebra").with_values(changes), tmp_path / "slack.html")
    shown = Page(path.read_text("utf-8")).text
    assert re.search(
        r"Simulation: not computed\.\s+At 0 s in element \d+ .* the cable went slack", shown
    )
    assert "There is no motion or no ellipse to compare." in shown
    assert "drop of mid-span below the chord" in shown


def test_the_command_of_0_1_0_names_its_replacement():
    said = CliRunner().invoke(
        fmu_app, ["report", "example3", "-o", "my page.html", "--stop-time", "5", "--help"]
    )
    assert said.exit_code == 2
    assert (
        said.stderr == "gallop-fmu: report is now a command of gallop-modal; run "
        "gallop-modal report example3 -o 'my page.html' --stop-time 5 --help\n"
    )


def test_gallop_fmu_works_where_another_modal_is_installed():
    """Another package of the same import name: where the report cannot be imported, a message."""
    other = "import sys, types; sys.modules['modal'] = types.ModuleType('modal'); "
    for program, words in (("gallop_fmu", ["--help"]), ("modal", ["report", "--help"])):
        command = [
            sys.executable,
            "-P",
            "-c",
            f"{other}from {program}.cli.main import main; main()",
            *words,
        ]
        done = subprocess.run(command, capture_output=True, text=True)
        if program == "gallop_fmu":
            assert done.returncode == 0, done.stderr
            assert "demo" in done.stdout
        else:
            assert done.returncode == 1
            assert "ModuleNotFoundError: No module named 'modal.cli'" in done.stderr


@pytest.mark.parametrize("name", ["report.pdf", "report"])
def test_refuses_another_format(tmp_path, name):
    with pytest.raises(gf.SceneError, match=r"must end in \.html or \.htm"):
        modal.write_report(gf.load_scene("zebra"), tmp_path / name)
    assert CliRunner().invoke(app, ["report", "zebra", "-o", str(tmp_path / name)]).exit_code == 2


def test_progress_names_each_part():
    progress = []
    scene = gf.load_scene("zebra").with_values({**QUICK, "wind.speed": 0.0, "aerodynamics": None})
    examine(scene, 1.0, lambda *words: progress.append(words))
    names = list(dict.fromkeys(name for name, _ in progress))
    assert names == ["static state", "modes", "frequency ratio", "critical winds", "simulation"]
    assert progress[-1] == ("simulation", 1.0)


def test_rest_in_wind_balances_the_drag():
    """A bare line: the towers carry the whole wind force, rho U^2 d CD s / 2."""
    scene = gf.load_scene("zebra")
    state = static_equilibrium(scene, 10.0)
    drag = 0.5 * 1.225 * 10.0**2 * 0.02862 * 1.0 * gf.Model(scene).equilibrium().length
    across = state.support_force[:, 2].sum()
    assert across == pytest.approx(drag, rel=5e-3)
    # The plane of the span leans as drag to weight, 1.753 N/m to 15.90 N/m.
    assert state.swing == pytest.approx(np.arctan2(1.75298, 15.9), rel=1e-2)


def test_outermost_points_are_the_corners():
    x, y = np.array([0.0, 1.0, 1.0, 0.0, 0.5, 0.9]), np.array([0.0, 0.0, 1.0, 1.0, 0.5, 0.9])
    assert sorted(outermost(x, y)) == [0, 1, 2, 3]


def test_a_page_rounds_coordinates_and_no_label():
    """A label 0.005 was shown as 0.01."""
    figure = Figure()
    axes = figure.subplots()
    axes.plot([0.0, 1.0], [0.0, 0.0123456])
    axes.set_yticks([0.0, 0.005, 0.0123])
    drawn = svg(figure, "small")
    labels = re.findall(r"<text[^>]*>([^<]*)</text>", drawn)
    assert {"0.0050", "0.0123"} <= set(labels)
    assert not re.search(r"\d\.\d{3}", re.sub(r">[^<]*<", "><", drawn))
