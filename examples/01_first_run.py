# %% [markdown]
# # A first run
#
# Example 3 of Liu, Yan, Zhang and Zhou (2009): an iced span gallops vertically in a wind of 5.5
# m/s. Later the galloping starts a horizontal swing at half its frequency. The coefficient curve is
# a reconstruction, because the paper's figure is not available to us.

# %%
import tempfile
from pathlib import Path

import gallop_fmu as gf
from gallop_fmu.plots import overview, save_figure

scene = gf.load_scene("example3").with_values({"wind.speed": 5.5})
result = gf.simulate(scene, stop_time=900.0)
print(result.outcome.sentence)

# %% The histories are an xarray.Dataset with units.
print(result.midspan()[["u2", "u3", "theta", "tension"]])

# %% Half peak-to-peak, mean and frequency at mid-span over the last 100 s.
steady = result.steady(window=100.0)
for name in ("u2", "u3", "theta", "tension"):
    unit = result.dataset[name].attrs["units"]
    print(f"{name:8} {steady[name].amplitude:10.4f} {unit:4} at {steady[name].frequency_hz:.4f} Hz")

# %% A plot of the run, and all histories in one NetCDF file.
folder = Path(tempfile.mkdtemp(prefix="gallop-"))
print(
    "wrote",
    save_figure(overview(result), folder / "first_run.png"),
    result.save(folder / "first_run.nc"),
)

# %%
assert abs(steady["u2"].amplitude - 0.442) < 0.002  # 0.4420 m
assert abs(steady["u3"].amplitude - 0.1915) < 0.001  # 0.1915 m
