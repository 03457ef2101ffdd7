# %% [markdown]
# # Oblique and gusty wind
#
# From which direction must the wind blow for example 3 to gallop, and do gusts prevent it? The
# force on the conductor depends on the part of the wind that is normal to it, so the critical wind
# grows as one over the cosine of the yaw. Gusts are turbulence with a Kaimal spectrum, which is
# coherent over a few metres only. The coefficient curve is a reconstruction.

# %%
import math
import tempfile
from pathlib import Path

from matplotlib.figure import Figure

import gallop_fmu as gf
import modal
from gallop_fmu.plots import save_figure

SPEED, STOP = 5.5, 900.0  # [m/s], [s]
span = gf.load_scene("example3").with_values({"wind.speed": SPEED, "run.stop_time": STOP})

# %% The critical wind of the first vertical mode over the yaw from the normal of the line.
critical = {}
for yaw in (0.0, 20.0, 40.0, 60.0):
    oblique = span.with_values({"wind.direction_deg": yaw})
    critical[yaw] = next(
        found.wind_speed
        for found in modal.critical_wind_speed(oblique, 2)
        if found.mode.family == "vertical"
    )
    normal = critical[yaw] * math.cos(math.radians(yaw))
    print(f"yaw {yaw:2.0f} deg: galloping from {critical[yaw]:5.2f} m/s, {normal:.3f} m/s normal")
    assert abs(normal / critical[0.0] - 1.0) < 0.01

# %% Three runs: steady from the side, steady at 40 degrees, and gusty from the side.
turbulence = {
    "spectrum": "kaimal",
    "intensity": 0.1,
    "intensity_upwards": 0.05,
    "length_scale": 60.0,  # m
    "length_scale_upwards": 15.0,
    "seed": 7,
}
winds = {
    "steady": {},
    "40 deg": {"wind.direction_deg": 40.0},
    "gusty": {"wind.turbulence": turbulence},
}
runs = {name: gf.simulate(span.with_values(wind), record_every=5) for name, wind in winds.items()}
for name, run in runs.items():
    late = run.steady(window=300.0)
    print(
        f"{name:7} vertical {late['u2'].deviation:.3f} m, horizontal {late['u3'].deviation:.3f} m"
        f" (standard deviations over 300 s): {run.motion}"
    )
assert runs["40 deg"].steady(window=300.0)["u2"].deviation < 1e-3

# %%
figure = Figure(figsize=(7.1, 4.8), layout="constrained")
for axes, (name, run) in zip(
    figure.subplots(3, 1, sharex=True, sharey=True), runs.items(), strict=True
):
    middle = run.midspan()
    axes.plot(middle.time, middle.u2, color="#0072B2", linewidth=0.4, label="vertical")
    axes.plot(middle.time, middle.u3, color="#D55E00", linewidth=0.4, label="horizontal")
    axes.set_ylabel(f"{name} [m]")
axes.legend(loc="lower left", ncols=2, frameon=False)
axes.set(xlabel="time [s]", xlim=(0.0, STOP))
folder = Path(tempfile.mkdtemp(prefix="gallop-"))
print("wrote", save_figure(figure, folder / "oblique_and_gusty.png"))

# %% The dataset of a run contains its gusts, so that the run can be repeated.
gusts = runs["gusty"].dataset.gust_along
print(f"{gusts.sizes['gust_station']} stations, intensity {float(gusts.std()):.3f}")
found = runs["gusty"].steady(window=300.0)["u2"].deviation
print(f"vertical standard deviation in gusts: {found:.3f} m")
assert abs(found - 0.313) < 0.002
