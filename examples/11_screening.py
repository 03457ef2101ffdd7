# %% [markdown]
# # Screening of a span, and design changes
#
# Does galloping of example 3 start the horizontal swing, above which wind speed, and which change
# of the design prevents it? Then the linear model of the same span with functions of
# python-control: poles over the wind speed, step response, frequency response. The coefficient
# curve is a reconstruction.

# %%
import tempfile
from pathlib import Path

import control
import numpy as np

import gallop_fmu as gf
import modal
from gallop_fmu.plots import save_figure
from modal.plots import ratio_figure, screening_figure, tracking_figure

folder = Path(tempfile.mkdtemp(prefix="gallop-"))
scene = gf.load_scene("example3")
found = modal.screen(scene)
print(f"{found.risk}: {found.reason}")
print(
    f"closed-form estimate: from {found.estimate.onset_wind_speed:.2f} m/s, at"
    f" {found.estimate.threshold_amplitude:.2f} m"
)
print("wrote", save_figure(screening_figure(found), folder / "screening.png"))

# %% The ratio over tension and temperature, and the tension at which it is 2.
tensions, warmer = np.linspace(10e3, 24e3, 8), np.linspace(-30.0, 40.0, 8)
plane = modal.ratio_map(
    scene, "span.horizontal_tension", tensions, against=("temperature_change", warmer)
)
print("wrote", save_figure(ratio_figure(plane), folder / "ratio.png"))
(resonant,) = modal.crossings(scene, "span.horizontal_tension", [10e3, 24e3])
print(f"f_v/f_h is 2 at {resonant:.0f} N")
print(modal.suggest_design_changes(scene)[0].sentence)

# %% On an inclined span the first two vertical modes do not cross, they veer; the ratio is
# undefined in between.
inclined = scene.with_values(
    {"span.sag": None, "span.height_difference": 40.0, "numerics.elements": 10}
)
modes = modal.track_modes(
    inclined, "span.horizontal_tension", list(np.linspace(11e3, 16e3, 21)), count=4
)
print("wrote", save_figure(tracking_figure(modes), folder / "veering.png"))

# %% With 10 % more tension the same wind does not start the swing.
tighter = modal.screen(scene.with_values({"span.sag": None, "span.horizontal_tension": 16.5e3}))
print(f"with 16.5 kN {tighter.risk}: {tighter.reason}")

# %% The linear model, with python-control.
for wind in (4.0, 5.5):
    poles = modal.linear_model(scene.with_values({"wind.speed": wind}), modes=2).poles()
    print(f"{wind} m/s:", ", ".join(f"{pole:.3f}" for pole in poles if pole.imag > 0.0))
calm = modal.linear_model(scene.with_values({"wind.speed": 2.0}), modes=6)
push = control.step_response(calm["midspan_u3", "wind_speed"], np.linspace(0.0, 120.0, 1201))
magnitude, _, _ = control.frequency_response(
    calm["midspan_u3", "wind_speed"], 2.0 * np.pi * np.array([0.01, 0.3775])
)
print(
    f"a gust of 1 m/s displaces mid-span by {push.outputs[-1]:.4f} m, {magnitude[1]:.4f} m"
    " at resonance"
)

# %%
assert found.risk == "certain"
assert abs(found.onset_wind_speed - 5.039) < 0.002
