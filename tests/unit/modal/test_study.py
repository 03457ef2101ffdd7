"""The study of a line: cases and their counts, worst case, gaps, measures, verdict, page."""

import math
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import gallop_fmu as gf
from gallop_fmu import SceneError
from gallop_fmu.line.section_table import section_data
from gallop_fmu.simulation.clearance import Ellipse
from modal.cli.main import app
from modal.foundation.alike_phases import one_phase
from modal.report import line_findings, line_page
from modal.report.findings import Missing
from modal.stability.critical_wind import critical_wind_speed
from modal.study import cases as cases_module
from modal.study import command, gaps
from modal.study import page as page_module
from modal.study import study as study_module
from modal.study.cases import Variant, case_row, reached, run_cases
from modal.study.conditions import StudyConditions, StudyLimits, with_ice
from modal.study.governing_span import branches_of_span, governing_span
from modal.study.page import Signature, study_page
from modal.study.study import LineStudy, largest_of, study_line
from modal.study.verdict import answers
from support.two_spans import PHASES, smooth_curve, two_spans

WINDS, ANGLES = (1.0, 6.0, 8.0), (0.0, 90.0)
OFFSETS = ((0.0, 0.0), (7.0, 0.0))


@pytest.fixture(scope="module")
def scene():
    return two_spans()


def only_missing(*_):
    """Stand for a part that takes seconds and has its own test."""
    raise SceneError("left out by the test")


@pytest.fixture(scope="module")
def study(scene):
    conditions = StudyConditions(winds=WINDS, angles_deg=ANGLES)
    limits = StudyLimits(1.0, string_pull=1500.0)
    with pytest.MonkeyPatch.context() as patch:  # a short search: it has its own tests
        patch.setattr(
            line_findings, "critical_wind_speed", lambda line, n, _: critical_wind_speed(line, n, 2)
        )
        patch.setattr(study_module, "branches_of_span", only_missing)
        return study_line(scene, conditions, limits=limits, workers=2)


def test_every_combination_is_one_case(study):
    found = [(case.wind, case.angle_deg) for case in study.cases]
    assert sorted(found) == sorted((wind, angle) for wind in WINDS for angle in ANGLES)
    assert study.is_single  # nothing connects the phases


def test_galloping_follows_den_hartog(study):
    """At 90 deg lift and drag damp; at 0 deg it gallops above the critical wind of 0.7 m/s."""
    assert {case.angle_deg for case in study.galloping} == {0.0}
    assert {case.wind for case in study.galloping} == {6.0, 8.0}
    by_angle = {found.angle_deg: found.wind for found in study.criteria}
    assert by_angle[90.0] is None
    assert 0.0 < by_angle[0.0] < 6.0


def test_a_case_is_a_simulation(scene, study):
    """Motion, forces and tension of the worst case are those of `simulate`."""
    worst = study.worst
    assert worst.largest == max(case.largest for case in study.cases)
    assert (worst.wind, worst.angle_deg) == (8.0, 0.0)
    alone = one_phase(scene).with_values({"wind.speed": 8.0, "ice.attack_angle_deg": 0.0})
    result = gf.simulate(alone, record_nodes="all")
    spans = result.spans.set_index("span")
    for span in (1, 2):
        expected = 2.0 * spans.u2_amplitude[span]
        assert worst.peak_to_peak[span - 1] == pytest.approx(expected, rel=1e-12)
    tower = result.towers.set_index("tower").loc[1]
    most = max(abs(tower.force_x1_min), abs(tower.force_x1_max))
    assert worst.most("force_x1", inner=True) == pytest.approx(most, rel=1e-12)
    assert worst.towers["tower_preload_x2"][1] == pytest.approx(tower.preload_x2, rel=1e-12)


