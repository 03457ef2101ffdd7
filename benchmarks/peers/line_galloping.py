"""Galloping of a section and of a twin bundle: two cases drawn from a seed, and what is stored."""

from __future__ import annotations

from dataclasses import asdict, replace
from typing import Any

import line_lumped as lumped
import numpy as np
from line_sampler import polygon
from line_strung import Array, hang

EXAMPLE_2 = lumped.Conductor(1.53, 13.30e6, 101.0, 0.5702e-4, 0.0188, -0.145e-3, 0.459e-3)
CURVE_2 = lumped.Wind(
    4.1, float(np.radians(10.0)), (0.0, -3.5, 0.0, 1.787), (1.6, 1.514), (0.0, -0.2)
)
DAMPING_2 = (0.0044, 2.52)
"""The iced conductor, curve and damping of Liu et al. (2009), Example 2."""

COARSE = 40
"""Elements of a span in the first mesh; the second, which is stored, has twice as many."""

WINDOW = 50.0
"""Length [s] of the windows whose half peak-to-peak values are stored."""


def windows(model: lumped.Model, duration: float) -> dict[str, Array]:
    """Half peak-to-peak [m, rad] of mid-spans, clamps and turn by window, from a run in wind."""
    case = model.case
    count, spans = len(case.conductors), len(case.spans)
    watched = [model.middle(c, k) for c in range(count) for k in range(spans)]
    clamps = [tag for c in range(count) for tag in model.clamps(c)]
    time, moved = lumped.simulate(model, duration, watched + clamps)
    middle = moved[:, : len(watched)].reshape(len(time), count, spans, 4)
    side = moved[:, len(watched) :].reshape(len(time), count, -1, 4)
    series = {
        "u2_mid_spans": middle[..., 1].mean(axis=1),
        "u3_mid_spans": middle[..., 2].mean(axis=1),
        "twist_mid_spans": middle[..., 3].mean(axis=1),
        "u3_clamps": side[..., 2].mean(axis=1),
    }
    if count == 2:
        x = model.tables.x[watched].reshape(count, spans, 3)
        across = x[0] - x[1] + middle[:, 0, :, :3] - middle[:, 1, :, :3]
        angle = np.arctan2(across[..., 2], across[..., 1])
        series["turn_of_bundle"] = np.unwrap(angle, axis=0)
    ends = np.arange(2 * WINDOW, duration + 1.0, WINDOW)
    parts = [(time > end - WINDOW) & (time <= end + 1e-9) for end in ends]
    found = {
        name: np.array([0.5 * np.ptp(values[part], axis=0) for part in parts])
        for name, values in series.items()
        if values.shape[1]
    }
    rising = np.diff(
        np.sign(series["u2_mid_spans"] - series["u2_mid_spans"][parts[-1]].mean(0)), axis=0
    )
    crossings = [time[1:][parts[-1][1:] & (rising[:, k] > 0)] for k in range(spans)]
    found["last_frequency_hz"] = np.array([(len(t) - 1) / (t[-1] - t[0]) for t in crossings])
    return {"time": ends, **found}


