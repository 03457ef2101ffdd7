# %% [markdown]
# # Gusty wind through the FMU
#
# A gusty wind drives the FMU of example 3 in FMPy: mean 5.5 m/s, turbulence intensity 10 % with a
# Kaimal spectrum (IEC 61400-1, length scale 42 m), made of cosines with random phases. Does
# galloping still start the swing at half the frequency? The wind speed is the same along the whole
# span, which is the worst case. The coefficient curve is a reconstruction.

# %%
import tempfile
from pathlib import Path

import fmpy
import numpy as np
from matplotlib.figure import Figure

import gallop_fmu as gf
from gallop_fmu.plots import save_figure

MEAN, INTENSITY, LENGTH = 5.5, 0.1, 42.0  # [m/s], [1], [m]
STOP, STEP = 1200.0, 0.05

# %% The wind. Its period is longer than the run. It changes slowly compared with the step of 0.05 s
# in which the host sets it.
frequency = np.arange(1, 1500) / 1500.0  # up to 1 Hz
spectrum = 4.0 * LENGTH / MEAN / (1.0 + 6.0 * frequency * LENGTH / MEAN) ** (5.0 / 3.0)
amplitude = np.sqrt(spectrum / spectrum.sum()) * np.sqrt(2.0) * INTENSITY * MEAN
phase = np.random.default_rng(1).uniform(0.0, 2.0 * np.pi, frequency.size)
time = np.arange(0.0, STOP + 1e-9, STEP)
gusts = sum(
    a * np.cos(2.0 * np.pi * f * time + p)
    for a, f, p in zip(amplitude, frequency, phase, strict=True)
)
wind = {"steady": np.full_like(time, MEAN), "gusty": MEAN + gusts}
print(
    f"gusty wind: mean {wind['gusty'].mean():.2f} m/s, {wind['gusty'].min():.2f} to"
    f" {wind['gusty'].max():.2f} m/s"
)

# %% One FMU, two runs. FMPy warns of inputs that are not in the table; they keep their start
# values.
folder = Path(tempfile.mkdtemp(prefix="gallop-"))
scene = gf.load_scene("example3").with_values({"numerics.time_step": 0.025})
fmu = gf.export_fmu(scene, folder / "example3.fmu")
runs = {}
for name, speed in wind.items():
    table = np.rec.fromarrays([time, speed], names=["time", "wind_speed"])
    runs[name] = fmpy.simulate_fmu(
        str(fmu),
        stop_time=STOP,
        output_interval=STEP,
        input=table,
        output=["midspan.x2", "midspan.x3", "status"],
    )
    assert np.all(runs[name]["status"] == 0)

# %% The last 400 s: standard deviation of the motion, and its frequencies.
late = time >= STOP - 400.0
spread = {}
for name, run in runs.items():
    motion = {axis: run[f"midspan.{axis}"][late] for axis in ("x2", "x3")}
    waves = {
        axis: gf.dominant_frequency(values - values.mean(), STEP) for axis, values in motion.items()
    }
    spread[name] = {axis: float(np.std(values)) for axis, values in motion.items()}
    print(
        f"{name:7} vertical {spread[name]['x2']:.3f} m (RMS) at {waves['x2']:.3f} Hz, "
        f"horizontal {spread[name]['x3']:.3f} m at {waves['x3']:.3f} Hz"
    )
    assert abs(waves["x3"] / waves["x2"] - 0.5) < 0.01

# %%
figure = Figure(figsize=(7.1, 4.8), layout="constrained")
rows = figure.subplots(3, 1, sharex=True)
colours = {"steady": "#999999", "gusty": "#D55E00"}
for axes, values, label in (
    (rows[0], wind, "wind [m/s]"),
    (rows[1], {name: run["midspan.x2"] for name, run in runs.items()}, "vertical [m]"),
    (rows[2], {name: run["midspan.x3"] for name, run in runs.items()}, "horizontal [m]"),
):
    for name in ("steady", "gusty"):
        axes.plot(time, values[name], color=colours[name], linewidth=0.4, label=name)
    axes.set_ylabel(label)
rows[0].legend(loc="lower right", ncols=2, frameon=False)
rows[2].set(xlabel="time [s]", xlim=(0.0, STOP))
print("wrote", save_figure(figure, folder / "gusty.png"))

# %% The swing starts. Its amplitude varies with the gusts, up to almost three times that in steady
# wind.
largest = {
    name: float(np.abs(run["midspan.x3"][late] - run["midspan.x3"][late].mean()).max())
    for name, run in runs.items()
}
print(f"largest swing {largest['gusty']:.3f} m, in steady wind {largest['steady']:.3f} m")
assert abs(spread["steady"]["x3"] - 0.1396) < 0.001
assert abs(spread["gusty"]["x3"] - 0.159) < 0.002
