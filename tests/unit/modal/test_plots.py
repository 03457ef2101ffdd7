"""Figures of the modal toolkit: what their lines and marks say."""

import numpy as np
import pytest
import xarray as xr
from matplotlib.collections import LineCollection
from matplotlib.colors import to_rgb

import gallop_fmu as gf
import modal
from modal.plots.span_figures import COLOURS, _spread, ratio_figure, tracking_figure


def test_labels_keep_their_distance_and_their_place():
    apart = np.array([1.0, 2.0, 3.0])
    assert _spread(apart, 0.5) == pytest.approx(apart)
    assert _spread(np.array([1.0, 1.0, 3.0]), 0.5) == pytest.approx([0.75, 1.25, 3.0])
    draw = np.random.default_rng(0)
    for _ in range(50):
        wanted = np.sort(draw.random(8))
        placed = _spread(wanted, 0.1)
        assert np.diff(placed).min() > 0.1 - 1e-12
        assert np.abs(placed - wanted).max() <= 7 * 0.1


@pytest.fixture
def veering():
    """Two modes that avoid each other and exchange their families, in textbook form."""
    x = np.linspace(-1.0, 1.0, 21)
    half = np.sqrt(x**2 + 0.04)
    frequency = np.array([1.0 - half, 1.0 + half])
    vertical = 0.5 * (1.0 - x / half)
    share = np.zeros((2, 21, 4))
    share[0, :, 0], share[0, :, 1] = 1.0 - vertical, vertical
    share[1, :, 0], share[1, :, 1] = vertical, 1.0 - vertical
    families = ["vertical", "horizontal", "torsional", "longitudinal"]
    over = ("mode", "span.sag")
    return xr.Dataset(
        {"frequency_hz": (over, frequency), "share": ((*over, "family"), share)},
        coords={"span.sag": ("span.sag", x, {"units": "m"}), "family": families},
    )


def test_a_line_stays_with_its_mode_through_an_avoided_crossing(veering):
    """A curve keeps its side and changes colour; the mode's number is at both of its ends."""
    axes = tracking_figure(veering).axes[0]
    lines = [line for line in axes.collections if isinstance(line, LineCollection)]
    assert len(lines) == 2
    for line, frequency in zip(lines, veering.frequency_hz.values, strict=True):
        pieces = np.array(line.get_segments())
        assert pieces[:, 0, 1] == pytest.approx(frequency[:-1])
        assert pieces[:, 1, 1] == pytest.approx(frequency[1:])
    ends = [np.array(line.get_colors())[[0, -1], :3] for line in lines]
    vertical, horizontal = (
        np.array(to_rgb(COLOURS[family])) for family in ("vertical", "horizontal")
    )
    assert ends[0] == pytest.approx(np.array([horizontal, vertical]), abs=0.05)
    assert ends[1] == pytest.approx(np.array([vertical, horizontal]), abs=0.05)
    numbers = sorted((text.get_position()[1], text.get_text()) for text in axes.texts)
    assert [number for _, number in numbers] == ["1", "1", "2", "2"]


def test_a_map_reaches_the_1_to_1_line_and_counts_in_factors():
    """Soft springs lower the vertical frequency to that of a string, the horizontal one."""
    spring = {"kind": "springs", "stiffness_x1": 2e4, "stiffness_x3": 1e9}
    scene = gf.load_scene("example3").with_values(
        {"span.sag": None, "supports": {"left": spring, "right": spring}, "numerics.elements": 8}
    )
    stiffness = [3e2, 3e3, 3e4]
    data = modal.ratio_map(
        scene, "span.sag", [0.5, 1.25, 4.0], against=("supports.stiffness_x1", stiffness)
    )
    assert data.ratio.values[0] == pytest.approx(1.0, abs=2e-3)  # observed 0.999 to 1.000
    assert data.ratio.values[0, 0] < 1.0 < data.ratio.values[1, 0]
    figure = ratio_figure(data)
    assert figure.axes[0].get_xscale() == "log"
    assert figure.axes[0].get_yscale() == "linear"
    labels = [text.get_text() for text in figure.legends[0].get_texts()]
    assert labels == ["1:1", "10% from 1:1"]
