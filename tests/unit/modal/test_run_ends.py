"""Ends of simulations that start on a motion of a branch."""

import io
from types import SimpleNamespace

import numpy as np
import pytest
import xarray as xr
from rich.console import Console

from modal.cli.branches_command import _runs
from modal.motions.full_model import CYCLES_PER_WINDOW, RECORDS_PER_PERIOD, WINDOW, _end
from modal.motions.runs import PERIODS, BranchRun
from modal.motions.span_model import Watched
from modal.motions.table import _run_columns

COUNT = PERIODS // CYCLES_PER_WINDOW
TIME = np.linspace(0.0, 1.0, COUNT)


def end_of(u2, quarter):
    """End of a run with these amplitudes (window,) of one span at mid-span and quarter points."""
    wave = np.tile(np.cos(2.0 * np.pi * np.arange(WINDOW) / RECORDS_PER_PERIOD), len(u2))
    none = np.zeros((len(wave), 1))
    tall, wide = ((np.repeat(one, WINDOW) * wave)[:, None] for one in (u2, quarter))
    return _end(Watched(tall, none, none, wide, none[:, :0]), "")


def irregular(draw, mean=0.4):
    """Amplitudes that change at random every five windows."""
    return mean * np.repeat(draw.uniform(0.6, 1.4, COUNT // 5), 5)


def test_an_irregular_motion_has_its_name_and_range():
    """One in 15 looks like a beat (its largest amplitudes agree), one in 50 like a trend."""
    draw = np.random.default_rng(20261129)
    names = []
    for _ in range(60):
        sizes = irregular(draw)
        end = end_of(sizes, 0.1 + 0.0 * TIME)
        names.append(end.outcome)
        if end.outcome == "irregular":
            late = sizes[COUNT // 2 :]
            assert (end.u2.low, end.u2.high) == pytest.approx((late.min(), late.max()), rel=1e-9)
    assert names.count("irregular") >= 52  # observed 55
    assert names.count("not settled") <= 2  # observed 1


@pytest.mark.parametrize("grown", [0.2 + 0.8 * TIME, np.exp(-3.0 * TIME)])
@pytest.mark.parametrize("steady", [False, True])  # the part in two loops beside a steady motion
def test_an_irregular_motion_that_still_changes_is_not_settled(grown, steady):
    """Growth by a quarter between both quarters of the second half: one in ten is missed."""
    draw = np.random.default_rng(7)
    ends = []
    for _ in range(40):
        sizes = grown * draw.uniform(0.6, 1.0, COUNT)
        base = max(sizes[-40:].max(), 0.2)
        ends.append(end_of(base + 0.0 * TIME if steady else sizes, sizes).outcome)
    assert ends.count("not settled") >= 34  # observed 36 and 40


def test_a_short_irregular_run_is_not_settled():
    draw = np.random.default_rng(3)
    ends = [end_of(irregular(draw)[:20], 0.0 * TIME[:20]).outcome for _ in range(20)]
    assert set(ends) == {"not settled"}


def test_the_command_prints_the_range_of_an_irregular_motion():
    end = end_of(irregular(np.random.default_rng(2)), 0.0 * TIME)
    assert end.outcome == "irregular"
    dataset = xr.Dataset(_run_columns([BranchRun(1, 7.7, False, end)], "m/s"))
    console = Console(width=120, record=True, file=io.StringIO())
    console.print(_runs(SimpleNamespace(dataset=dataset, over="wind.speed", unit="m/s")))
    printed = console.export_text()
    assert "irregular" in printed
    assert f"{end.u2.low:.3f} to {end.u2.high:.3f}" in printed
