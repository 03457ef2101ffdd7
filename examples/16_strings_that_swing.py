# %% [markdown]
# # Galloping that makes a whole section swing on its strings
#
# Three spans of the paper's example 2, with suspension strings in place of the springs that stand
# for the neighbours. Each span gallops vertically as the single span does. But the section has a
# sideways mode that a single span does not have: all spans swing on their strings, at about half of
# the galloping frequency. The 2:1 resonance of the paper acts on that mode. A study of one span
# does not show it. The coefficient curve is a reconstruction.

# %%
import math
import tempfile
from pathlib import Path

import numpy as np

import gallop_fmu as gf
from gallop_fmu.plots import save_figure
from gallop_fmu.scene.line_scene import LineScene

ONE_SPAN = gf.load_scene("example2").model_dump(mode="json", exclude_none=True)
STRING = {"kind": "string", "length": 2.1, "weight": 490.0}


def damping(rate, low, high):
    """Two ratios at two frequencies that make a damping in proportion to the mass alone [1/s]."""
    names = (("low_ratio", "low_frequency", low), ("high_ratio", "high_frequency", high))
    return {
        key: value
        for ratio, frequency, hertz in names
        for key, value in ((ratio, rate / (4.0 * math.pi * hertz)), (frequency, hertz))
    }


kept = ("conductor", "ice", "wind", "aerodynamics")
scene = LineScene.from_dict(
    {name: ONE_SPAN[name] for name in kept}
    | {
        "title": "Three spans of example 2 on suspension strings",
        "section": {
            "horizontal_tension": 21730.0,
            "strung_with_ice": True,
            "spans": [{"length": 125.88}] * 3,
            "suspensions": [STRING] * 2,
        },
        "damping": {
            "translation": damping(0.0044, 0.275, 0.55),
            "twist": damping(2.52, 5.29, 10.58),
        },
        "initial": {"seed_vertical": 1e-3, "seed_horizontal": 1e-3},
        "numerics": {"elements": 20, "time_step": 0.02},
        "run": {"stop_time": 600.0, "record_every": 2},
    }
)
result = gf.simulate(scene)

# %% Before: vertical galloping, as of one span. After: the strings swing at half the frequency.
before, after = (250.0, 300.0), (550.0, 600.0)
lean = result.dataset.string_lean_across.sel(tower=1, line_phase=1)


def swing(start, stop):
    """Half peak-to-peak of the sideways displacement of the first clamp [m]."""
    return 0.5 * STRING["length"] * float(np.ptp(np.sin(lean.sel(time=slice(start, stop)).values)))


def frequency(history, below=math.inf):
    """Dominant frequency [Hz] of a history, of those below a bound."""
    values, step = history.values, float(history.time[1] - history.time[0])
    spectrum = np.abs(np.fft.rfft((values - values.mean()) * np.hanning(len(values))))
    hertz = np.fft.rfftfreq(len(values), step)
    return float(hertz[np.where(hertz < below, spectrum, 0.0).argmax()])


for name, window in (("before", before), ("after", after)):
    middle = result.between(*window, span=2)
    print(
        f"{name:6} vertical {middle['u2'].amplitude:.2f} m at {middle['u2'].frequency_hz:.3f} Hz,"
        f" sideways {middle['u3'].amplitude:.2f} m, clamps {swing(*window):.2f} m"
    )

# %% The picture: growth, and the path of mid-span and clamp before and after.
from matplotlib.figure import Figure  # noqa: E402

figure = Figure(figsize=(9.0, 5.5), layout="constrained")
left = figure.add_gridspec(1, 2, width_ratios=(1.6, 1.0))
top, bottom = (figure.add_subplot(part) for part in left[0].subgridspec(2, 1))
path = figure.add_subplot(left[1])
middle = result.bundle(span=2)
top.plot(middle.time, middle.u2, color="#0072B2", linewidth=0.4)
top.set(ylabel="vertical, middle span (m)")
bottom.plot(lean.time, STRING["length"] * np.sin(lean), color="#D55E00", linewidth=0.4)
bottom.set(xlabel="time (s)", ylabel="sideways, first clamp (m)")
for window, colour, label in ((before, "#999999", "before"), (after, "#0072B2", "after")):
    part = middle.sel(time=slice(window[1] - 20.0, window[1]))
    path.plot(part.u3, part.u2, color=colour, linewidth=0.6, label=label)
path.set(xlabel="sideways (m)", ylabel="vertical (m)", title="path of mid-span", aspect="equal")
path.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
folder = Path(tempfile.mkdtemp(prefix="gallop-"))
print("wrote", save_figure(figure, folder / "strings.png"))

# %%
late = lean.sel(time=slice(400.0, 600.0))
vertical = frequency(middle.u2.sel(time=slice(400.0, 600.0)))
ratio = frequency(late, below=0.9 * vertical) / vertical
print(f"the strings swing at {ratio:.3f} of the vertical frequency")
assert abs(result.between(*before, span=2)["u2"].amplitude - 1.38) < 0.03
assert swing(*before) < 0.1
assert swing(400.0, 600.0) > 0.3
assert abs(ratio - 0.5) < 0.03
