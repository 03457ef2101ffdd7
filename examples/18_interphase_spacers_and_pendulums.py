# %% [markdown]
# # Interphase spacers and pendulums, before and after
#
# Two measures against galloping, on the span of the paper's example 2 between rigid ends. First,
# two phases one above the other: interphase spacers hold phases apart that move against each other,
# and do nothing to phases that gallop alike. Second, detuning pendulums on a single conductor: they
# lower its torsional frequency, so the twist changes, and the galloping grows more slowly; they
# need not stop it. The coefficient curve is a reconstruction.

# %%
import gallop_fmu as gf
from gallop_fmu.scene.line_scene import LineScene

ONE_SPAN = gf.load_scene("example2").model_dump(mode="json", exclude_none=True)
COMMON = {name: ONE_SPAN[name] for name in ("conductor", "ice", "wind", "aerodynamics", "damping")}
COMMON |= {
    "section": {
        "horizontal_tension": 21730.0,
        "strung_with_ice": True,
        "spans": [{"length": 125.88}],
    },
    "initial": {"seed_vertical": 1e-3, "seed_horizontal": 1e-3},
    "numerics": {"elements": 15, "time_step": 0.02},
    "run": {"stop_time": 250.0, "record_every": 5},
}
PHASES = [{"name": "top", "offset": [3.0, 0.0]}, {"name": "bottom", "offset": [0.0, 0.0]}]
PUSH = {
    "kind": "pulse",
    "initial": 0.0,
    "peak": 1.0,
    "start": 0.0,
    "rise": 1.0,
    "fall_start": 1.5,
    "fall": 0.5,
}


def simulated(title, **tables):
    """Result of the span with further tables of the scene."""
    return gf.simulate(LineScene.from_dict({**COMMON, "title": title, **tables}))


# %% Phases that gallop alike, and phases that are pushed against each other.
spacers = [
    {"kind": "interphase_spacer", "span": 1, "station": station, "phases": [1, 2]}
    for station in (1.0 / 3.0, 2.0 / 3.0)
]
apart = [
    {"span": 1, "phase": phase, "position": 0.5, "force": [0.0, up, 0.0], "law": PUSH}
    for phase, up in ((1, -1500.0), (2, 1500.0))
]
distances = {}
for name, devices, loads in (
    ("alike", [], []),
    ("alike, with spacers", spacers, []),
    ("pushed together", [], apart),
    ("pushed together, with spacers", spacers, apart),
):
    result = simulated(name, phases=PHASES, devices=devices, loads=loads)
    distances[name] = result.clearances["smallest"].min()
    amplitude = result.steady(window=50.0, phase=1)["u2"].amplitude
    print(f"{name:30} vertical {amplitude:.2f} m, smallest distance {distances[name]:.2f} m")
assert distances["pushed together, with spacers"] > distances["pushed together"] + 0.1

# %% Pendulums at both thirds.
pendulums = [
    {"kind": "pendulum", "span": 1, "station": station, "mass": 20.0, "arm": 0.5}
    for station in (1.0 / 3.0, 2.0 / 3.0)
]
amplitudes = {}
for name, devices in (("none", []), ("pendulums", pendulums)):
    result = simulated(name, devices=devices)
    amplitudes[name] = result.between(150.0, 200.0)["u2"].amplitude
    frequency = result.steady()["u2"].frequency_hz
    print(f"{name:10} vertical {amplitudes[name]:.3f} m at 200 s, {frequency:.3f} Hz")
assert amplitudes["pendulums"] < amplitudes["none"]
