# %% [markdown]
# # Coefficients of your own ice shape
#
# Wind tunnels give lift, drag and moment at certain attack angles. A CSV file with the header
# `angle_deg,lift,drag,moment` is all that is needed; monotone cubics join the points. The numbers here are made up.

# %%
import csv
import tempfile
from pathlib import Path

import numpy as np

import gallop_fmu as gf

folder = Path(tempfile.mkdtemp(prefix="gallop-"))
angles = np.arange(0.0, 361.0, 5.0)
with (folder / "ice.csv").open("w", newline="") as file:
    table = csv.writer(file)
    table.writerow(["angle_deg", "lift", "drag", "moment"])
    for angle in angles:
        twice = 2.0 * np.radians(angle % 360.0)
        table.writerow([angle, 1.2 * np.sin(twice), 1.1 - 0.2 * np.cos(twice), 0.05 * np.sin(twice)])

# %% The line of example 2 with this ice, at an attack angle where the lift falls. The file is read at once, so the
# scene needs it no more.
scene = gf.load_scene("example2").with_values(
    {
        "title": "The line of example 2 with another ice shape",
        "aerodynamics": {"kind": "table", "file": str(folder / "ice.csv"), "outside": "periodic"},
        "ice.attack_angle_deg": 90.0,
        "wind.speed": 4.0,
        "run.stop_time": 800.0,
    }
)

# %% Den Hartog: attack angles with dCL/dalpha + CD < 0 can gallop.
curve = scene.aerodynamics.curve()
fine = np.arange(0.0, 180.0, 0.1)
unstable = fine[curve.den_hartog(np.radians(fine)) < 0.0]
print(f"Den Hartog's condition holds from {unstable[0]:.1f} to {unstable[-1]:.1f} deg (and 180 deg further on)")

# %%
steady = gf.simulate(scene).steady()
print(f"vertical amplitude {steady['u2'].amplitude:.3f} m at {steady['u2'].frequency_hz:.3f} Hz")

# %%
assert np.allclose([unstable[0], unstable[-1]], [60.0, 120.0], atol=0.5)  # where cos(2 alpha) < -1/2; found 60.4, 119.6
assert abs(steady["u2"].amplitude - 1.702) < 0.005  # 1.7023 m
