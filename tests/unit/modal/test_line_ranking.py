"""Ranked measures for lines: screened onsets and amplitudes beside critical winds and runs."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

import gallop_fmu as gf
import modal
from modal.cli.main import app
from modal.study import line_ranking
from modal.study.ranked import Effect, Ranked, place_of
from modal.study.verification import effect_on_line
from support.galloping_lines import section_of_example2

DAMPED = {
    "damping.translation": {
        "low_ratio": 0.004,
        "low_frequency": 0.3,
        "high_ratio": 0.004,
        "high_frequency": 0.6,
    },
    "wind.speed": 3.0,
}
PHASES = [{"name": "top", "offset": [3.0, 0.0]}, {"name": "bottom", "offset": [0.0, 0.0]}]


def only(monkeypatch, *words):
    """Try only the measures whose names contain one of the words."""
    every = line_ranking.measures
    monkeypatch.setattr(
        line_ranking,
        "measures",
        lambda *given: [one for one in every(*given) if any(word in one.name for word in words)],
    )


def run_of(line, spans):
    """Amplitudes by span of a run from a small start."""
    seeded = line.with_values({"initial.seed_vertical": 0.3})
    result = gf.simulate(seeded, stop_time=1200.0, record_every=4)
    return [
        max(
            result.steady(window=100.0, span=span, phase=phase)["u2"].amplitude
            for phase in range(1, len(line.phases) + 1)
        )
        for span in range(1, spans + 1)
    ]


def test_measures_of_a_section(monkeypatch, tmp_path):
    """Amplitudes of runs: 0.7 % from the screening, which has other steps; onsets 1e-5."""
    only(monkeypatch, "damper", "Split", "interphase")
    section = section_of_example2(2, elements=4).with_values(DAMPED)
    names = list[str]()
    found = modal.rank_measures(section, progress=names.append)
    damper, split, spacers = found.rows
    assert [row.verified_by for row in found.rows] == ["screening", "screening", ""]
    assert names[1].startswith("1 of 3: ")
    assert math.isinf(damper.after.onset)
    assert damper.after.largest < 1e-9
    assert "galloping from no wind of the range" in repr(found)
    # galloping at 0.556 Hz, and a twentieth of the modal mass
    (one, other) = damper.measure.scene.devices
    tuned = math.sqrt(one.hanging_stiffness / one.hanging_mass) / (2.0 * math.pi)
    assert tuned == pytest.approx(0.556 / 1.05, rel=5e-3)
    assert other.span == 2
    assert "give all of them as [[phases]]" in spacers.reason
    critical = modal.critical_wind_speed(split.measure.scene, 8, 4.5)
    lowest = min(one.wind_speed for one in critical if one.wind_speed is not None)
    assert split.after.onset == pytest.approx(lowest, rel=1e-4)
    assert split.after.by_span == pytest.approx(run_of(split.measure.scene, 3), rel=0.03, abs=2e-3)
    assert split.after.largest == pytest.approx(max(split.after.by_span))
    assert split.before.onset == found.screening.galloping_from
    data = found.dataset
    assert data.vertical_by_span_after.dims == ("measure", "span")
    assert found.save(tmp_path / "a.nc").stat().st_size
    monkeypatch.setattr("modal.study.ranking.rank_measures", lambda *_, **__: found)
    path = tmp_path / "section.toml"
    path.write_text(section.to_toml())
    shown = CliRunner().invoke(app, ["measures", str(path), "-o", str(tmp_path / "a.csv")])
    assert shown.exit_code == 0, shown.output
    sizes = ", ".join(f"{size:.3f}" for size in split.after.by_span)
    assert f"by span {sizes} m" in shown.stdout
    content = json.loads(CliRunner().invoke(app, ["measures", str(path), "--json"]).stdout)
    assert len(content["measures"][1]["after"]["by_span"]) == 3


@pytest.fixture(scope="module")
def two_phases():
    return section_of_example2(1, elements=6, phases=PHASES).with_values(DAMPED)


def test_interphase_spacers_are_screened(monkeypatch, two_phases):
    """Observed: 4e-6 of the onset, 0.1 % of the amplitude."""
    only(monkeypatch, "interphase")
    (row,) = modal.rank_measures(two_phases).rows
    line = row.measure.scene
    assert (row.verified_by, row.reason, len(line.phases)) == ("screening", "", 2)
    critical = modal.critical_wind_speed(line, 8, 4.5)
    lowest = min(one.wind_speed for one in critical if one.wind_speed is not None)
    assert row.after.onset == pytest.approx(lowest, rel=1e-4)
    assert row.after.largest == pytest.approx(run_of(line, 1)[0], rel=0.01)


def test_lines_with_too_many_phases_are_simulated(monkeypatch, two_phases):
    """As by the screening: 2.442 m/s, 0.688 m in place of 0.706 m."""
    monkeypatch.setattr(line_ranking, "MAX_MODES", 7)
    only(monkeypatch, "interphase")
    windy = two_phases.with_values({"wind.speed": 3.6})
    (row,) = modal.rank_measures(windy, 4.5).rows
    assert row.verified_by == "simulation"
    assert "2 phases that move together in 1 spans have more modes" in row.reason
    assert row.after.onset == pytest.approx(2.441645, rel=1e-6)  # of `critical_wind_speed`
    assert row.after.largest == pytest.approx(0.688, rel=0.01)
    assert row.before.largest == pytest.approx(0.706, rel=0.01)
    (short,) = modal.rank_measures(windy, 4.5, stop_time=60.0).rows
    assert short.after.is_at_least
    assert "not steady: " in short.reason


def test_order_of_measures():
    """First no galloping at all, then the size; unsure and unknown ones are last."""

    def row(by, *effect, **more):
        after = Effect(effect[0], largest=effect[1], **more)
        return Ranked(None, Effect(), Effect(), after, by, 0.0, 0.0, "")

    rows = [
        row("screening", math.inf, 0.3),
        row("screening", 6.0, 0.2),
        row("screening", 5.0, 0.2),
        row("screening", 5.0, 0.0, turns_over=True),
        row("simulation", 5.0, 0.05, is_at_least=True),
        row("screening", 5.0, 0.1, is_at_least=True),
        row("screening", 5.0, math.nan),
    ]
    rng = np.random.default_rng(3)
    for _ in range(5):
        mixed = [rows[k] for k in rng.permutation(len(rows))]
        assert sorted(mixed, key=place_of) == rows


def test_amplitudes_by_span_are_those_of_the_phase_that_moves_most():
    """Two spans with three phases; peak to peak in the screening, amplitudes in the effect."""
    tall = ((0.2, 0.4, 0.6, 1.0, 0.8, 0.1), (0.0, 0.9, 0.0, 0.0, 0.0, 0.0))
    states = [
        SimpleNamespace(
            peak_to_peak=sizes,
            vertical=sizes,
            horizontal=(0.1,),
            largest=0.5,
            is_turned_over=sizes[0] == 0.0,
        )
        for sizes in tall
    ]
    onsets = [SimpleNamespace(wind_speed=speed) for speed in (3.0, 2.0)]
    given = {"onsets": onsets, "onset_wind_speed": None, "states": states, "unresolved": ()}
    given |= {"unresolved_states": ()}
    found = effect_on_line(SimpleNamespace(**given), 2)
    assert found.by_span == pytest.approx((0.45, 0.5))
    assert (found.onset, found.swing, found.is_at_least) == (2.0, math.inf, False)
    assert found.turns_over
    given |= {"states": states[:1], "unresolved_states": ("it had not settled",)}
    unsure = effect_on_line(SimpleNamespace(**given), 2)
    assert (unsure.is_at_least, unsure.turns_over) == (True, False)
    given |= {"onsets": [], "states": [], "unresolved": ("rest was lost",)}
    lost = effect_on_line(SimpleNamespace(**given), 2)
    assert math.isnan(lost.onset)
    assert not lost.is_known
