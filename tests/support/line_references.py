"""Stored results of other programs for lines (tests/peers/data/lines), and their scenes."""

import json
import math
from pathlib import Path

import numpy as np

import gallop_fmu as gf

FOLDER = Path(__file__).parents[1] / "peers" / "data" / "lines"
STRING = {"kind": "string", "stiffness": 1e9}
"""Stiff as in the other programs."""

NO_TWIST = {"torsional_stiffness": 1e-3, "torsional_inertia": 1e-12}
"""A conductor that resists no twist, and whose twist has frequencies far above all others."""

NO_CLAMP = 1e-3
"""Stiffness [N m/rad] of spacer clamps in cases without twist."""

FREQUENCIES = (1.0, 10.0)
"""Frequencies [Hz] at which the two damping ratios are stated."""


def stored(name):
    """Return a stored case; see the README of the folder for its fields."""
    return json.loads((FOLDER / f"{name}.json").read_text(encoding="utf-8"))


def series(case):
    """Columns of the file of a case, without its header."""
    file = FOLDER / case["results"]["file"]
    return np.loadtxt(file, delimiter=",", skiprows=1, unpack=True)


def line_scene(case, elements=20, **tables):
    """Return the scene of a stored case, with further `tables` of the scene file."""
    scene = case["scene"]
    spans = [_span(span) for span in scene["spans"]]
    data = {
        "title": case["kind"],
        "section": {
            "horizontal_tension": scene["horizontal_tension"],
            "gravity": scene["gravity"],
            "spans": spans,
            "suspensions": [STRING | string for string in scene.get("strings", ())],
        },
        "conductor": conductor(scene),
        "numerics": {"elements": elements},
    }
    if scene.get("temperature_change"):
        change = scene["temperature_change"]
        data["section"] |= {"strung_temperature_deg_c": 15.0, "temperature_deg_c": 15.0 + change}
    if "bundle" in scene:
        data["bundle"] = _bundle(scene["bundle"])
    devices = [
        {"kind": "mass", "span": number, **mass}
        for number, span in enumerate(scene["spans"], start=1)
        for mass in span.get("masses", ())
    ]
    if "phases" in scene:
        data["phases"] = [
            {"name": str(k), "offset": offset} for k, offset in enumerate(scene["phases"], 1)
        ]
    if isinstance(scene.get("devices"), list):
        devices += [_device(device) for device in scene["devices"]]
    if devices:
        data["devices"] = devices
    if "wind" in scene:
        data |= _wind(scene)
    return gf.LineScene.from_dict(data | tables)


def conductor(scene):
    """Return the conductor of a scene; its mass is per metre of the hanging conductor."""
    given = dict(scene["conductor"])
    if "mass_per_length" not in given:
        given["mass_per_length"] = given["mass_per_rest_length"] / (1.0 + mean_strain(scene))
    kept = ("mass_per_length", "axial_stiffness", "torsional_stiffness", "torsional_inertia")
    found = {"diameter": 0.028} | NO_TWIST
    found |= {key: given[key] for key in (*kept, "diameter", "thermal_expansion") if given.get(key)}
    return found


def mean_strain(scene):
    """Return the mean strain of the strung conductor, from the catenary of each span."""
    tension, given = scene["horizontal_tension"], scene["conductor"]
    total = length = 0.0
    for span in scene["spans"]:
        loaded = given["mass_per_rest_length"] * scene["gravity"] * span["length"] / tension
        slope = math.hypot(1.0, span["height_difference"] / span["length"])
        total += span["length"] * tension * slope * (1.0 + loaded**2 / 24.0)
        length += span["length"]
    return total / length / given["axial_stiffness"]


def _span(span):
    found = {key: span[key] for key in ("length", "height_difference")}
    if span.get("ice_mass_per_length"):
        found["ice"] = {"mass_per_length": span["ice_mass_per_length"]}
    return found


def _bundle(bundle):
    found = {"subconductors": bundle["subconductors"]}
    if "offsets_x2_x3" in bundle:
        found["offsets"] = bundle["offsets_x2_x3"]
        found["stations"] = bundle["spacers_at"]
    else:
        found |= {
            key: bundle[key] for key in ("spacing", "spacers", "orientation") if key in bundle
        }
    found["clamp_torsional_stiffness"] = bundle.get("clamp_torsional_stiffness", NO_CLAMP)
    return found


def _device(device):
    found = {"span": 1, **device}
    if found["kind"] == "interphase_spacer":
        found["phases"] = [1, 2]
    found.pop("angle", None)
    return found


def _wind(scene):
    curve = {key: scene["aerodynamics"][key] for key in ("kind", "lift", "drag", "moment")}
    low, high = (scene["aerodynamics"].get(f"valid_{side}_deg") for side in ("from", "to"))
    curve |= {"valid_from_deg": low or -60.0, "valid_to_deg": high or 80.0}
    if centre := scene["aerodynamics"].get("centre_deg"):
        curve["centre_deg"] = centre
    return {
        "ice": dict(scene["ice"]),
        "aerodynamics": curve,
        "wind": dict(scene["wind"]),
        "damping": {
            name: mass_proportional(scene["damping"][f"{name}_mass_proportional"])
            for name in ("translation", "twist")
        },
        "initial": {"seed_vertical": 1e-3, "seed_horizontal": 1e-3},
    }


def mass_proportional(b1):
    """Return the ratios of C = b1 M [1/s]: they fall as 1/f."""
    low, high = FREQUENCIES
    return {
        "low_ratio": b1 / (4.0 * math.pi * low),
        "low_frequency": low,
        "high_ratio": b1 / (4.0 * math.pi * high),
        "high_frequency": high,
    }
