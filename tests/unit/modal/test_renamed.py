"""Old names of public functions, arguments and options work for one release, with a warning."""

import dataclasses
from types import SimpleNamespace

import numpy as np
import pytest
from typer.testing import CliRunner

import gallop_fmu as gf
import modal
from modal.cli.main import app

OVER = {"wind.speed": [5.0]}


@pytest.mark.parametrize(
    ("old", "new"), [("way_out", "suggest_design_changes"), ("Parting", "Divergence")]
)
def test_old_names_of_the_package(old, new):
    with pytest.warns(DeprecationWarning, match=rf"modal\.{old} is now called {new}") as caught:
        assert getattr(modal, old) is getattr(modal, new)
    assert caught[0].filename == __file__
    assert old not in modal.__all__


def test_old_names_in_a_comparison():
    divergence = modal.Divergence("linear", "u2", 0.2, None, 3.0)
    comparison = modal.Comparison(*(None,) * 3, linear_modes=(), divergences=(divergence,))
    with pytest.warns(DeprecationWarning, match=r"Comparison\.partings is now called divergences"):
        assert comparison.partings == (divergence,)
    with pytest.warns(DeprecationWarning, match=r"Comparison\.parting is now called divergence"):
        assert comparison.parting("linear", "u2", 0.2) is divergence


def test_old_name_in_a_screening():
    values = dict.fromkeys(field.name for field in dataclasses.fields(modal.Screening))
    found = modal.Screening(**{**values, "antisymmetric_growth": 1.01})
    with pytest.warns(DeprecationWarning, match="lopsided_growth is now called antisymmetric_gr"):
        assert found.lopsided_growth == 1.01


def test_old_name_in_a_mode():
    wave = np.array([0.0, 1.0, 0.5, 0.0])
    values = dict.fromkeys(field.name for field in dataclasses.fields(modal.Mode))
    mode = modal.Mode(**{**values, "wave": wave})
    with pytest.warns(DeprecationWarning, match=r"Mode\.own_image is now called symmetric_share"):
        assert mode.own_image == pytest.approx(0.9)  # 1/2 + (2 0.5)/(2 1.25)


def test_old_argument_of_screen_spans():
    scene = gf.load_scene("example3").with_values({"numerics.elements": 8})
    with pytest.warns(DeprecationWarning, match=r"\(first_look=\.\.\.\) is now called estimate_"):
        old = modal.screen_spans(scene, OVER, first_look=True, workers=1)
    new = modal.screen_spans(scene, OVER, estimate_only=True, workers=1)
    assert old.dataset.estimated_onset.values == new.dataset.estimated_onset.values


def test_old_option_of_the_command(monkeypatch):
    asked = []
    runs = SimpleNamespace(total=0, done=0, failed=None, dataset=None)
    monkeypatch.setattr(
        "modal.screening.many_spans.screen_spans",
        lambda *_, **options: asked.append(options["estimate_only"]) or runs,
    )
    words = ["screen", "example3", "--over", "wind.speed=5", "--first-look"]
    done = CliRunner().invoke(app, words)
    assert asked == [True]
    assert "--first-look is now called --estimate-only" in done.stderr
    assert "--first-look" not in CliRunner().invoke(app, ["screen", "--help"]).stdout
