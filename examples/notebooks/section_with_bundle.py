# %% [markdown]
# # A section with a bundle
#
# Two spans of a twin bundle hang on a suspension string between two dead ends. The table is the
# content of a scene file; `gallop-fmu new --section` writes one from a table of towers.

# %%
import tomllib

import gallop_fmu as gf
import modal

LINE = """
title = "Two spans with a twin bundle"

[section]
horizontal_tension = 25e3                       # N, of each subconductor
spans = [{length = 200.0}, {length = 240.0, height_difference = 8.0}]
suspensions = [{kind = "string", length = 2.4, weight = 600.0}]

[bundle]
subconductors = 2
spacing = 0.45
spacers = 4
spacer_mass = 5.0

[conductor]                                     # Drake
diameter = 0.0281
mass_per_length = 1.628
axial_stiffness = 29.0e6
torsional_stiffness = 159.0
torsional_inertia = 2e-4

[ice]
mass_per_length = 0.5
attack_angle_deg = 180.0

[wind]
speed = 5.0

[aerodynamics]
kind = "packaged"
name = "example3"

[damping.translation]
low_ratio = 0.008
low_frequency = 0.2
high_ratio = 0.008
high_frequency = 0.6

[damping.twist]
low_ratio = 0.03
low_frequency = 0.2
high_ratio = 0.03
high_frequency = 2.0

[initial]
seed_vertical = 0.05

[numerics]
elements = 10
time_step = 0.02

[run]
stop_time = 120.0
record_every = 5
"""
scene = gf.LineScene.from_dict(tomllib.loads(LINE))
scene

# %% [markdown]
# The modes of a section: the string lets the spans move together, and the bundle has a torsional
# mode.

# %%
modes = modal.natural_modes(scene, count=6)
modes

# %%
modes.plot()

# %% [markdown]
# The motion of the centre of the bundle in each span, and of the string:

# %%
result = gf.simulate(scene)
result.plot()

# %%
result.spans[["span", "sag", "largest_tension", "u2_amplitude", "u3_amplitude"]].round(2)

# %% [markdown]
# Forces on the towers [N]:

# %%
result.towers[["tower", "kind", "force_x1_min", "force_x1_max", "force_x2_min"]].round(0)

# %%
assert result.outcome.name == "COMPLETED"
