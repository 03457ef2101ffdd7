"""Draw docs/concepts/ratio.svg, the frequency ratio over the sag of example 3.

Usage: python benchmarks/accuracy/pictures.py (about 5 s)
"""

from pathlib import Path

import matplotlib
import numpy as np
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure

import gallop_fmu as gf
import modal
from gallop_fmu.plots import save_figure
from modal.plots.span_figures import STYLE, ratio_figure

CONCEPTS = Path(__file__).parents[2] / "docs" / "concepts"
SAGS = np.linspace(0.6, 4.2, 25)
"""Sags [m] of the span of 125.88 m."""

SPRING = {"kind": "springs", "stiffness_x1": 75.97e3, "stiffness_x3": 1e9}
"""Printed for example 3, but it excludes the 2:1 ratio."""

RIGID = {"kind": "rigid"}
COLOURS = {"rigid ends": "#404040", "ends on springs of 76 kN/m": "#CC79A7"}


def spans() -> dict[str, gf.Scene]:
    """Example 3 with the tension computed from the sag: rigid ends, or the springs of Table 1."""
    scene = gf.load_scene("example3").with_values({"span.horizontal_tension": None})
    ends = zip(COLOURS, (RIGID, SPRING), strict=True)
    return {
        name: scene.with_values({"supports.left": end, "supports.right": end}) for name, end in ends
    }


def irvine(scene: gf.Scene) -> np.ndarray:
    """Ratio by Irvine's theory at each of `SAGS`."""
    return np.array(
        [modal.shallow_cable(scene.with_values({"span.sag": float(sag)})).ratio for sag in SAGS]
    )


def draw(found: dict[str, xr.Dataset], scenes: dict[str, gf.Scene]) -> Figure:
    """The toolkit's own figure for rigid ends, with the sprung ends and Irvine's theory added."""
    figure = ratio_figure(found["rigid ends"])
    axes: Axes = figure.axes[1]
    axes.lines[-1].set_label("rigid ends")
    axes.plot(SAGS, found["ends on springs of 76 kN/m"].ratio.values,
        color=COLOURS["ends on springs of 76 kN/m"],
              marker=".", markersize=3.0, label="ends on springs of 76 kN/m")  # fmt: skip
    for name, scene in scenes.items():
        label = "Irvine's theory" if name == "rigid ends" else None
        axes.plot(
            SAGS,
            irvine(scene),
            ":",
            color="#009E73",
            linewidth=2.2,
            alpha=0.9,
            zorder=1,
            label=label,
        )
    printed = gf.load_scene("example3")
    axes.plot(printed.span.sag, modal.frequency_ratio(printed).ratio, "D", color="#D55E00",
        markersize=4.0,
              label="the paper's example 3")  # fmt: skip
    axes.legend(frameon=False, loc="upper left")
    axes.set_xlabel("sag [m]")
    axes.set_ylabel("frequency ratio $f_v/f_h$ [1]")
    weight = (
        printed.conductor.mass_per_length + printed.ice.mass_per_length
    ) * printed.span.gravity
    strength = (
        weight * printed.span.length**2 / 8000.0
    )  # sag [m] times tension [kN], by the parabola

    def other(
        value: np.ndarray,
    ) -> np.ndarray:  # of sag and tension, which are inversely proportional
        return strength / np.maximum(value, 1e-9)

    top = figure.axes[0].secondary_xaxis("top", functions=(other, other))
    top.set_xlabel("horizontal tension, by the parabola [kN]")
    top.set_xticks([50, 30, 20, 15, 12, 10, 9, 8])
    return figure


def main() -> None:
    scenes = spans()
    found = {
        name: modal.ratio_map(scene, "span.sag", SAGS.tolist()) for name, scene in scenes.items()
    }
    with matplotlib.rc_context({**STYLE, "svg.hashsalt": "ratio"}):
        print("wrote", save_figure(draw(found, scenes), CONCEPTS / "ratio.svg"))
    (resonant,) = modal.crossings(scenes["rigid ends"], "span.sag", [SAGS[0], SAGS[-1]])
    print(f"rigid ends: the ratio is 2 at a sag of {resonant:.2f} m")
    for name, scene in scenes.items():
        print(
            f"{name}: within {np.max(np.abs(irvine(scene) / found[name].ratio.values - 1.0)):.1%}"
            " of Irvine's theory"
        )
    print(
        "ends on springs: the ratio is"
        f" {found['ends on springs of 76 kN/m'].ratio.values.max():.2f} at most"
    )


if __name__ == "__main__":
    main()
