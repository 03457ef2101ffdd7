# %% [markdown]
# # A line of your own
#
# A dozen numbers make a scene. Give the sag or the horizontal tension and the other follows. Values are checked: a
# wrong unit or a misspelt name ends in a message that names the field and the cure.

# %%
import math
import tempfile
from pathlib import Path

import gallop_fmu as gf

scene = gf.Scene.from_dict(
    {
        "title": "A bare span of 250 m in a wind of 15 m/s",
        "span": {"length": 250.0, "sag": 6.0},
        "conductor": {
            "diameter": 0.0266,
            "mass_per_length": 1.33,
            "axial_stiffness": 28.0e6,
            "torsional_stiffness": 160.0,
            "torsional_inertia": 1.2e-4,
        },
        "wind": {"speed": 15.0, "air_density": 1.225},
        "aerodynamics": {
            "kind": "polynomial",
            "valid_from_deg": -180.0,
            "valid_to_deg": 180.0,
            "outside": "periodic",
            "lift": [0.0],
            "drag": [1.1],
            "moment": [0.0],
        },
        "initial": {"wind": "mean_wind_equilibrium"},
        "numerics": {"elements": 20, "time_step": 0.02},
    }
)

# %% TOML there and back: the file that `gallop-fmu run my_line.toml` reads.
path = Path(tempfile.mkdtemp(prefix="gallop-")) / "my_line.toml"
scene.save(path)
assert gf.load_scene(path) == scene

# %% A mistake is told.
try:
    scene.with_values({"span.sagg": 6.0})
except gf.SceneError as problem:
    print(problem)

# %% The initial state, compared with the parabola: H = m g L^2 / (8 sag).
equilibrium = gf.Model(scene).equilibrium()
parabola = 1.33 * 9.81 * 250.0**2 / (8.0 * 6.0)
print(f"horizontal tension {equilibrium.horizontal_tension:.0f} N, parabola {parabola:.0f} N")

# %% The run starts in equilibrium with the wind: the plane of the span is turned by atan(drag / weight), and the wind
# stretches the conductor, so the sag within that plane grows.
result = gf.simulate(scene, stop_time=20.0)
last = result.midspan().isel(time=-1)
drag = 0.5 * 1.225 * 15.0**2 * 0.0266 * 1.1
swing = math.degrees(math.atan2(last.u3.item(), equilibrium.sag - last.u2.item()))
expected = math.degrees(math.atan(drag / (1.33 * 9.81)))
print(f"blown out by {last.u3.item():.3f} m; plane turned by {swing:.2f} deg, by statics {expected:.2f} deg")

# %%
assert abs(equilibrium.horizontal_tension / parabola - 1.0) < 0.005
assert abs(swing - expected) < 0.2