def scene_of(case: lumped.Case) -> dict[str, Any]:
    """The case in the words of the stored references."""
    c = asdict(case.conductor)
    rises = case.rises or (0.0,) * len(case.spans)
    wind = case.wind
    first = hang(
        case.spans[0], rises[0], case.tension, case.conductor.mass * lumped.GRAVITY,
        case.conductor.axial_stiffness, case.elements,
    )  # fmt: skip
    hanging = float(np.linalg.norm(np.diff(first.position, axis=1), axis=0).sum())
    share = first.rest * case.elements / hanging
    scene: dict[str, Any] = {
        "gravity": lumped.GRAVITY,
        "spans": [
            {"length": a, "height_difference": b} for a, b in zip(case.spans, rises, strict=True)
        ],
        "strings": [{"length": a, "weight": b} for a, b in case.strings],
        "ends": "rigid",
        "clamp_twist": "fixed",
        "horizontal_tension": case.tension,
        "conductor": {
            "mass_per_rest_length": c["mass"],
            "mass_per_length": c["mass"] * share,
            "axial_stiffness": c["axial_stiffness"],
            "torsional_stiffness": c["torsional_stiffness"],
            "torsional_inertia": c["inertia"],
            "diameter": c["diameter"],
        },
        "ice": {
            "first_moment_x2": c["first_moment_x2"],
            "first_moment_x3": c["first_moment_x3"],
            "attack_angle_deg": float(np.degrees(wind.attack_angle)),
            "first_moment_angle_deg": float(np.degrees(wind.attack_angle)),
        },
        "aerodynamics": {
            "kind": "polynomial",
            "angle": "rad, of attack",
            "centre_deg": float(np.degrees(wind.centre)),
            "lift": list(wind.lift),
            "drag": list(wind.drag),
            "moment": list(wind.moment),
        },
        "wind": {"speed": wind.speed, "air_density": wind.density},
        "damping": {
            "translation_mass_proportional": case.damping[0],
            "twist_mass_proportional": case.damping[1],
            "unit": "1/s; b2 = 0; strings and devices have none",
        },
        "start": "still; u2 and u3 of 1 mm sin(pi x/L) in each span, on all subconductors",
    }
    if len(case.conductors) > 1:
        scene["bundle"] = {
            "subconductors": len(case.conductors),
            "offsets_x2_x3": [list(offset) for offset in case.conductors],
            "spacers_at": [frame.station for frame in case.frames],
            "spacer": "massless, rigid in its plane across the line",
            "clamp_torsional_stiffness": case.frames[0].clamp_stiffness,
        }
    return scene


def cases(seed: int) -> list[dict[str, Any]]:
    """Example 2's iced conductor and curve on a section and on a vertical twin, both drawn."""
    rng = np.random.default_rng(seed)
    section = lumped.Case(
        conductor=EXAMPLE_2,
        tension=float(np.round(rng.uniform(19e3, 24e3), -2)),
        spans=tuple(np.round(rng.uniform(100.0, 150.0, 2), 1).tolist()),
        rises=tuple(np.round(rng.uniform(-5.0, 5.0, 2), 1).tolist()),
        strings=((float(np.round(rng.uniform(1.6, 2.6), 1)), 490.0),),
        wind=replace(CURVE_2, speed=float(np.round(rng.uniform(3.9, 4.4), 1))),
        damping=DAMPING_2,
        elements=COARSE,
    )
    spacing = float(np.round(rng.uniform(0.3, 0.5), 2))
    twin = lumped.Case(
        conductor=EXAMPLE_2,
        tension=float(np.round(rng.uniform(19e3, 24e3), -2)),
        spans=(float(np.round(rng.uniform(110.0, 140.0), 1)),),
        wind=replace(CURVE_2, speed=float(np.round(rng.uniform(3.9, 4.4), 1))),
        damping=DAMPING_2,
        conductors=polygon(2, spacing),
        frames=tuple(lumped.Frame((k + 1) / 5.0, 500.0) for k in range(4)),
        elements=COARSE,
    )
    return [
        gallop("new_galloping_section", section, 400.0),
        gallop("new_galloping_twin_vertical", twin, 600.0),
    ]


def gallop(name: str, case: lumped.Case, duration: float) -> dict[str, Any]:
    meshes = []
    for factor in (1, 2):
        model = lumped.build(replace(case, elements=factor * case.elements))
        meshes.append(windows(model, duration))
    coarse, fine = meshes
    change = {
        key: np.abs(fine[key] / coarse[key] - 1.0).max(axis=-1).round(5).tolist()
        for key in fine
        if key != "time"
    }
    return {
        "name": name,
        "kind": "galloping",
        "scene": scene_of(case),
        "results": {
            "unit": "half peak-to-peak [m, rad] over windows of 50 s that end at the times [s]; of"
            " the mean of the subconductors; one row a window, one column a span or clamp",
            "elements": 2 * case.elements,
            **fine,
        },
        "program": ["lumped explicit chain", "numba"],
        "mesh_error": {"relative change from half the elements, by window": change},
    }
