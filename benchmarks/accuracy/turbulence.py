"""Write turbulence.md and turbulence.svg: galloping of example 3 in turbulent wind.

Usage: python benchmarks/accuracy/turbulence.py [--seeds 12] [--workers 2]

(about 6 minutes of CPU time for 12 seeds)

For each mean speed, intensity and seed, example 3 starts from its perturbation of 1 mm and runs for
STOP s. The size of the motion is sqrt(2) times the standard deviation of u2 at mid-span in the last
WINDOW s, which is the amplitude of a steady harmonic. Galloping begins where the mean size over the
seeds exceeds LIMIT. Bands are 5 to 95 % of the mean over the seeds, by BOOTSTRAP resamples.
"""

import argparse
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import gallop_fmu as gf
import modal

RECORD = Path(__file__).with_suffix(".md")
PICTURE = Path(__file__).parents[2] / "docs" / "concepts" / "turbulence.svg"

SPEEDS = (3.5, 4.0, 4.25, 4.5, 4.75, 5.0, 5.5, 6.0, 6.5)
INTENSITIES = (0.0, 0.05, 0.1, 0.2)
STOP, WINDOW = 1800.0, 900.0
LIMIT = 0.1
BOOTSTRAP = 2000
SHOWN = (4.0, 4.5, 5.0, 5.5, 6.0)
TURBULENCE = {
    "spectrum": "kaimal",
    "intensity": 0.1,
    "length_scale": 60.0,
    "length_scale_upwards": 20.0,
    "spacing": 1.0,
}
UPWARDS = 0.5
"""Intensity of the upward gusts over that along the wind."""


def scene(intensity: float) -> gf.Scene:
    given = {**TURBULENCE, "intensity": intensity, "intensity_upwards": UPWARDS * intensity}
    changes = {"wind.turbulence": given, "run.stop_time": STOP, "aerodynamics.outside": "hold"}
    return gf.load_scene("example3").with_values(changes)


def size(result: gf.Result) -> dict[str, float]:
    """Size [m] of the motion in the window, and the largest excursion from its mean."""
    found = {}
    late = result.dataset.time.values > STOP - WINDOW
    for name in ("u2", "u3"):
        values = result.midspan()[name].values[late]
        found[name] = float(np.sqrt(2.0) * values.std())
        found[f"{name}_peak"] = float(np.abs(values - values.mean()).max())
    return found


def band(sizes: np.ndarray) -> tuple[float, float]:
    """5 and 95 % of the mean over resampled seeds."""
    random = np.random.default_rng(1)
    picked = random.integers(0, len(sizes), (BOOTSTRAP, len(sizes)))
    low, high = np.quantile(sizes[picked].mean(axis=1), (0.05, 0.95))
    return float(low), float(high)


def onset(sizes: np.ndarray) -> float:
    """Speed [m/s] at which the mean size, linear between speeds, first exceeds the limit."""
    means = sizes.mean(axis=-1)
    above = np.flatnonzero(means > LIMIT)
    if len(above) == 0:
        return np.nan
    k = int(above[0])
    if k == 0:
        return SPEEDS[0]
    return float(np.interp(LIMIT, means[k - 1 : k + 1], SPEEDS[k - 1 : k + 1]))


def onset_band(sizes: np.ndarray) -> tuple[float, float]:
    random = np.random.default_rng(1)
    picked = random.integers(0, sizes.shape[1], (BOOTSTRAP, sizes.shape[1]))
    low, high = np.quantile([onset(sizes[:, seeds]) for seeds in picked], (0.05, 0.95))
    return float(low), float(high)


def computed(seeds: int, workers: int) -> dict[float, dict[str, np.ndarray]]:
    """Sizes by intensity and channel, shape (speed, seed); without turbulence one seed."""
    found = {}
    for intensity in INTENSITIES:
        count = seeds if intensity else 1
        over = {"wind.speed": list(SPEEDS), "wind.turbulence.seed": list(range(1, count + 1))}
        grid = gf.sweep(scene(intensity), over, summary=size, workers=workers).grid()
        found[intensity] = {name: grid[name].values for name in ("u2", "u3", "u2_peak")}
        print(f"intensity {intensity:g}: computed", flush=True)
    return found


def table(found: dict[float, dict[str, np.ndarray]], seeds: int) -> str:
    steady = modal.critical_wind_speed(gf.load_scene("example3"), 2)[1].wind_speed
    lines = [
        "Written by `benchmarks/accuracy/turbulence.py`: example 3 from a perturbation of 1 mm,"
        f" last {WINDOW:g} s of {STOP:g} s; Kaimal spectrum, length scales"
        f" {TURBULENCE['length_scale']:g} m (along) and {TURBULENCE['length_scale_upwards']:g} m"
        f" (upwards), upward intensity {UPWARDS:g} of that along, {seeds} seeds. Size: sqrt(2)"
        " times the standard deviation of u2 at mid-span [m], mean over the seeds, in brackets the"
        " band of 5 to 95 % of this mean. Onset [m/s]: the mean size exceeds"
        f" {LIMIT:g} m. Without turbulence, linear theory has the onset at {steady:.2f} m/s.",
        "",
        f"| intensity | onset | {' | '.join(f'{speed:g} m/s' for speed in SHOWN)} | largest peak"
        f" at {SHOWN[-1]:g} m/s |",
        f"| --- | --- |{' --- |' * (len(SHOWN) + 1)}",
    ]
    for intensity, sizes in found.items():
        u2 = sizes["u2"]
        cells = [f"{onset(u2):.2f}"]
        if intensity:
            cells[0] += " ({:.2f} to {:.2f})".format(*onset_band(u2))
        for speed in SHOWN:
            at = u2[SPEEDS.index(speed)]
            cells.append(f"{at.mean():.3f}")
            if intensity:
                cells[-1] += " ({:.3f} to {:.3f})".format(*band(at))
        cells.append(f"{sizes['u2_peak'][SPEEDS.index(SHOWN[-1])].max():.2f}")
        lines.append(f"| {intensity:g} | {' | '.join(cells)} |")
    return "\n".join(lines) + "\n"


def picture(found: dict[float, dict[str, np.ndarray]]) -> None:
    figure, axes = plt.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained", sharex=True)
    for axis, name, title in zip(axes, ("u2", "u3"), ("vertical", "horizontal"), strict=True):
        for intensity, sizes in found.items():
            means = sizes[name].mean(axis=1)
            [line] = axis.plot(SPEEDS, means, marker="o", ms=3, label=f"intensity {intensity:g}")
            if intensity:
                low, high = np.transpose([band(at) for at in sizes[name]])
                axis.fill_between(SPEEDS, low, high, color=line.get_color(), alpha=0.2, lw=0)
        axis.set_xlabel("mean wind speed [m/s]")
        axis.set_title(title, loc="left")
    axes[0].set_ylabel("size of the motion at mid-span [m]")
    axes[0].legend(frameon=False)
    figure.savefig(PICTURE, metadata={"Date": None})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=12)
    parser.add_argument("--workers", type=int, default=2)
    given = parser.parse_args()
    found = computed(given.seeds, given.workers)
    text = table(found, given.seeds)
    RECORD.write_text(text, encoding="utf-8")
    picture(found)
    print(text)


if __name__ == "__main__":
    main()
