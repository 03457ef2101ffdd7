# %% [markdown]
# # Forced motion: example 1 of the paper
#
# A bare span of 100 m without wind and damping. A load pulse of 1.5 s moves it up and sideways and
# twists it, at 39 points. The history of the load is a reconstruction of a figure that is not
# available to us. The reference values were computed with OpenSees for the same load (160
# corotational elements), and by statics for the twist.

# %%
import math
import tempfile
from pathlib import Path

import numpy as np

import gallop_fmu as gf
from gallop_fmu.plots import histories, save_figure

scene = gf.load_scene("example1")
pulse = scene.loads[0]
print(f"{pulse.evenly_spaced} loads of {pulse.force} N and {pulse.torque} N m")
result = gf.simulate(scene)
midspan = result.midspan()

# %% The vertical response is mainly the rise that a sideways swing causes.
lowest, highest = 1000.0 * midspan.u2.min().item(), 1000.0 * midspan.u2.max().item()
left, right = midspan.u3.min().item(), midspan.u3.max().item()
print(f"u2 in [{lowest:.2f}, {highest:.2f}] mm, OpenSees [-3.29, 11.37] mm")
print(f"u3 in [{left:.4f}, {right:.4f}] m, OpenSees [-0.2758, 0.2759] m")

# %% The twist follows the load. Under a constant torque t per metre it is t L^2 / (8 GJ) at
# mid-span.
torque_per_length = pulse.torque * (pulse.evenly_spaced + 1) / scene.span.length
static = math.degrees(
    torque_per_length * scene.span.length**2 / (8.0 * scene.conductor.torsional_stiffness)
)
twist = np.degrees(midspan.theta.max().item())
print(f"largest twist {twist:.2f} deg, static {static:.2f} deg")

# %%
folder = Path(tempfile.mkdtemp(prefix="gallop-"))
print("wrote", save_figure(histories(result, ("u2", "u3", "theta")), folder / "pulse.pdf"))

# %%
assert np.allclose([lowest, highest], [-3.29, 11.37], atol=0.02)  # -3.289, 11.366 mm
assert np.allclose([left, right], [-0.2758, 0.2759], atol=2e-4)  # -0.2757, 0.2758 m
assert (
    abs(twist - static) < 0.1
)  # 18.95 deg; above 18.87 deg, because the load rises in finite time
