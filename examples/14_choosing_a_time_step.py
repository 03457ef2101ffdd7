# %% [markdown]
# # Choosing a time step, or a tolerance
#
# Example 3 reaches a steady swing. This script measures the error of its amplitude for several time
# steps. Newmark's method, the default, has equal steps; its error is proportional to their square.
# Gauss's method of order six allows longer steps; with a tolerance it chooses them itself.

# %%
import tempfile
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

import gallop_fmu as gf
from gallop_fmu.plots import save_figure

STOP, WINDOW, RECORD = 900.0, 100.0, 0.04
scene = gf.load_scene("example3")


def swing(time_step=RECORD, **numerics):
    """Amplitudes at mid-span [m], vertical and horizontal, and the number of steps."""
    values = {f"numerics.{name}": value for name, value in numerics.items()}
    values |= {
        "numerics.time_step": time_step,
        "run.record_every": round(max(RECORD, time_step) / time_step),
    }
    result = gf.simulate(scene.with_values(values), STOP)
    steady = result.steady(WINDOW)
    return np.array([steady["u2"].amplitude, steady["u3"].amplitude]), result.dataset.attrs["steps"]


# %% The reference: with a smaller tolerance the first four digits do not change.
RESOLVED = 2e-5  # relative error of this reference
right, most = swing(tolerance=1e-6)
print(f"vertical {right[0]:.5f} m, horizontal {right[1]:.5f} m, in {most} steps")

# %% Equal steps, and tolerances.
STEPS = [0.08, 0.04, 0.02, 0.01]
TOLERANCES = [1e-2, 1e-3, 1e-4]
runs = {
    "newmark": [swing(step) for step in STEPS],
    "gauss6": [swing(step, integrator="gauss6") for step in STEPS[:2]],
    "tolerance": [swing(tolerance=tolerance) for tolerance in TOLERANCES],
}
settings = {"newmark": STEPS, "gauss6": STEPS[:2], "tolerance": TOLERANCES}
errors = {
    name: np.array([amplitudes / right - 1.0 for amplitudes, _ in found])
    for name, found in runs.items()
}
print("                     steps   vertical  horizontal")
for name, found in runs.items():
    for setting, (_, steps), error in zip(settings[name], found, errors[name], strict=True):
        print(f"{name:10} {setting:7g} {steps:7}   {error[0]:+8.3%}    {error[1]:+8.3%}")

# %% A period is 1.5 s, that is 75 steps of 0.02 s. If steps are too long for the axial waves of a
# rough start, the run has a warning, and `gallop_fmu.energy_balance` gives the energy error.
figure = Figure(figsize=(4.5, 3.2), layout="constrained")
axes = figure.subplots()
for name, marker, colour in (
    ("newmark", "o", "#0072B2"),
    ("gauss6", "s", "#D55E00"),
    ("tolerance", "^", "#009E73"),
):
    steps = [steps for _, steps in runs[name]]
    axes.loglog(
        steps,
        np.maximum(np.abs(errors[name][:, 0]), RESOLVED),
        marker=marker,
        color=colour,
        label=name,
    )
axes.axhspan(1e-7, RESOLVED, color="0.9", label="not resolved")
axes.set(
    ylim=(RESOLVED / 3.0, 0.1),
    xlabel="steps in 900 s",
    ylabel="error of the vertical amplitude [1]",
)
axes.legend(frameon=False)
print("wrote", save_figure(figure, Path(tempfile.mkdtemp(prefix="gallop-")) / "steps.png"))

# %% With 0.02 s the default is within half a per cent. A tolerance of 1e-3 is much more accurate,
# in a seventh of the steps.
order = np.log2(errors["newmark"][:-1, 0] / errors["newmark"][1:, 0])
assert np.all(np.abs(order - 2.0) < 0.06)  # 1.98 and 1.99
assert [f"{error:+.1%}" for error in errors["newmark"][1:, 0]] == ["+1.6%", "+0.4%", "+0.1%"]
assert np.all(np.abs(errors["tolerance"][1]) < 1e-4)  # +0.002 % and +0.000 %
assert abs(runs["tolerance"][1][1] - 6500) < 100  # 6529, against 45000