def test_the_motion_is_that_at_the_end(scene):
    """A motion that decays: the window of 100 s counts, not the last half of the run, 150 s.

    A section that turned over, in the first 20 s after the start: its largest motion counts.
    """
    alone = one_phase(scene).with_values({"initial.seed_vertical": 0.4})
    (case,) = run_cases(
        [Variant(alone, "", "")], [(1.0, 90.0)], offsets=[(0.0, 0.0)], stop_time=300
    )
    still = alone.with_values({"wind.speed": 1.0, "ice.attack_angle_deg": 90.0})
    result = gf.simulate(still, 300.0, record_nodes="all")
    amplitude = result.spans.set_index("span").u2_amplitude
    assert case.peak_to_peak == pytest.approx(2.0 * amplitude.values, rel=1e-12)
    assert reached(result, 1, 1) > 1.5 * case.peak_to_peak[0]  # found: 2.1


def test_a_section_that_turned_over_gallops_for_a_time(tmp_path):
    """A Drake with 15 mm of ice moves most before it turns over."""
    (tmp_path / "towers.csv").write_text(
        "tower,span length,string length,string weight\nT1,280,,\nT2,350,2.4,600\nT3,,,\n"
    )
    data = {"conductor": "Drake", "stringing_percent": 20.0, "ice_thickness": 0.015}
    data |= {"section": str(tmp_path / "towers.csv"), "wind_speed": 8.0, "attack_angle_deg": -10.0}
    line = gf.LineScene.from_dict(section_data(data, Path()))
    (case,) = run_cases([Variant(line, "", "")], [(8.0, -10.0)], offsets=OFFSETS, stop_time=200.0)
    result = gf.simulate(line, 200.0, record_nodes="all")
    late = result.dataset.time.values > 20.0
    whole = [np.ptp(result.bundle(span)["u2"].values[late]) for span in (1, 2)]
    assert case.kind == "turned over"
    assert np.all(case.lasting < 0.75 * case.peak_to_peak)  # found: 1.2 of 1.7 m, 1.0 of 1.6 m
    assert np.all((0.8 * np.array(whole) < case.peak_to_peak) & (case.peak_to_peak <= whole))
    assert case.smallest_gap == pytest.approx(
        OFFSETS[1][0] - max(whole), abs=0.3
    )  # found: 5.30 of 5.30
    assert case.gallops
    assert not case.gallops_for_a_time
    assert replace(case, lasting=0.0 * case.lasting).gallops_for_a_time


def test_one_phase_moves_as_all_do(scene, study):
    """The phases have nothing in common, so two of them move as one alone."""
    variant = Variant(scene, "", "")
    (both,) = run_cases([variant], [(8.0, 0.0)], offsets=[(0.0, 0.0), (3.0, 0.5)])
    assert both.peak_to_peak == pytest.approx(study.worst.peak_to_peak, rel=1e-7)
    assert both.gap == pytest.approx(study.worst.gap, abs=1e-6)  # Newton's tolerance


def test_gaps_of_circles_and_ellipses():
    angle = np.linspace(0.0, 2.0 * math.pi, 721)
    circle = gaps.support(2.0 * np.sin(angle), 2.0 * np.cos(angle))
    assert gaps.gap(circle, circle, np.array([3.0, 4.0])) == pytest.approx(1.0, abs=5e-4)
    assert gaps.gap(circle, circle, np.array([0.0, 3.0])) == pytest.approx(-1.0, abs=5e-4)
    x3, x2 = Ellipse(4.0, 1.0, 1.0, 0.3).outline(2001)
    area = gaps.support(x2, x3)
    points = np.stack([x2, x3], axis=1)[::5]
    apart = points[:, None] - (points + np.array([1.0, 3.0]))[None, :]
    least = float(np.sqrt((apart**2).sum(axis=-1)).min())
    assert gaps.gap(area, area, np.array([1.0, 3.0])) == pytest.approx(least, abs=2e-3)


