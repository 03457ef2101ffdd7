# %% [markdown]
# # Screening a corridor
#
# A table of spans, one a row, as it comes out of a line's records: conductor, span, ice. What all
# spans share stands in the `[line]` of a scene file; its coefficient curve is that of example 3, a
# reconstruction. All are screened for the 2:1 swing first. That takes a second each; thousands are
# best estimated first (`estimate_only=True`), thirty times as fast, and only the suspect ones
# screened. Those that are at risk are then simulated, over some wind speeds.

# %%
import tempfile
from pathlib import Path

import gallop_fmu as gf
import modal

folder = Path(tempfile.mkdtemp(prefix="gallop-"))
base, table = folder / "corridor.toml", folder / "spans.csv"
base.write_text("""\
[line]
conductor = "Drake"
stringing_percent = 20.0
ice_thickness = 0.010
attack_angle_deg = 178.0
wind_speed = 4.0
coefficients = "example3"

[numerics]
time_step = 0.02
""")
# The last row has lost its decimal point; an empty cell leaves what the scene file says.
table.write_text("""\
name,label.ground,line.conductor,line.span,line.height_difference,line.ice_thickness
A1-A2,rock,Drake,240,2.5,0.006
A2-A3,rock,Hawk,120,,
A3-A4,forest,,310,-4,
A4-A5,lake,,29500,,
""")

# %% Estimate all, in a process for each core; what cannot be computed is a row that says
# why.
look = modal.screen_spans(
    base, table=table, highest_wind=5.0, estimate_only=True, out=folder / "look.nc"
)
print(look.dataset[["name", "ratio", "suspect", "outcome"]].to_dataframe().to_string(index=False))
for name, message in zip(look.failed.name.values, look.failed.message.values, strict=True):
    print(f"\n{name}: {message}")

# %% Screening of the suspect ones. The same call again after Ctrl-C, or worse, would compute what
# is missing.
suspect = look.dataset.name.values[look.dataset.suspect.values == 1.0]
rows = [row for row in gf.read_spans(table) if row["name"] in suspect]
found = modal.screen_spans(base, table=rows, highest_wind=5.0, out=folder / "risk.nc")
print(
    found.dataset[["name", "label.ground", "ratio", "risk", "onset_wind_speed"]]
    .to_dataframe()
    .to_string(index=False)
)

# %% Simulation of those at risk, in a thread for each core: every one at every wind speed.
certain = found.dataset.name.values[found.dataset.risk.values == "certain"]
rows = [row for row in rows if row["name"] in certain]
winds = {"line.wind_speed": [2.5, 3.0, 3.6, 4.0]}
runs = gf.sweep(base, winds, table=rows, stop_time=1200.0, out=folder / "swing.nc")
grid = runs.grid()  # xarray, with one dimension for the spans and one for the wind
print("\nhorizontal swing [m], half peak-to-peak")
print(grid.u3_amplitude.to_pandas().round(3))

# %% The simulation swings where the screening says that it will: from its wind on, and not before.
swings = grid.u3_amplitude > 0.1
onset = found.dataset.set_index(run="name").onset_wind_speed.sel(run=certain)
predicted = grid["line.wind_speed"].values[None, :] > onset.values[:, None]
print(f"\n{int((swings.values == predicted).sum())} of {swings.size} as predicted")
assert (swings.values == predicted).all()
assert list(certain) == ["A3-A4"]
assert abs(float(onset.values[0]) - 3.28) < 0.01
