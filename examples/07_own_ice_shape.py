# %% [markdown]
# # Coefficients of your own ice shape
#
# Wind-tunnel tests give lift, drag and moment at several attack angles. Put them into a CSV file
# with the header `angle_deg,lift,drag,moment`. Monotone cubics join the points; a table over a
# whole turn repeats. Mass and eccentricity of the ice follow from shape, thickness and density in
# the TOML file. The coefficients here are invented.

# %%
from pathlib import Path

import numpy as np

import gallop_fmu as gf

scene = gf.load_scene(Path(__file__).with_name("07_own_ice_shape.toml"))
print(scene.title)
ice = scene.ice
print(
    f"ice: {ice.mass_per_length:.3f} kg/m, its centre"
    f" {1e3 * ice.first_moment_x2 / ice.mass_per_length:.1f} mm up"
)

# %% Den Hartog: galloping is possible at attack angles with dCL/dalpha + CD < 0.
curve = scene.aerodynamics.curve()
fine = np.arange(0.0, 180.0, 0.1)
unstable = fine[curve.den_hartog(np.radians(fine)) < 0.0]
print(
    f"Den Hartog's condition holds from {unstable[0]:.1f} to {unstable[-1]:.1f} deg (and 180 deg"
    " further on)"
)

# %%
steady = gf.simulate(scene).steady()
print(f"vertical amplitude {steady['u2'].text('m')} at {steady['u2'].frequency_hz:.3f} Hz")

# %% The formulas from which the file was made give 60 and 120 deg; rounded points 10 deg apart give
# 61.1 and 118.9.
assert np.allclose([unstable[0], unstable[-1]], [60.0, 120.0], atol=1.5)
assert abs(steady["u2"].amplitude - 1.902) < 0.005  # 1.9024 m
