"""Amplitude of Parkinson and Smith's square prism over the wind speed, with its hysteresis.

Sweeps upwards and downwards by the whole simulation, each run from the amplitude at which the one
before it ended, against the closed form of quasi-steady theory; and runs that start close to the
unstable limit cycle. Prints a table and draws docs/reference/square_prism.svg.

Usage: python benchmarks/accuracy/square_prism.py (about a minute)
"""

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import gallop_fmu as gf
from gallop_fmu.plots import drawing, save_figure
from modal.plots.span_figures import COLOURS, NEUTRAL, STYLE

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))
from support.square_prism import (
    DIAMETER,
    fold_winds,
    limit_cycles,
    onset_wind_speed,
    prism,
)

PICTURE = Path(__file__).parents[2] / "docs" / "reference" / "square_prism.svg"

WINDS = np.array([1.1, 1.2, 1.3, 1.4, 1.45, 1.5, 1.55, 1.6, 1.65, 1.7, 1.75, 1.8, 2.0, 2.5])
"""Wind speeds over that of the onset."""

WINDOW = 20
"""Periods at the end of a run whose amplitude is measured."""

SMALLEST = 0.02
"""Amplitude over the side of the prism with which the sweep upwards begins."""


FEWEST_PERIODS, PERIODS_AT_ONSET = 6000.0, 3000.0
"""Least duration of a run, and its duration times U/U0 - 1, which is the rate of growth."""


def settled(wind: float, start: float) -> float:
    """Amplitude [m] at the end of a run that starts with an amplitude [m]."""
    periods = max(FEWEST_PERIODS, PERIODS_AT_ONSET / (wind - 1.0))
    result = gf.simulate(prism(wind * onset_wind_speed(), start, periods=periods))
    u2 = np.ravel(result.dataset.u2.values)[-40 * WINDOW :]
    return 0.5 * float(u2.max() - u2.min())


def sweep(winds: np.ndarray, start: float) -> dict[float, float]:
    """Amplitudes of runs one after another, each from the last amplitude."""
    found = {}
    for wind in winds.tolist():
        found[wind] = start = settled(wind, start)
    return found


def picture(up: dict[float, float], down: dict[float, float]) -> Figure:
    """Draw the closed form and both sweeps."""
    low, high = fold_winds()
    winds = np.unique(np.concatenate([np.linspace(1.0, 2.5, 400), [low, high]]))
    with drawing(STYLE):
        figure = Figure(figsize=(4.5, 3.2), layout="constrained")
        axes = figure.subplots()
        branches = np.full((3, len(winds)), np.nan)
        for k, wind in enumerate(winds):
            cycles = np.array(limit_cycles(wind)) / DIAMETER
            if len(cycles) == 3:
                branches[:, k] = cycles
            elif len(cycles) == 1:
                branches[0 if wind < 0.5 * (low + high) else 2, k] = cycles[0]
        for k, style in enumerate(("-", ":", "-")):
            label = ("quasi-steady theory", "the same, unstable", None)[k]
            axes.plot(winds, branches[k], style, color=NEUTRAL, label=label)
        for found, mark, colour, name in (
            (up, "^", COLOURS["vertical"], "simulation, wind upwards"),
            (down, "v", COLOURS["horizontal"], "simulation, wind downwards"),
        ):
            heights = np.array(list(found.values())) / DIAMETER
            axes.plot(list(found), heights, mark, color=colour, markersize=4.0, label=name)
        axes.set_xlabel("wind speed over that of the onset")
        axes.set_ylabel("amplitude over the side of the prism")
        axes.set_ylim(0.0)
        axes.legend(frameon=False)
    return figure


def nearest(amplitude: float, cycles: list[float]) -> float:
    """Relative deviation from the nearest stable limit cycle."""
    stable = cycles[::2]
    return min((amplitude / cycle - 1.0 for cycle in stable), key=abs)


def main() -> None:
    """Print the table and draw the picture."""
    up = sweep(WINDS, SMALLEST * DIAMETER)
    down = sweep(WINDS[::-1], up[float(WINDS[-1])])
    low, high = fold_winds()
    print(f"folds at {low:.3f} and {high:.3f} of the onset at {onset_wind_speed():.4f} m/s")
    print("| U/U0 | theory, a/d | upwards, a/d | deviation | downwards, a/d | deviation |")
    print("| ---: | --- | ---: | ---: | ---: | ---: |")
    for wind in WINDS.tolist():
        cycles = limit_cycles(wind)
        theory = ", ".join(f"{cycle / DIAMETER:.4f}" for cycle in cycles)
        cells = [
            f"{found[wind] / DIAMETER:.4f} | {nearest(found[wind], cycles):+.3%}"
            for found in (up, down)
        ]
        print(f"| {wind:.2f} | {theory} | {' | '.join(cells)} |")
    print("\n| U/U0 | start over the unstable amplitude | end over it |\n| ---: | ---: | ---: |")
    for wind in WINDS.tolist():
        cycles = limit_cycles(wind)
        for factor in (0.97, 1.03) if len(cycles) == 3 else ():
            end = settled(wind, factor * cycles[1]) / cycles[1]
            print(f"| {wind:.2f} | {factor:.2f} | {end:.3f} |")
    save_figure(picture(up, down), PICTURE)


if __name__ == "__main__":
    main()
