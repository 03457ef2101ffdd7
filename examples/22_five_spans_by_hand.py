# %% [markdown]
# # Numbers of a study, by hand
#
# A 220 kV section: Drake, spans of 280, 350, 420, 320 (with +30 m) and 390 m, strings of 2.4 m,
# strung at 20 % of the rated strength at 15 degrees Celsius, with 15 mm of ice of 900 kg/m3; as a
# single conductor and as a twin bundle. The numbers in which a study of it is rooted are computed a
# second time here: from the wires, the catenary, the state equation of a ruling span, the balance
# of forces at a clamp, a chain of taut strings, and Den Hartog's formula.

# %%
import subprocess
import sys
import tempfile
from math import cosh, pi, radians, sqrt
from pathlib import Path

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import brentq

import gallop_fmu as gf
import modal

folder = Path(tempfile.mkdtemp(prefix="gallop-"))
table = Path(__file__).parent / "22_towers.csv"
command = Path(sys.executable).with_name("gallop-fmu")
options = "--stringing-percent 20 --stringing-temperature 15 --temperature -5"
options += " --ice-thickness 0.015 --attack-angle-deg -10 --wind-speed 8"
twin = "--subconductors 2 --spacing 0.4 --spacers 6"
scenes = {}
for name, more in (("single", ""), ("twin", twin)):
    file = folder / f"{name}.toml"
    arguments = [command, "new", file, "--section", table, "--conductor", "Drake"]
    subprocess.run([*arguments, *f"{options} {more}".split()], check=True, capture_output=True)
    scenes[name] = gf.load_scene(file)

spans, rises = np.array([280.0, 350.0, 420.0, 320.0, 390.0]), np.array([0.0, 0.0, 0.0, 30.0, 0.0])
gravity = 9.81
rows = []


def compare(quantity, unit, program, by_hand, tolerance, how):
    """Keep a row of the table; `tolerance` is relative."""
    rows.append((quantity, unit, program, by_hand, tolerance, how))


# %% The conductor from its wires: 26 of aluminium, 4.442 mm, and 7 of steel, 3.455 mm.
scene = scenes["single"]
wire = scene.conductor
aluminium, steel = 26.0 * pi / 4.0 * 4.442e-3**2, 7.0 * pi / 4.0 * 3.455e-3**2
stiffness = 57e9 * aluminium + 190e9 * steel
expansion = (57e9 * aluminium * 23.0e-6 + 190e9 * steel * 11.5e-6) / stiffness
mass = 2703.0 * 1.02 * aluminium + 7780.0 * 1.005 * steel  # stranding lengthens wires by 2 %
compare("mass of the conductor", "kg/m", wire.mass_per_length, mass, 0.003, "wires, stranding")
compare("axial stiffness", "MN", wire.axial_stiffness / 1e6, stiffness / 1e6, 1e-6, "wires")
compare("thermal expansion", "1e-6/K", 1e6 * wire.thermal_expansion, 1e6 * expansion, 1e-6, "wires")

# %% Crescent ice: half of a ring between circles whose centres are half of the thickness apart.
ice = 900.0 * pi * (0.5 * 28.13e-3) * 0.015 / 2.0
compare("mass of the ice", "kg/m", scene.ice.mass_per_length, ice, 1e-6, "rho pi r t/2")

# %% From stringing to ice at -5 degrees: state equation of the ruling span (parabola).
ruling = sqrt((spans**3).sum() / spans.sum())
strung, w0 = 0.2 * 140.12e3, wire.mass_per_length * gravity
w = (wire.mass_per_length + scene.ice.mass_per_length) * gravity


def excess(h):
    """Strain from tension and temperature less strain from the parabola's length."""
    elastic = (h - strung) / wire.axial_stiffness + wire.thermal_expansion * -20.0
    return elastic - ruling**2 / 24.0 * ((w / h) ** 2 - (w0 / strung) ** 2)


horizontal = brentq(excess, 1e4, 1e5)
results = {name: gf.simulate(each, stop_time=1.0) for name, each in scenes.items()}
at_rest = results["single"].spans.set_index("span")
compare(
    "tension with ice, mean of spans", "kN", at_rest.horizontal_tension.mean() / 1e3,
    horizontal / 1e3, 0.001, "state equation",
)  # fmt: skip

