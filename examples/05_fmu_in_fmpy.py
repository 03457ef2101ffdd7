# %% [markdown]
# # The span as an FMU, with a gust as input
#
# Any FMI 2.0 tool can run the FMU; this script uses FMPy. The wind comes from a table of the host:
# 4 m/s, a gust up to 9 m/s, and 4 m/s again. The wind is constant in each communication step.

# %%
import tempfile
from pathlib import Path

import fmpy
import numpy as np

import gallop_fmu as gf

scene = gf.load_scene("example3").with_values({"numerics.time_step": 0.01})
folder = Path(tempfile.mkdtemp(prefix="gallop-"))
fmu = gf.export_fmu(scene, folder / "example3.fmu")
for row in gf.check_fmu(fmu).rows:
    print("passed" if row.ok else "FAILED", row.name, "-", row.detail)

# %% The gust, and the run. FMPy warns of inputs that are not in the table; they keep their start
# values.
time = np.array([0.0, 10.0, 12.0, 16.0, 20.0, 60.0])
speed = np.array([4.0, 4.0, 9.0, 9.0, 4.0, 4.0])
gust = np.rec.fromarrays([time, speed], names=["time", "wind_speed"])
recorded = fmpy.simulate_fmu(
    str(fmu),
    stop_time=60.0,
    output_interval=0.02,
    input=gust,
    output=[
        "wind_speed",
        "midspan.x2",
        "midspan.x3",
        "midspan.tension",
        "support.left.f1",
        "status",
    ],
)

# %% The same gust as part of a scene. Here the wind also changes within a step.
history = {"kind": "table", "time": time.tolist(), "value": speed.tolist()}
alone = gf.simulate(
    scene.with_values({"wind.speed": None, "wind.history": history}), 60.0, record_every=2
)
difference = np.max(np.abs(recorded["midspan.x3"] - alone.midspan().u3.values))
blown = float(np.max(recorded["midspan.x3"]))
print(f"displaced by {blown:.4f} m; largest difference from gallop_fmu.simulate {difference:.5f} m")

# %%
assert np.all(recorded["status"] == 0)
assert abs(blown - 0.2038) < 0.0005  # 0.2038 m
assert difference < 0.002  # 0.0017 m