def test_gap_of_the_study_is_that_of_the_paths(study):
    """The closest points of two paths are not closer than the areas, which their corners span."""
    worst, result = study.worst, study.findings.result
    start, stop = result.window()
    part = result.bundle(1).sel(time=slice(start - 1e-9, stop + 1e-9))
    path = np.stack([part.u2.values, part.u3.values], axis=1)
    apart = path[:, None] - (path + np.array([3.0, 0.5]))[None, :]
    least = float(np.sqrt((apart**2).sum(axis=-1)).min())
    assert worst.smallest_gap <= least + 1e-3
    assert (worst.smallest_gap <= 0.0) == ("clash" in answers(study)[3].answer)


def test_measures_are_ranked_by_what_remains(study):
    largest = [each.largest for each in study.tried if each.largest == each.largest]
    assert largest == sorted(largest)
    assert len(largest) >= 4
    assert all(len(each.cases) == len(study.before) for each in study.tried if each.measure.scene)
    best = study.tried[0]
    change = answers(study)[6].answer
    assert best.measure.name in change or "None of" in change
    assert largest_of(study.before) == study.worst.largest


def test_the_screening_of_the_worst_case_is_said(study):
    """Onsets, states, swing and doubts; and a case that gallops where rest is stable."""
    found = study.findings.screening
    assert found.risk == "certain"
    assert found.wind_speed == study.worst.wind
    begin, height, swing = (answers(study)[number] for number in (1, 2, 5))
    assert f"motions begin on rest: {found.onsets[0]}" in " ".join(begin.evidence)
    assert "disagree" not in " ".join(begin.evidence)
    assert any(str(found.states[0]) in text for text in height.evidence)
    assert swing.answer.startswith("Yes: by the screening, galloping starts a swing")

    late = tuple(replace(one, wind_speed=7.5) for one in found.onsets)
    calm = replace(found, risk="detuned", onsets=late, transitions=(), unresolved=("why",))
    other = replace(study, findings=replace(study.findings, screening=calm))
    begin, _, swing = (answers(other)[number] for number in (1, 2, 5))
    assert "disagree: a case gallops at 6 m/s" in " ".join(begin.evidence)
    assert "found no swing" in swing.evidence[0]
    assert "Unresolved by the screening: why." in swing.evidence[0]
    turned = replace(calm, risk="turns over", divergence_from=5.0, unresolved=())
    other = replace(study, findings=replace(study.findings, screening=turned))
    assert (
        "By the screening, no swing starts, but a span turns over: rest is statically unstable from"
        " 5 m/s (divergence)."
    ) in answers(other)[5].evidence
    gone = replace(study, findings=replace(study.findings, screening=Missing("no wind.")))
    assert "The screening is missing: no wind." in answers(gone)[5].evidence


def test_the_worst_case_is_started_once_more_unequally(study):
    """A push of the spans grows faster than the seed: 6.9 m in place of 3.5 m in these 60 s."""
    other, worst = study.unequal, study.worst
    assert (other.wind, other.angle_deg, other.ice) == (worst.wind, worst.angle_deg, worst.ice)
    assert other.largest > 1.5 * worst.largest
    height = answers(study)[2]
    assert height.answer.startswith(f"Up to {other.largest:.1f} m")
    assert f"moves by {other.largest:.2f} m, and by {worst.largest:.2f} m" in height.evidence[1]

    alike = replace(other, peak_to_peak=worst.peak_to_peak)
    height = answers(replace(study, unequal=alike))[2]
    assert height.answer.startswith(f"Up to {worst.largest:.1f} m")
    assert f"moves by {worst.largest:.2f} m, which is not more." in height.evidence[1]
    assert "may be missing" in answers(replace(study, unequal=None))[2].evidence[1]


@pytest.fixture
def _unexamined(monkeypatch):
    """Leave out modes, pairs and critical winds of the worst case, which take seconds."""
    monkeypatch.setattr(study_module, "examine_line", lambda *_: Missing("left out by the test"))


