# %% [markdown]
# # Figure 5: displacements and twist at mid-span of example 1
#
# The paper compares its element with ABAQUS. Here the comparison is with OpenSees (160 corotational
# elements). Figure 4, the history of the loads, is not available to us: the pulse is a
# reconstruction, so amplitudes can be compared with the axes of figure 5 only.

# %%
import tempfile
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

import gallop_fmu as gf
from gallop_fmu.plots import save_figure

DATA = Path(__file__).resolve().parents[2] / "tests" / "peers" / "data"
reference = np.genfromtxt(DATA / "example1_pulse_opensees.csv", delimiter=",", names=True)

result = gf.simulate(gf.load_scene("example1"), stop_time=10.0)
midspan = result.midspan()

# %%
figure, panels = plt.subplots(1, 3, figsize=(12, 3.2), layout="constrained")
panels[0].plot(midspan.time, midspan.u2, label="this program")
panels[0].plot(reference["t_s"], reference["u2_m"], "--", label="OpenSees")
panels[1].plot(midspan.time, midspan.u3)
panels[1].plot(reference["t_s"], reference["u3_m"], "--")
panels[2].plot(midspan.time, np.degrees(midspan.theta))
labels = ("(a) u2 [m]", "(b) u3 [m]", "(c) theta [deg]")
limits = ((-4e-3, 12e-3), (-0.3, 0.4), (0.0, 25.0))  # the axes of the paper
for panel, label, limit in zip(panels, labels, limits, strict=True):
    panel.set(xlabel="t [s]", ylabel=label, xlim=(0.0, 10.0), ylim=limit)
panels[0].legend()
print("wrote", save_figure(figure, Path(tempfile.mkdtemp(prefix="gallop-")) / "figure05.pdf"))

# %%
differences = {}
for name in ("u2", "u3"):
    ours = np.interp(reference["t_s"], midspan.time, midspan[name])
    differences[name] = np.sqrt(
        np.mean((ours - reference[f"{name}_m"]) ** 2) / np.var(reference[f"{name}_m"])
    )
    print(f"{name}: RMS difference from OpenSees {100 * differences[name]:.2f} % of the motion")
twist = np.degrees(midspan.theta.max().item())
print(f"twist up to {twist:.2f} deg; it follows the load, as in the paper")

# %%
assert differences["u2"] < 4e-3  # 0.25 %
assert differences["u3"] < 6e-4  # 0.03 %
assert abs(twist - 18.95) < 0.02  # 18.95 deg
