# %% [markdown]
# # A section of five spans from a table of towers
#
# The table has one row per tower: span, height, string. The conductor is a word of the catalogue;
# tension at stringing, ice and wind are options of `gallop-fmu new --section`. The coefficient
# curve is that of example 2 of the paper, a reconstruction. The result tells what each span does,
# how the strings lean, and which force reaches each tower.

# %%
import subprocess
import sys
import tempfile
from pathlib import Path

import gallop_fmu as gf

folder = Path(tempfile.mkdtemp(prefix="gallop-"))
table, file = Path(__file__).parent / "15_towers.csv", folder / "section.toml"
command = Path(sys.executable).with_name("gallop-fmu")
options = "--stringing-percent 20 --ice-thickness 0.006 --attack-angle-deg 10 --wind-speed 4"
options += " --coefficients example2"
subprocess.run(
    [command, "new", file, "--section", table, "--conductor", "Drake", *options.split()], check=True
)

# %% Ice and mean wind act on the whole section: strings lean, tensions differ from span to span.
scene = gf.load_scene(file).with_values(
    {"numerics.time_step": 0.02, "initial.seed_vertical": 0.1, "run.record_every": 5}
)
result = gf.simulate(scene, stop_time=600.0)
print(result.spans[["span", "sag", "horizontal_tension", "u2_amplitude", "u3_amplitude"]].round(3))

# %% The pull of the string and half of its weight is the force on a suspension tower.
strings = result.strings[["tower", "lean_along_at_rest", "pull_at_rest", "pull_min", "pull_max"]]
print(strings.round(3))
towers = result.towers.set_index("tower")
print(towers[["kind", "preload_x1", "force_x1_min", "force_x1_max", "force_x2_min"]].round(0))
for warning in result.warnings:
    print("warning:", warning)

# %% The unbalanced pull of a suspension tower is small beside that of a tension tower.
assert towers.force_x1_max[0] > 2.0e4
assert abs(towers.preload_x1[[1, 2, 3, 4]]).max() < 500.0
