"""Figures: what they show, that they can be written, and that pyplot's state is left alone."""

import itertools
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg

import gallop_fmu as gf
from gallop_fmu import plots
from gallop_fmu.foundation.errors import SceneError


@pytest.fixture(scope="module")
def result():
    return gf.simulate(gf.load_scene("example1"), 4.0, record_every=4)


@pytest.fixture(scope="module")
def moving():
    """A vertical motion of 1 Hz and a swing of half of it, 100 s long."""
    time = np.arange(0.0, 100.0, 0.01)
    values = {"u2": np.sin(2.0 * np.pi * time), "u3": 0.5 * np.sin(np.pi * time)}
    return xr.Dataset(
        {name: ("time", y, {"units": "m"}) for name, y in values.items()}, {"time": time}
    )


def _drawn_tick_labels(axis, renderer):
    low, high = sorted(axis.get_view_interval())
    ticks = [tick for tick in axis.get_major_ticks() if low <= tick.get_loc() <= high]
    return [tick.label1.get_window_extent(renderer) for tick in ticks if tick.label1.get_visible()]


def _collisions(figure):
    """Number of overlapping panels (with labels and titles) and of overlapping tick labels."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    renderer = canvas.get_renderer()
    titles = [owner._suptitle for owner in [figure, *figure.subfigs] if owner._suptitle]
    boxes = [axes.get_tightbbox(renderer) for axes in figure.axes] + [
        title.get_window_extent() for title in titles
    ]
    pairs = list(itertools.combinations(boxes, 2))
    for axes in figure.axes:
        for axis in (axes.xaxis, axes.yaxis):
            pairs += itertools.pairwise(_drawn_tick_labels(axis, renderer))
    return sum(first.padded(-1.0).overlaps(second.padded(-1.0)) for first, second in pairs)


def test_histories_are_labelled(result):
    figure = plots.histories(result, ("u2", "theta", "tension"))
    assert [axes.get_ylabel() for axes in figure.axes] == [
        "$u_2$ [m]",
        r"$\theta$ [deg]",
        "$T$ [kN]",
    ]
    assert figure.axes[-1].get_xlabel() == "time [s]"
    np.testing.assert_allclose(
        figure.axes[1].lines[0].get_ydata(), np.degrees(result.midspan().theta), rtol=1e-12
    )


def test_any_channel_can_be_drawn(result):
    assert plots.histories(result, ["v2"]).axes[0].get_ylabel() == "v2 [m/s]"


def test_trace_shows_each_window(moving):
    figure = plots.trace(moving, {"first": (0.0, 2.0), "second": (10.0, 14.0)})
    first, second = (axes.lines[0] for axes in figure.axes)
    assert [len(line.get_xdata()) for line in (first, second)] == [201, 401]
    np.testing.assert_array_equal(second.get_ydata(), moving.u2.values[1000:1401])
    assert figure.axes[0].get_aspect() == 1.0


def test_thin_paths_get_their_own_scales(moving):
    figure = plots.trace(moving.assign(u3=0.01 * moving.u3), {"all": (0.0, 4.0)})
    assert figure.axes[0].get_aspect() == "auto"
    assert "scales differ" in figure.axes[0].get_title()


def test_the_title_of_thin_paths_stays_inside_an_overview(result, monkeypatch):
    """In release 0.1.0 it was one line that touched the right edge."""
    monkeypatch.setattr(plots, "MAX_EQUAL_SCALE_RATIO", 0.0)
    monkeypatch.setattr(plots, "enlarged_part", lambda data: {"last periods": (0.0, 1e3)})
    figure = plots.overview(result)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    title = next(axes.title for axes in figure.axes if "scales differ" in axes.get_title())
    box = title.get_window_extent(canvas.get_renderer())
    assert figure.bbox.x1 - box.x1 > 0.1 * figure.dpi  # observed 0.5 inch


def test_the_last_periods_are_enlarged(moving):
    assert plots.enlarged_part(moving)["last periods"] == pytest.approx(
        (99.99 - 12.0, 99.99), abs=0.01
    )


def test_a_motion_that_died_out_is_shown_whole(moving):
    gone = moving * np.exp(-moving.time)
    assert plots.enlarged_part(gone) == {"whole run": (0.0, pytest.approx(99.99))}


def test_thinning_keeps_every_extreme():
    time = np.arange(1_000_000) * 1e-3
    values = np.sin(0.7 * time) * time
    values[123_456] = 5e3
    thin_time, thin = plots.thinned(time, values)
    assert len(thin) < 4 * plots.PIXEL_COLUMNS
    assert (thin.max(), thin.min()) == (5e3, values.min())
    assert np.all(np.diff(thin_time) >= 0.0)


def test_no_text_covers_another(result, moving):
    windows = {"before": (0.0, 30.0), "during": (30.0, 60.0), "after": (60.0, 99.0)}
    for figure in (
        plots.overview(result),
        plots.story(moving, windows, "a title"),
        plots.trace(moving, windows),
    ):
        assert _collisions(figure) == 0


@pytest.mark.parametrize(
    ("suffix", "magic"), [(".png", b"\x89PNG"), (".pdf", b"%PDF"), (".svg", b"<?xml")]
)
def test_figures_are_written(result, tmp_path, suffix, magic):
    path = plots.save_figure(plots.overview(result), tmp_path / f"a{suffix}")
    assert path.read_bytes().startswith(magic)


def test_other_formats_are_refused(result, tmp_path):
    with pytest.raises(
        SceneError, match=r"pictures are not written as \.gif; choose \.png, \.svg, \.pdf"
    ):
        plots.save_figure(plots.histories(result), tmp_path / "a.gif")


def test_channels_that_were_not_recorded_cannot_be_drawn(result):
    with pytest.raises(SceneError, match="u9 was not recorded"):
        plots.histories(result, ("u2", "u9"))
    with pytest.raises(SceneError, match="the window late from 50 s to 60 s has no record"):
        plots.trace(result, {"late": (50.0, 60.0)})


def test_a_single_record_can_be_drawn(moving):
    assert plots.trace(moving.isel(time=slice(0, 1))).axes


def test_pyplot_is_not_needed():
    """In a process of its own: other tests load packages that import pyplot."""
    code = (
        "import sys, gallop_fmu as gf; from gallop_fmu import plots;"
        "plots.overview(gf.simulate(gf.load_scene('example1'), stop_time=1.0));"
        "sys.exit('matplotlib.pyplot' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-P", "-c", code], check=False).returncode == 0


@pytest.fixture(scope="module")
def grid():
    """Amplitudes of two spans over the wind speed and the angle of the ice."""
    axes = {"wind.speed": [4.0, 5.0, 6.0], "ice.attack_angle_deg": [178.0, 180.0], "span": [1, 2]}
    values = np.arange(12.0).reshape(3, 2, 2)
    data = xr.Dataset({"span_u2_amplitude": (tuple(axes), values, {"units": "m"})}, axes)
    data["outcome"] = (("wind.speed", "ice.attack_angle_deg"), np.full((3, 2), "completed"))
    data["wind.speed"].attrs["units"] = "m/s"
    return data


def test_sweep_has_a_curve_for_each_span(grid):
    figure = plots.over_values(grid.sel({"ice.attack_angle_deg": 180.0}), "span_u2_amplitude")
    (axes,) = figure.axes
    assert [line.get_label() for line in axes.lines] == ["span 1", "span 2"]
    assert axes.lines[1].get_xydata().tolist() == [[4.0, 3.0], [5.0, 7.0], [6.0, 11.0]]
    assert axes.get_xlabel() == "wind.speed [m/s]"
    assert axes.get_ylabel() == "span_u2_amplitude [m]"


def test_sweep_that_is_no_curve_is_refused(grid):
    with pytest.raises(SceneError, match=r"this sweep has wind\.speed, ice\.attack_angle_deg"):
        plots.over_values(grid, "span_u2_amplitude")
    with pytest.raises(SceneError, match="outcome is no column of numbers; choose one of span_u2"):
        plots.over_values(grid, "outcome")
