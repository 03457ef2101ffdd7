"""Figures of the report, and conversion of figures to SVG in the colours of a page."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from io import StringIO
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from gallop_fmu.plots import COLOURS, NEUTRAL, STYLE, drawing
from gallop_fmu.simulation.clearance import Ellipse

if TYPE_CHECKING:
    import xarray as xr

    from modal.report.findings import Statics

Array = NDArray[np.float64]

WIDE, NARROW = 7.1, 4.1
"""Width [inch] of a figure on a wide page, and on a telephone with lettering of the same size."""

LETTERS_PER_INCH = 13.0
"""Letters of a title that fit into an inch."""

LABEL_WIDTH = 0.7
"""Width [inch] of labels beside the axes."""

MIN_HALF_RANGE = 1.0
"""Half range [m] of an axis along which nothing moves."""

SIDES: tuple[Literal["left", "center"], ...] = ("left", "center")

REST_STYLES: tuple[dict[str, Any], ...] = (
    {"color": "#404040"},
    {"color": "#0072B2", "linestyle": (0, (4, 2)), "linewidth": 1.4},
)
RULE_STYLES = ("-", "--")

VARIABLES = {
    "#000000": "currentColor",
    "#404040": "currentColor",
    "#0072b2": "var(--blue)",
    "#d55e00": "var(--vermilion)",
    "#009e73": "var(--green)",
    "#cc79a7": "var(--pink)",
    "#e69f00": "var(--amber)",
}
"""Colours of figures, and the variables of the style sheet that replace them (for dark mode)."""


@dataclass(frozen=True)
class Picture:
    """A figure as SVG: in one width, or in two if its lettering is too small on a telephone."""

    label: str
    caption: str
    wide: str
    narrow: str


def picture(
    name: str,
    label: str,
    caption: str,
    draw: Callable[[], Figure],
    draw_narrow: Callable[[], Figure] | None = None,
    *,
    once: bool = False,
) -> Picture:
    """Draw a figure for the page.

    Parameters
    ----------
    name
        Prefix of its identifiers, unique in the page.
    label, caption
        Description for screen readers, and caption below the figure.
    draw
        Function that returns the figure.
    draw_narrow
        The same for a telephone, if a narrow figure needs another layout.
    once
        True if the figure fits a telephone as it is.
    """
    narrow = "" if once else svg((draw_narrow or draw)(), f"{name}-narrow", NARROW)
    return Picture(label, caption, svg(draw(), name), narrow)


def svg(figure: Figure, name: str, width: float | None = None) -> str:
    """Convert a figure to an SVG element for a page.

    Parameters
    ----------
    figure
        The figure; it is resized if a width is given.
    name
        Prefix of its identifiers, unique in the page.
    width
        Width [inch]; titles are wrapped to fit.
    """
    if width is not None:
        resize(figure, width, float(figure.get_size_inches()[1]))
    text = StringIO()
    with drawing({"svg.fonttype": "none", "svg.hashsalt": name}):
        figure.savefig(text, format="svg", transparent=True, metadata={"Date": None})
    return _embedded(text.getvalue(), name)


def resize(figure: Figure, width: float, height: float) -> Figure:
    """Resize a figure [inch]: panels side by side move below each other, titles are wrapped."""
    panels = figure.axes
    grids = [axes.get_subplotspec() for axes in panels]
    if any(grid is not None and grid.get_gridspec().ncols > 1 for grid in grids):
        height *= len(panels)
        below = figure.add_gridspec(len(panels), 1)
        for row, axes in enumerate(panels):
            axes.set_subplotspec(below[row])
    figure.set_size_inches(width, height)
    with drawing(STYLE):
        for axes in panels:
            for side in SIDES:
                if title := axes.get_title(loc=side):
                    letters = int(LETTERS_PER_INCH * (width - LABEL_WIDTH))
                    axes.set_title(textwrap.fill(title, letters), loc=side)
    return figure


def static_shape(states: Mapping[str, Statics]) -> Figure:
    """Draw static shapes of the span from the side and from above.

    Parameters
    ----------
    states
        Name and static state, at most two.
    """
    with drawing(STYLE):
        figure = Figure(figsize=(WIDE, 3.6), layout="constrained")
        side, above = figure.subplots(2, 1, sharex=True, height_ratios=(1.4, 1.0))
        for (name, state), style in zip(states.items(), REST_STYLES, strict=False):
            side.plot(state.x[:, 0], state.x[:, 1], label=name, **style)
            above.plot(state.x[:, 0], state.x[:, 2], **style)
            for axes, column in ((side, 1), (above, 2)):
                axes.plot(
                    state.x[[0, -1], 0],
                    state.x[[0, -1], column],
                    "o",
                    color=NEUTRAL,
                    markersize=3.0,
                )
        side.set_ylabel("height $x_2$ [m]")
        side.set_title("from the side (scales differ)", loc="left")
        above.set_ylabel("downwind $x_3$ [m]")
        above.set_title("from above (scales differ)", loc="left")
        above.set_xlabel("along the span $x_1$ [m]")
        if np.ptp(above.get_ylim()) < 1e-6:
            above.set_ylim(-MIN_HALF_RANGE, MIN_HALF_RANGE)
        side.legend(frameon=False, loc="upper center", ncols=2)
    return figure


def clearance_figure(
    data: xr.Dataset, ellipses: Mapping[str, Ellipse], places: Mapping[str, tuple[float, float]]
) -> Figure:
    """Draw the area that mid-span reached, with the ellipses of design rules.

    Parameters
    ----------
    data
        Mid-span u2 and u3 [m] over time.
    ellipses
        Name and ellipse of each rule.
    places
        Name and position x3, x2 [m] of the static states, relative to still air. The ellipses are
        drawn at the last one.
    """
    x, y = np.asarray(data.u3.values), np.asarray(data.u2.values)
    origin = list(places.values())[-1]
    with drawing(STYLE):
        figure = Figure(figsize=(NARROW, 4.6), layout="constrained")
        axes = figure.subplots()
        hull = outermost(x, y)
        axes.fill(x[hull], y[hull], color=COLOURS["u2"], alpha=0.25, linewidth=0.0)
        axes.plot(
            x[[*hull, hull[0]]],
            y[[*hull, hull[0]]],
            color=COLOURS["u2"],
            label="reached in the run",
        )
        for (name, ellipse), style in zip(ellipses.items(), RULE_STYLES, strict=False):
            across, up = ellipse.outline()
            axes.plot(origin[0] + across, origin[1] + up, style, color=COLOURS["u3"], label=name)
        for (name, place), mark in zip(places.items(), ("o", "s"), strict=False):
            axes.plot(*place, mark, color=NEUTRAL, markersize=3.5, label=name)
        axes.set_aspect("equal", adjustable="datalim")
        axes.set_xlabel("downwind $u_3$ [m]")
        axes.set_ylabel("vertical $u_2$ [m]")
        figure.legend(loc="outside lower center", frameon=False, ncols=2)
    return figure


def outermost(x: Array, y: Array, directions: int = 360) -> list[int]:
    """Indices of the farthest points in each direction: the corners of their convex hull."""
    angle = np.linspace(0.0, 2.0 * np.pi, directions, endpoint=False)
    farthest = [int(np.argmax(x * np.cos(towards) + y * np.sin(towards))) for towards in angle]
    return list(dict.fromkeys(farthest))


def _rounded(number: re.Match[str]) -> str:
    return f"{float(number[0]):.2f}"


def _embedded(text: str, name: str) -> str:
    """Reduce an SVG file to an element with the page's colours and unique identifiers."""
    text = text[text.index("<svg") :]
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    head, body = text.split(">", 1)
    box = re.search(r'viewBox="[^"]*"', head)
    assert box is not None
    used = set(re.findall(r'(?:href="#|url\(#)([^")]+)', body))
    body = re.sub(r' id="([^"]+)"', lambda m: f' id="{name}-{m[1]}"' if m[1] in used else "", body)
    body = re.sub(r'xlink:href="#', f'href="#{name}-', body).replace("url(#", f"url(#{name}-")
    body = re.sub(r"<[^>]*>", lambda tag: re.sub(r"-?\d+\.\d{3,}", _rounded, tag[0]), body)
    for colour, variable in VARIABLES.items():
        body = re.sub(colour, variable, body, flags=re.IGNORECASE)
    return f'<svg {box[0]} preserveAspectRatio="xMidYMid meet" aria-hidden="true">{body.strip()}'