# %% Sag of each span: a catenary through both clamps with the tension of the span.
ends = []
for k, (length, rise) in enumerate(zip(spans, rises, strict=True), start=1):
    c = at_rest.horizontal_tension[k] / w

    def rise_of(low, c=c, length=length):
        """Height of the right end above the left with the lowest point at `low`."""
        return c * (cosh((length - low) / c) - cosh(low / c))

    low = brentq(lambda x, rise=rise: rise_of(x) - rise, -5e3, 5e3)
    chord = 0.5 * c * (cosh(low / c) + cosh((length - low) / c))
    sag = chord - c * cosh((0.5 * length - low) / c)
    compare(f"sag of span {k}", "m", at_rest.sag[k], sag, 0.001, "catenary")
    sides = -c * np.sinh(low / c) * w, c * np.sinh((length - low) / c) * w  # upward pull on ends
    ends.append(sides)

# %% A suspension tower carries the slopes of the conductor on both sides, and the string.
for name, count in (("single", 1), ("twin", 2)):
    towers = results[name].towers.set_index("tower")
    for tower in range(1, 5):
        down = count * (ends[tower - 1][1] - ends[tower][0]) + 600.0
        program = -towers.preload_x2[tower] / 1e3
        compare(f"{name}: weight at tower {tower}", "kN", program, down / 1e3, 0.001, "catenary")
    pull = count * at_rest.horizontal_tension[1] / 1e3
    compare(f"{name}: pull at tower 0", "kN", towers.preload_x1[0] / 1e3, pull, 0.001, "tension")

# %% Swing across the line: taut strings with pendulums of the given pull between them.
parts, pulls = 40, results["single"].strings.set_index("tower").pull_at_rest
chords = np.sqrt(spans**2 + rises**2)
number = 5 * parts + 1
k_matrix, m_matrix = np.zeros((number, number)), np.zeros((number, number))
for span, chord in enumerate(chords):
    pulled = at_rest.horizontal_tension[span + 1] * chord / spans[span]
    h, own = chord / parts, (wire.mass_per_length + scene.ice.mass_per_length)
    for e in range(span * parts, (span + 1) * parts):
        k_matrix[e : e + 2, e : e + 2] += pulled / h * np.array([[1.0, -1.0], [-1.0, 1.0]])
        m_matrix[e : e + 2, e : e + 2] += own * h / 6.0 * np.array([[2.0, 1.0], [1.0, 2.0]])
for tower in range(1, 5):
    k_matrix[tower * parts, tower * parts] += pulls[tower] / 2.4
inner = slice(1, -1)
squares = eigh(k_matrix[inner, inner], m_matrix[inner, inner], eigvals_only=True)
by_chain = np.sqrt(squares[:5]) / (2.0 * pi)
# Without the eccentricity of the ice, which mixes swing and twist.
calm = scene.with_values({"ice.first_moment_x2": 0.0, "ice.first_moment_x3": 0.0})
modes = modal.natural_modes(calm, 40)
swings = [mode.frequency_hz for mode in modes if mode.family == "horizontal"]
for k in range(5):
    compare(f"swing {k + 1}", "Hz", swings[k], by_chain[k], 0.003, "taut strings")

# %% Wind at which the lowest vertical mode begins to grow, by Den Hartog.
curve = scene.aerodynamics.curve()
angle, step = radians(scene.ice.attack_angle_deg), 1e-4
slope = (curve.lift(angle + step) - curve.lift(angle - step)) / (2.0 * step) + curve.drag(angle)
found = modal.critical_wind_speed(scene, 12, highest_wind=3.0)
vertical = next(each for each in found if each.mode.family == "vertical")
f = vertical.mode.frequency_hz
first = scene.damping.translation.low_frequency  # the ratio is 0.5 % there and at twice of it
ratio = 0.005 * (2.0 * first / f + f / first) / 3.0
onset = 8.0 * pi * f * (w / gravity) * ratio
onset /= scene.wind.air_density * 28.13e-3 * -float(slope)
compare("critical wind, vertical", "m/s", vertical.wind_speed, onset, 0.015, "Den Hartog")

# %%
print(f"{'':38s}{'program':>10s}{'by hand':>10s}{'off [%]':>9s}  by")
for quantity, unit, program, by_hand, _, how in rows:
    off = program / by_hand - 1.0
    print(
        f"{quantity + ' [' + unit + ']':38s}{program:10.4g}{by_hand:10.4g}{100 * off:9.3f}  {how}"
    )
assert all(abs(program / hand - 1.0) <= most for _, _, program, hand, most, _ in rows)
