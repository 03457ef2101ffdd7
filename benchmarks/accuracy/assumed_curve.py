"""Calibrate the lift of the assumed coefficient curve to CIGRE 322's envelope, and show the result.

Prints the figures of docs/concepts/curves.md and draws docs/concepts/curves.svg.

Usage: python benchmarks/accuracy/assumed_curve.py (about a minute)

The lift is the one at which the geometric mean of the ratios of predicted to observed amplitude,
over the lines of `tests/support/observed_envelope.py`, is 1. Then the tables: the lines with that
lift, and the mean ratio for other ice, wind and attack angles, which are not calibrated.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from gallop_fmu.plots import NEUTRAL, STYLE, WINDOW_COLOURS, draw_curve, drawing, save_figure
from gallop_fmu.scene import assumed_coefficients
from gallop_fmu.simulation.clearance import cigre_322_single_loop

sys.path.insert(0, str(Path(__file__).parents[2] / "tests"))

from support.observed_envelope import LINES, THICKNESS_RATIO, Predicted, predict

PICTURE = Path(__file__).parents[2] / "docs" / "concepts" / "curves.svg"

LIFTS = (1.0, 1.1, 1.2, 1.3, 1.4)


def lines(**options: float) -> list[Predicted]:
    return [predict(conductor, span, **options) for conductor, span in LINES]


def summary(found: list[Predicted]) -> str:
    ratio = np.array([one.ratio for one in found])
    mean = np.exp(np.mean(np.log(np.maximum(ratio, 1e-3))))
    return f"{mean:6.2f} {ratio.min():6.2f} {ratio.max():6.2f}"


def picture(found: list[Predicted]) -> Figure:
    """Draw the curve, and predicted and observed amplitudes over the sag."""
    assumed = assumed_coefficients.AssumedCoefficients(ice_thickness_ratio=THICKNESS_RATIO)
    with drawing(STYLE):
        figure = Figure(figsize=(7.1, 2.8), layout="constrained")
        left, right = figure.subplots(1, 2)
        draw_curve(left, assumed.curve())
        left.set_title(f"assumed, not measured: ice of {THICKNESS_RATIO:g} diameters", loc="left")
        conductors = list(dict.fromkeys(conductor for conductor, _ in LINES))
        for conductor, colour in zip(conductors, WINDOW_COLOURS, strict=False):
            own = [one for (name, _), one in zip(LINES, found, strict=True) if name == conductor]
            diameter, most = own[0].diameter, own[-1].sag
            sags = np.linspace(own[0].sag, most, 60)
            envelope = [cigre_322_single_loop(sag, diameter).major for sag in sags]
            right.plot(sags, envelope, color=colour, label=f"{conductor}, {1e3 * diameter:.0f} mm")
            right.plot([one.sag for one in own], [one.amplitude for one in own], "o", color=colour)
        right.plot([], [], "-", color=NEUTRAL, label="largest observed (CIGRE 322)")
        right.plot([], [], "o", color=NEUTRAL, label="predicted, 10 m/s")
        right.set_title("vertical motion, peak to peak", loc="left")
        right.set_xlabel("sag [m]")
        right.set_ylabel("amplitude [m]")
        right.set_ylim(0.0)
        right.legend(frameon=False)
    return figure


def main() -> None:
    packaged = assumed_coefficients.LIFT
    print("predicted over observed amplitude (CIGRE 322), peak to peak: geometric mean, min, max")
    print(f"\nlift L; the packaged one is {packaged:g}")
    for lift in LIFTS:
        assumed_coefficients.LIFT = lift
        print(f"{lift:7.2f} {summary(lines())}")
    assumed_coefficients.LIFT = packaged
    print("\nconductor span [m]  sag [m]  sag/d  predicted [m]  observed [m]  ratio  motion")
    calibrated = lines()
    save_figure(picture(calibrated), PICTURE)
    for (conductor, span), one in zip(LINES, calibrated, strict=True):
        print(
            f"{conductor:9} {span:8} {one.sag:8.2f} {one.sag / one.diameter:6.0f}"
            f" {one.amplitude:14.2f} {one.envelope:13.2f} {one.ratio:6.2f}  {one.motion}"
        )
    print("\nnot calibrated: ice thickness over diameter")
    for ratio in (0.02, 0.05, 0.1, 0.2, 0.4):
        print(f"{ratio:7.2f} {summary(lines(thickness_ratio=ratio))}")
    print("\nnot calibrated: wind speed [m/s]")
    for speed in (4.0, 6.0, 8.0, 10.0, 12.0):
        print(f"{speed:7.0f} {summary(lines(wind_speed=speed))}")
    print("\nnot calibrated: attack angle [deg]")
    for angle in (-30.0, -15.0, 0.0, 15.0, 30.0, 165.0, 180.0):
        print(f"{angle:7.0f} {summary(lines(attack_angle_deg=angle))}")


if __name__ == "__main__":
    main()
