"""A line of three spans with every kind of table, for tests of scenes."""

LINE = """
title = "Three spans"
[section]
horizontal_tension = 25000.0
spans = [
    {length = 300.0, elements = 20},
    {length = 350.0, height_difference = 12.0, ice = {mass_per_length = 1.0}},
    {length = 280.0, ice = "none"},
]
suspensions = [
    {kind = "string", length = 2.4, weight = 600.0},
    {kind = "post"},
]
left_end = {kind = "string", length = 3.0, weight = 800.0}
[bundle]
subconductors = 4
spacing = 0.45
spacers = 6
[[phases]]
name = "a"
[[phases]]
name = "b"
offset = [0, 8.0]
[conductor]
diameter = 0.0281
mass_per_length = 1.628
axial_stiffness = 29.0e6
torsional_stiffness = 159.0
torsional_inertia = 2e-4
[ice]
mass_per_length = 0.5
[[devices]]
kind = "pendulum"
span = 2
station = 0.5
mass = 20
arm = 0.5
[[devices]]
kind = "interval"
span = 1
from_station = 0.25
to_station = 0.75
ice = "none"
[[loads]]
span = 2
force = [0, 400, 600]
position = 0.3
"""