@pytest.mark.usefixtures("_unexamined")
def test_cases_that_left_the_curve_are_counted(scene):
    """A curve from -15 to 15 deg ends large motions early: their motion is a lower bound."""
    short = scene.with_values({"aerodynamics": smooth_curve(to=15), "phases": PHASES[:1]})
    short = short.with_values({"initial.seed_vertical": 0.4})
    found = study_line(
        short, StudyConditions(winds=(4.0, 40.0), angles_deg=(0.0, 60.0)), stop_time=40.0
    )
    kinds = {(case.wind, case.angle_deg): case.kind for case in found.cases}
    assert kinds[4.0, 0.0] == "left the curve"
    assert kinds[4.0, 60.0] == kinds[40.0, 60.0] == "failed"  # outside of the curve at the start
    said = {each.question: each for each in answers(found)}
    assert "2 left the curve, 2 have no result" in said["How sure is this?"].answer
    assert "at least" in said["How high?"].answer
    assert said["Do phases clash or flash over?"].answer.startswith("Not examined")


def test_no_result_at_all_is_said(scene):
    far = scene.with_values({"aerodynamics": smooth_curve(to=30), "phases": PHASES[:1]})
    found = study_line(far, StudyConditions(winds=(4.0,), angles_deg=(90.0,)))
    assert found.worst is None
    assert isinstance(found.findings, Missing)
    assert answers(found)[0].answer == "Not known: no case has a result."
    assert "Worst case: not computed." in study_page(found, Signature())


def test_ice_of_a_thickness_replaces_the_ice(scene):
    """A crescent of 10 mm: mass rho pi r t / 2, first moment 2/3 rho r ((r + t)^2 - r^2)."""
    iced = with_ice(scene.with_values({"ice.attack_angle_deg": 30.0}), 0.01, "crescent", 900.0).ice
    r, t = 0.0143, 0.01
    assert iced.mass_per_length == pytest.approx(900.0 * math.pi * r * t / 2.0)
    first = 900.0 * 2.0 / 3.0 * r * ((r + t) ** 2 - r**2)
    assert iced.first_moments() == pytest.approx((0.5 * first, -math.sqrt(0.75) * first))


def test_design_values_are_compared(study):
    """The pull at rest is 2.4 kN (half of each span and of the string), above the 1.5 kN."""
    said = answers(study)[4]
    assert said.answer.endswith("design values are exceeded.")
    assert said.level == "bad"
    pulls = [case.most("pull", inner=True) for case in study.known]
    count = sum(pull > 1500.0 for pull in pulls)
    assert f"design value is 1.5 kN, exceeded in {count} cases" in said.evidence[0]
    assert f"up to {max(pulls) / 1e3:.1f} kN" in said.evidence[0]


def test_an_assumed_curve_follows_the_ice(scene):
    """The curve of the scene or of the option is that of each thickness, and called assumed."""
    own = scene.with_values({"aerodynamics": {"kind": "assumed", "ice_thickness_ratio": 0.1}})
    for line, curves in ((own, ()), (scene, ("assumed",))):
        found = list(StudyConditions(ices=(0.00572, 0.0143), curves=curves).climates(line))
        ratios = [each.scene.aerodynamics.ice_thickness_ratio for each in found]
        assert ratios == pytest.approx([0.2, 0.5])
        assert all(each.source.startswith("ASSUMED") for each in found)
    (unchanged,) = StudyConditions().climates(own)
    assert unchanged.scene.aerodynamics.ice_thickness_ratio == 0.1
    with pytest.raises(SceneError, match="give --ice, too"):
        list(StudyConditions(curves=("assumed",)).climates(scene))


