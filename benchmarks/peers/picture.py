"""The picture: four log-log diagrams of CPU time over error, one curve for each family."""

from __future__ import annotations

import textwrap
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
from analysis import curves
from cases import OURS

COLOURS = {  # Okabe and Ito (2008), distinguishable for the colour-blind
    OURS: "#D55E00",
    "OpenSees": "#0072B2",
    "MoorDyn": "#CC79A7",
    "Radau": "#000000",
    "CVODE": "#009E73",
    "numba": "#E69F00",
}
LINES = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)))
MARKERS = "os^Dvp"
REFERENCE_FLOOR = {"example1": 2e-4, "galloping": 3e-4}
"""Accuracy of the reference of the total error."""

plt.rcParams.update({"svg.hashsalt": "work precision", "font.size": 9, "svg.fonttype": "none"})


def draw(results: dict[str, Any], path: Path) -> None:
    """Write `path`.svg and `path`.png."""
    figure, axes = plt.subplots(2, 2, figsize=(11.0, 10.0), sharey=True)
    handles: dict[str, Any] = {}
    for row_of_axes, (name, scene) in zip(axes, results["scenes"].items(), strict=True):
        for axis, kind in zip(row_of_axes, ("temporal", "total"), strict=True):
            handles |= _curves(axis, scene["rows"], kind)
            _dress(axis, name, kind)
    for row_of_axes in axes:
        row_of_axes[0].set_ylabel("CPU seconds per simulated second")
    figure.subplots_adjust(
        left=0.07, right=0.985, top=0.965, bottom=0.225, hspace=0.24, wspace=0.09
    )
    handles = dict(
        sorted(handles.items(), key=lambda item: list(COLOURS.values()).index(item[1].get_color()))
    )
    figure.legend(
        handles.values(), handles.keys(), loc="upper center", bbox_to_anchor=(0.52, 0.18), ncols=3,
        frameon=False,
        handlelength=3.2,
    )  # fmt: skip
    figure.text(0.07, 0.012, _caption(results["machine"]), fontsize=7.5, va="bottom")
    figure.savefig(path.with_suffix(".png"), dpi=150)
    figure.savefig(path.with_suffix(".svg"), metadata={"Date": None})
    plt.close(figure)


def _curves(axis: Any, rows: list[dict[str, Any]], kind: str) -> dict[str, Any]:
    handles: dict[str, Any] = {}
    families = curves(rows, kind)
    rank: dict[str, int] = {}
    for family in dict.fromkeys(row["family"] for row in rows):
        code = next(row["code"] for row in rows if row["family"] == family)
        place = rank[code] = rank.get(code, -1) + 1
        if family not in families:
            continue
        (handles[family],) = axis.loglog(
            *zip(*families[family], strict=True),
            color=COLOURS[code],
            linestyle=LINES[place % len(LINES)],
            marker=MARKERS[place % len(MARKERS)],
            markersize=5 if code == OURS else 4,
            linewidth=2.2 if code == OURS else 1.1,
            zorder=3 if code == OURS else 2,
        )
    return handles


def _dress(axis: Any, name: str, kind: str) -> None:
    scene = {"example1": "Example 1, load step", "galloping": "Galloping, drag and lift"}[name]
    if kind == "temporal":
        axis.set_title(f"{scene}: error in time (41 nodes)", loc="left")
        axis.set_xlabel("relative RMS against the same mesh converged in time [-]")
        axis.set_xlim(1e-13, 1.0)
    else:
        against = {
            "example1": "160 OpenSees elements",
            "galloping": "160 and 320 chain elements, extrapolated",
        }[name]
        axis.set_title(f"{scene}: total error", loc="left")
        axis.set_xlabel(f"relative RMS against {against} [-]")
        axis.set_xlim(1e-4, 1.0)
        axis.axvspan(1e-4, REFERENCE_FLOOR[name], color="0.9", zorder=0)
        axis.text(
            1.12e-4,
            0.97,
            "reference no better",
            transform=axis.get_xaxis_transform(),
            va="top",
            rotation=90,
        )
    axis.grid(True, which="major", color="0.85", linewidth=0.6)


def _caption(about: dict[str, Any]) -> str:
    versions = ", ".join(f"{name} {number}" for name, number in about["versions"].items())
    load = (
        f", load average {about['load_average']:.1f}" if about["load_average"] is not None else ""
    )
    text = (
        "Lower left is better. Error: the larger of those of u2 and u3. Process CPU time of the"
        " time loop on one core, least of interleaved repeats; start of Python, compilation and"
        f" model building excluded. {about['date']}, {about['processor']}{load}, Python"
        f" {about['python']}, kernel {about['kernel']}; {versions}."
    )
    return "\n".join(textwrap.wrap(text, 165))
