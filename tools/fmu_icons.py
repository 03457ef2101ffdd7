"""Draw the pictures that every FMU contains, into gallop_fmu/fmu/artwork.

    python tools/fmu_icons.py

model.png: a span between two towers, its section with ice and the wind. tower.png: a tower, for
the terminals.
"""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

FOLDER = Path(__file__).resolve().parent.parent / "gallop_fmu" / "fmu" / "artwork"
DARK, BLUE, ICE = "#333333", "#0072b2", "#9fd4ef"


def square(pixels: int) -> Axes:
    """Return axes from -1 to 1 that fill a picture without frame."""
    figure = plt.figure(figsize=(pixels / 100, pixels / 100), dpi=100)
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_xlim(-1, 1)
    axes.set_ylim(-1, 1)
    axes.axis("off")
    return axes


def tower(axes: Axes, x: float, foot: float, top: float, half: float) -> None:
    """Draw a lattice tower with one cross-arm."""
    lines = [
        ([x - half, x], [foot, top]),
        ([x + half, x], [foot, top]),
        ([x - half, x + 0.5 * half], [foot, 0.5 * (foot + top)]),
        ([x + half, x - 0.5 * half], [foot, 0.5 * (foot + top)]),
        ([x - 0.8 * half, x + 0.8 * half], [top - 0.12, top - 0.12]),
    ]
    for across, up in lines:
        axes.plot(across, up, color=DARK, lw=2.5, solid_capstyle="round")


def save(axes: Axes, name: str) -> None:
    """Write the picture of some axes, without a date."""
    assert axes.figure is not None
    axes.figure.savefig(FOLDER / name, transparent=True, metadata={"Software": None})  # type: ignore[union-attr]
    plt.close("all")


def main() -> None:
    """Draw both pictures."""
    axes = square(128)
    for x in (-0.8, 0.8):
        tower(axes, x, -0.85, 0.55, 0.14)
    x = np.linspace(-0.8, 0.8, 50)
    for rise, style in ((0.0, "-"), (0.28, ":"), (-0.28, ":")):
        sag = (0.5 + rise) * (1.0 - (x / 0.8) ** 2)
        axes.plot(x, 0.43 - sag, style, color=BLUE, lw=2.5)
    angle = np.linspace(0.0, 2.0 * np.pi, 60)
    axes.fill(0.2 * np.cos(angle) - 0.06, 0.12 * np.sin(angle) + 0.74, color=ICE)
    axes.fill(0.11 * np.cos(angle), 0.11 * np.sin(angle) + 0.74, color=BLUE)
    axes.annotate(
        "", (-0.36, 0.74), (-0.85, 0.74), arrowprops={"arrowstyle": "-|>", "lw": 2.5, "color": DARK}
    )
    save(axes, "model.png")
    axes = square(32)
    tower(axes, 0.0, -0.9, 0.9, 0.6)
    save(axes, "tower.png")


if __name__ == "__main__":
    main()