def test_wrong_conditions_are_refused(scene):
    with pytest.raises(SceneError, match="clearance = 0 m: must be greater than 0"):
        StudyLimits(clearance=0.0)
    for wrong, message in (
        ({"winds": ()}, "no wind speed"),
        ({"ices": (10.0,)}, "at most 0.2 m"),
        ({"winds": (4.0, 4.0)}, "given twice"),
        ({"ices": (0.0,)}, "greater than 0"),
    ):
        with pytest.raises(SceneError, match=message):
            StudyConditions(**wrong)
    with pytest.raises(SceneError, match="a study takes a line"):
        study_line(gf.load_scene("example3"))
    with pytest.raises(SceneError, match="neither a CSV file nor a packaged"):
        study_line(scene, StudyConditions(curves=("nowhere",)))
    with pytest.raises(SceneError, match="no coefficient curve"):
        study_line(scene.with_values({"wind.speed": 0.0, "aerodynamics": None}))


def test_the_page_answers_in_order(study, monkeypatch):
    monkeypatch.setattr(line_page, "_pictures", lambda _: [])  # other tests draw them
    text = study_page(study, Signature("A. <Author>", 'Line "7"', "B"))
    names = ("verdict", "charts", "evidence", "motion", "modes", "critical", "scene")
    places = [text.index(f'<section id="{name}">') for name in names]
    assert places == sorted(places)
    questions = [each.question for each in answers(study)]
    assert [text.index(f"<h3>{question}") for question in questions] == sorted(
        text.index(f"<h3>{question}") for question in questions
    )
    assert "A. &lt;Author&gt;" in text
    assert "two &lt;spans&gt;" in text
    assert "two <spans>" not in text
    assert "counter(page)" in text
    assert text.count("<figure") == 9  # with the shapes of the modes and the two of the animation
    assert "NaN" not in text
    assert " nan " not in text


@pytest.mark.usefixtures("_unexamined")
def test_the_command_writes_the_page(scene, tmp_path):
    scene.with_values({"phases": PHASES[:1], "run.stop_time": 10.0}).save(tmp_path / "line.toml")
    line, page = str(tmp_path / "line.toml"), str(tmp_path / "s.html")
    options = ["--wind", "4:6:2", "--angle", "0", "--ice", "5", "--author", "N. N."]
    made = CliRunner().invoke(app, ["study", line, *options, "-o", page])
    assert made.exit_code == 0, made.output
    assert "Will it gallop?" in made.output
    assert "N. N." in (tmp_path / "s.html").read_text()
    for wrong, message in (
        (["--wind", "4:x"], "--wind 4:x: a range is FIRST:LAST:STEP"),
        (["--ice", "a"], "'a' is not a number"),
        (["--ice-shape", "square"], "square"),
    ):
        refused = CliRunner().invoke(app, ["study", line, *wrong, "-o", page])
        assert refused.exit_code == 2
        assert message in refused.output


@pytest.mark.usefixtures("_unexamined")
def test_a_run_that_still_grows_is_not_called_calm(scene):
    """After 6 s the motion is small and grows: the answer is neither yes nor no."""
    alone = scene.with_values({"phases": PHASES[:1], "initial.seed_vertical": 0.001})
    found = study_line(alone, StudyConditions(winds=(6.0,), angles_deg=(0.0,)), stop_time=6.0)
    said = answers(found)[0]
    assert said.answer.startswith("Not within the simulated time")
    assert said.level == "open"


def test_a_table_of_towers_is_studied_at_once(tmp_path):
    (tmp_path / "towers.csv").write_text("tower,span length\nT1,300\nT2,\n")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study_module, "examine_line", lambda *_: Missing("left out by the test"))
        options = ["--section", str(tmp_path / "towers.csv"), "--conductor", "Drake"]
        options += ["--stringing-percent", "20", "--coefficients", "example2"]
        options += ["--ice", "5", "--wind", "4", "--stop-time", "2"]
        made = CliRunner().invoke(app, ["study", *options, "-o", str(tmp_path / "s.html")])
    assert made.exit_code == 0, made.output
    assert "Drake, section of 1 spans" in (tmp_path / "s.html").read_text()
    for wrong, message in (
        ([], "no line: give a scene file"),
        (["--conductor", "Drake"], "--conductor: line data need a table of towers"),
        (["x.toml", *options[:2]], "x.toml and --section are both given"),
    ):
        refused = CliRunner().invoke(app, ["study", *wrong, "-o", str(tmp_path / "t.html")])
        assert refused.exit_code == 2
        assert message in refused.output


