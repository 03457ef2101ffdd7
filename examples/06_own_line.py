# %% [markdown]
# # A line of your own
#
# `06_own_line.toml` contains the data of a line: code word of the conductor, span, stringing
# tension, ice, wind. The scene is computed from them when the file is read; each number has its
# source. `gallop-fmu new` does the same on the command line.

# %%
from pathlib import Path

import gallop_fmu as gf

scene = gf.load_scene(Path(__file__).with_name("06_own_line.toml"))
print(scene.title)
for path, source in scene.sources.items():
    print(f"  {path:32} {source}")

# %% The conductor, from the table.
drake = gf.find_conductor("Drake")
print(
    f"EA {drake.axial_stiffness / 1e6:.2f} MN, rated strength {drake.rated_strength / 1e3:.1f} kN"
)

# %% A typing error gives a message with similar names.
try:
    gf.find_conductor("Drak")
except gf.SceneError as problem:
    print(problem)

# %% The iced span in equilibrium, compared with the parabola: sag = m g L^2 / (8 H).
equilibrium = gf.Model(scene).equilibrium()
mass = scene.conductor.mass_per_length + scene.ice.mass_per_length
parabola = mass * 9.81 * 300.0**2 / (8.0 * equilibrium.horizontal_tension)
print(
    f"H = {equilibrium.horizontal_tension / 1e3:.2f} kN, sag {equilibrium.sag:.2f} m, parabola"
    f" {parabola:.2f} m"
)

# %% Does it gallop?
steady = gf.simulate(scene).steady()
print(f"vertical {steady['u2'].text('m')} at {steady['u2'].frequency_hz:.3f} Hz")

# %%
assert abs(equilibrium.sag / parabola - 1.0) < 0.005
assert abs(steady["u2"].amplitude - 1.515) < 0.005  # 1.5149 m
