# %% [markdown]
# # The FMU in FMPy
#
# The span as an FMU of FMI 2.0: any tool with FMI can run it. Here FMPy does, with a gust as input.

# %%
import fmpy
import numpy as np
import pandas as pd

import gallop_fmu as gf

fmu = gf.export_fmu("example3", "example3.fmu")
for row in gf.check_fmu(fmu).rows:
    print("passed" if row.ok else "FAILED", row.name)

# %% [markdown]
# 4 m/s, a gust up to 9 m/s, and 4 m/s again. FMPy warns of inputs that are not in the table; they
# keep their start values.

# %%
time = np.array([0.0, 10.0, 12.0, 16.0, 20.0, 60.0])
speed = np.array([4.0, 4.0, 9.0, 9.0, 4.0, 4.0])
recorded = fmpy.simulate_fmu(
    str(fmu),
    stop_time=60.0,
    output_interval=0.1,
    input=np.rec.fromarrays([time, speed], names=["time", "wind_speed"]),
    output=["wind_speed", "midspan.x3", "midspan.tension", "status"],
)
pd.DataFrame(recorded[::100]).round(3)

# %%
from matplotlib.figure import Figure

from gallop_fmu.plots import shown_in_notebooks

figure = Figure(figsize=(7.0, 2.6), layout="constrained")
axes = figure.subplots()
axes.plot(recorded["time"], recorded["midspan.x3"])
axes.set_xlabel("time [s]")
axes.set_ylabel("horizontal displacement\nof mid-span [m]")
shown_in_notebooks(figure)

# %%
assert np.all(recorded["status"] == 0)
