# %% [markdown]
# # Screening a corridor
#
# A table of spans, one a row, as it comes out of a line's records: what differs from span to span stands in columns
# that are named as in a scene file; all else is that of example 3, whose coefficient curve is a reconstruction. All
# are screened for the 2:1 swing first. That takes a second each, so it does for thousands. Those that are at risk are
# then simulated, over three wind speeds.

# %%
import csv
import tempfile
from pathlib import Path

import gallop_fmu as gf
import modal

folder = Path(tempfile.mkdtemp(prefix="gallop-"))
table = folder / "corridor.csv"
SPANS = [  # length [m], sag [m]; the last has lost its decimal point
    ("A1-A2", "rock", 125.88, 2.12),
    ("A2-A3", "rock", 110.0, 1.55),
    ("A3-A4", "forest", 140.0, 2.50),
    ("A4-A5", "lake", 12550.0, 2.12),
]
with table.open("w", newline="") as file:
    writer = csv.writer(file)
    writer.writerow(["name", "label.ground", "span.length", "span.sag", "span.horizontal_tension"])
    writer.writerows([*span, "none"] for span in SPANS)  # none: the tension follows from the sag
base = gf.load_scene("example3").with_values({"numerics.time_step": 0.02, "run.record_every": 2})

# %% Screening, in a process for each core. The same call again after Ctrl-C, or worse, computes what is missing.
found = modal.screen_spans(base, table=table, highest_wind=6.5, out=folder / "risk.nc")
print(found.dataset[["name", "ratio", "risk", "onset_wind_speed"]].to_dataframe().to_string(index=False))
for row in range(found.failed.sizes["run"]):
    print(f"\n{found.failed.name.values[row]}: {found.failed.outcome.values[row]}; {found.failed.message.values[row]}")

# %% Simulation of those at risk, in a thread for each core: every one at every wind speed.
certain = found.dataset.name.values[found.dataset.risk.values == "certain"]
rows = [row for row in gf.read_spans(table) if row["name"] in certain]
runs = gf.sweep(base, {"wind.speed": [4.5, 5.0, 5.5]}, table=rows, stop_time=1200.0, out=folder / "swing.nc")
grid = runs.grid()  # xarray, with one dimension for the spans and one for the wind
print("\nhorizontal swing [m], half peak-to-peak")
print(grid.u3_amplitude.to_pandas().round(3))

# %% The simulation swings where the screening says that it will: from its wind on, and not before.
swings = grid.u3_amplitude > 0.05
onset = found.dataset.set_index(run="name").onset_wind_speed.sel(run=certain)
predicted = grid["wind.speed"].values[None, :] > onset.values[:, None]
print(f"\n{int((swings.values == predicted).sum())} of {swings.size} as predicted")
assert (swings.values == predicted).all()
assert abs(float(grid.u3_amplitude.sel({"name": "A1-A2", "wind.speed": 5.5})) - 0.182) < 0.002
