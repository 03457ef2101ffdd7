# %% [markdown]
# # A quad bundle with spacers
#
# Four Drake subconductors at the corners of a square, held by six spacers. The bundle has modes
# that one conductor does not have: it rotates as a whole, with a frequency near the vertical one.
# All subconductors carry ice and are in the same wind; the coefficient curve is that of example 2,
# a reconstruction.

# %%
import tempfile
from pathlib import Path

import gallop_fmu as gf
import modal
from gallop_fmu.scene.line_scene import LineScene

ICE = gf.load_scene("example2").model_dump(mode="json", exclude_none=True)
scene = LineScene.from_dict(
    {
        "title": "A quad bundle of Drake",
        "section": {"horizontal_tension": 25e3, "spans": [{"length": 200.0}]},
        "bundle": {"subconductors": 4, "spacing": 0.45, "spacers": 6, "spacer_mass": 8.0},
        "conductor": {
            "diameter": 0.02814,
            "mass_per_length": 1.628,
            "axial_stiffness": 29.0e6,
            "torsional_stiffness": 159.0,
            "torsional_inertia": 2e-4,
        },
        "aerodynamics": ICE["aerodynamics"],
        "ice": {"attack_angle_deg": ICE["ice"]["attack_angle_deg"], "mass_per_length": 0.4},
        "wind": {"speed": 5.0},
        "initial": {"seed_vertical": 0.05, "seed_horizontal": 0.01},
        "numerics": {"elements": 14, "time_step": 0.02},
        "run": {"stop_time": 400.0, "record_every": 5},
    }
)

# %% Modes with their families.
modes = modal.natural_modes(scene, count=6)
for mode in modes:
    loops = "one loop" if mode.loops == (1,) else f"{mode.loops[0]} loops"
    print(f"{mode.frequency_hz:.4f} Hz  {mode.family}, {loops}")

# %% Motion of the bundle's centre and of its twist at mid-span.
result = gf.simulate(scene)
print(result.spans.T)
bundle = result.bundle()
steady = result.steady(window=50.0)
for name, unit in (("u2", "m"), ("u3", "m"), ("theta", "rad")):
    print(f"{name:6} {steady[name].text(unit)}")
print("wrote", result.save(Path(tempfile.mkdtemp(prefix="gallop-")) / "quad.nc"))

# %%
torsion = next(mode for mode in modes if mode.family == "bundle torsion")
assert abs(torsion.frequency_hz - 0.3996) < 1e-3
