"""Figures of the modes of a line: shapes in elevation and plan, pairs near resonance.

Every function returns a `matplotlib.figure.Figure` and leaves pyplot's global state alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from matplotlib.figure import Figure

from gallop_fmu import LineScene, Model
from gallop_fmu.plots import add_title, drawing
from modal.linear.line_modes import LineMode
from modal.plots.span_figures import COLOURS, MARKED, NEUTRAL, STYLE, WIDTH
from modal.stability.mode_pairs import ModePair

DRAWN_SHARE = 0.06
"""Largest displacement of a drawn mode, relative to the length of the line."""


def line_mode_shapes(line: Model | LineScene, modes: Sequence[LineMode], title: str = "") -> Figure:
    """Draw mode shapes over the line: elevation on the left, plan on the right, a row for each.

    The equilibrium is grey. Displacements of a mode have one scale in both views. Twist of the
    conductors is drawn, dashed, as a displacement upwards.

    Parameters
    ----------
    line
        The line, or its model.
    modes
        From `modal.natural_modes`.
    title
        One line above the figure.
    """
    model = line if isinstance(line, Model) else Model(line)
    x = model.equilibrium().x
    length = x[:, 0].max() - x[:, 0].min()
    with drawing(STYLE):
        figure = Figure(figsize=(WIDTH, 0.6 + 0.85 * len(modes)), layout="constrained")
        panels = figure.subplots(len(modes), 2, sharex=True, sharey="col", squeeze=False)
        for row, mode in zip(panels, modes, strict=True):
            _draw_mode(row, model, x, mode, DRAWN_SHARE * length)
            row[0].set_title(
                f"{mode.family}: {mode.frequency_hz:.4g} Hz, {mode.damping_ratio:.2%}", loc="left"
            )
        panels[0, 1].set_title("plan", loc="right")
        panels[0, 0].set_title("elevation", loc="right")
        figure.supxlabel("along the line $x_1$ [m]", fontsize=8.0)
        add_title(figure, title)
    return figure


def _draw_mode(row: Any, model: Model, x: Any, mode: LineMode, scale: float) -> None:
    """Draw one mode in elevation and plan."""
    colour = COLOURS[mode.family]
    twists = mode.family == "torsional"
    moved = scale / mode.largest * mode.shape
    for chain in model.map.chains:
        at, u = x[chain.nodes], moved[chain.nodes]
        for axes, axis in ((row[0], 1), (row[1], 2)):
            axes.plot(at[:, 0], at[:, axis], color=NEUTRAL, linewidth=0.4)
            if not twists:
                axes.plot(at[:, 0] + u[:, 0], at[:, axis] + u[:, axis], color=colour)
        if twists:
            row[0].plot(at[:, 0], at[:, 1] + u[:, 3], color=colour, linestyle="--")
    row[0].set_ylabel("height\n$x_2$ [m]")
    row[1].set_ylabel("downwind\n$x_3$ [m]")


def pair_figure(pairs: Sequence[ModePair], title: str = "") -> Figure:
    """Draw thresholds of pairs of modes over their detuning; marked: pairs that matter.

    Parameters
    ----------
    pairs
        From `modal.mode_pairs`; those without a threshold are not drawn.
    title
        One line above the figure.
    """
    with drawing(STYLE):
        figure = Figure(figsize=(WIDTH, 3.4), layout="constrained")
        axes = figure.subplots()
        drawn = [(pair, pair.threshold) for pair in pairs if pair.threshold is not None]
        for kind, marker in (("2:1", "o"), ("1:1", "s")):
            axes.scatter([], [], marker=marker, color=NEUTRAL, label=kind)
        for pair, threshold in drawn:
            colour, place = COLOURS[pair.driving_mode.family], (100.0 * pair.detuning, threshold)
            axes.scatter(
                *place,
                marker="o" if pair.kind == "2:1" else "s",
                facecolors=colour if pair.matters else "none",
                edgecolors=colour,
            )
            if pair.matters:
                text = f"{pair.driving}-{pair.driven}"
                axes.annotate(text, place, xytext=(4, 3), textcoords="offset points", color=MARKED)
        axes.set_yscale("log")
        axes.set_xlabel("detuning [%]")
        axes.set_ylabel("threshold of the driving mode [m, rad]")
        axes.legend(frameon=False)
        add_title(figure, title)
    return figure