@pytest.mark.usefixtures("_unexamined")
def test_a_stopped_study_is_reported_and_resumed(scene, tmp_path, monkeypatch):
    """Ctrl-C after two of four cases; the same command then computes the other two only."""
    scene.with_values({"run.stop_time": 4.0}).save(tmp_path / "line.toml")
    page = tmp_path / "s.html"
    options = [str(tmp_path / "line.toml"), "--wind", "4,6,8,9", "--workers", "1", "-o", str(page)]
    simulated = []

    def counted(result, offsets):
        simulated.append(result.scene.wind.speed)
        return case_row(result, offsets)

    def stop(name, share):
        if share == 0.5 and len(simulated) == 2:
            raise KeyboardInterrupt

    monkeypatch.setattr(cases_module, "case_row", counted)
    monkeypatch.setattr(command, "shown_parts", lambda _: nullcontext(stop))
    monkeypatch.setattr(page_module, "_pictures", lambda _: [])  # other tests draw and try them
    monkeypatch.setattr(study_module, "_measures", lambda *_: [])
    made = CliRunner().invoke(app, ["study", *options])
    assert made.exit_code == 1, made.output
    assert "Only 2 of 4 cases were simulated" in made.output
    text = page.read_text()
    assert "This study is incomplete." in text
    assert "2 of 2 simulated cases" in text or "none of 2 simulated cases" in text
    assert 'class="good"' not in text

    before = len(simulated)
    again = CliRunner().invoke(app, ["study", *options])
    assert again.exit_code == 0, again.output
    assert simulated[before : before + 2] == [8.0, 9.0]
    assert "This study is incomplete." not in page.read_text()


@pytest.mark.parametrize("subconductors", [1, 2])
def test_the_branches_are_those_of_the_span_alone(scene, subconductors):
    """Its motions begin where linear theory of the whole span has its critical winds."""
    values = {"ice.attack_angle_deg": 0.0, "wind.speed": 4.0, "section.gravity": 9.5}
    if subconductors == 2:
        values["bundle"] = {"subconductors": 2, "spacing": 0.4, "spacers": 2}
    alone = one_phase(scene).with_values(values)
    result = gf.simulate(alone, 0.1, record_nodes="all")
    found = branches_of_span(result, 2, (1.8, 2.0))
    data = found.dataset
    begins = data.value.values[data.event.values == "Hopf"]
    tension = float(result.spans.horizontal_tension.iloc[-1])
    span = governing_span(result.scene, 2, tension)
    whole = gf.simulate(span, 0.1, record_nodes="all")
    if subconductors == 1:
        assert (span.span.length, span.span.gravity) == (110.0, 9.5)
    else:  # the tension is that of the span in the section
        assert whole.spans.horizontal_tension.iloc[0] == pytest.approx(tension, rel=1e-4)
        assert whole.scene.bundle == alone.bundle
    onsets = [each.wind_speed for each in critical_wind_speed(span, 4, 2.2) if each.wind_speed]
    assert min(begins) == pytest.approx(min(onsets), rel=1e-6)  # found: 1e-9


def test_the_map_of_risk_counts_galloping_cases(study):
    """At 0 deg it gallops at 6 and 8 m/s, at 90 deg never: half of the cases there."""
    ices, share, texts = page_module._risk(study)
    assert len(ices) == 1
    assert share.tolist() == [[0.0, 50.0, 50.0]]
    assert [text.partition(",")[0] for text in texts[0]] == ["0 of 2", "1 of 2", "1 of 2"]
    assert texts[0][2].endswith(f", {study.worst.largest:.1f} m")


def test_study_is_public(study):
    assert isinstance(study, LineStudy)
