"""Lines drawn by a seed, wider than real ones, and their runs; of tests and benchmarks."""

from __future__ import annotations

from typing import Any

import numpy as np

import gallop_fmu as gf
from gallop_fmu.engine.model import Model
from gallop_fmu.engine.probes import Object, probes_of
from gallop_fmu.foundation.channels import NODE_INDEX

SECONDS, STEP = 4.0, 0.02
CURVES = {
    "cubic": {
        "kind": "polynomial",
        "valid_from_deg": -180.0,
        "valid_to_deg": 180.0,
        "outside": "hold",
        "lift": [0.0, -3.5, 0.0, 0.35],
        "drag": [1.2],
        "moment": [0.0, -0.2, 0.0, 0.02],
    }
}
CHANNELS = [NODE_INDEX[name] for name in ("u1", "u2", "u3", "theta")]
ENERGIES = probes_of((Object.SYSTEM, 0, k) for k in range(2))


def drawn(random: np.random.Generator) -> dict[str, Any]:
    """Draw the content of a scene file of a line."""
    spans, phases = int(random.integers(1, 6)), int(random.choice([1, 1, 1, 2, 3]))
    conductors = int(random.choice([1, 1, 1, 2, 2, 3, 4, 6]))
    length = random.uniform(80.0, 450.0, spans)
    ice = {"mass_per_length": float(random.uniform(0.0, 2.0)), "attack_angle_deg": 20.0}
    data: dict[str, Any] = {
        "title": "drawn",
        "section": {
            "horizontal_tension": float(random.uniform(15e3, 40e3)),
            "strung_with_ice": bool(random.random() < 0.3),
            "temperature_deg_c": float(random.uniform(-30.0, 40.0)),
            "spans": [
                {
                    "length": float(x),
                    "height_difference": float(random.normal(0.0, 0.04) * x),
                    **({"ice": "none"} if random.random() < 0.15 else {}),
                }
                for x in length
            ],
            "suspensions": [suspension(random, conductors) for _ in range(spans - 1)],
            "left_end": end(random),
            "right_end": end(random),
        },
        "bundle": {"subconductors": conductors},
        "phases": [{"name": str(k), "offset": [6.0 * k, 0.5 * k]} for k in range(phases)],
        "conductor": {
            "diameter": 0.028,
            "mass_per_length": 1.6,
            "axial_stiffness": 29e6,
            "torsional_stiffness": 159.0,
            "torsional_inertia": 2e-4,
            "thermal_expansion": 1.9e-5,
        },
        "ice": ice,
        "initial": {"seed_vertical": float(random.uniform(0.0, 0.2)), "seed_horizontal": 0.1},
        "numerics": {
            "elements": int(random.integers(6, 21)),
            "time_step": STEP,
            "integrator": str(random.choice(["newmark", "gauss6", "generalised_alpha"])),
        },
    }
    if conductors > 1:
        data["bundle"] |= {"spacing": 0.45, "spacers": int(random.integers(0, 6))}
    data["devices"] = [
        device(random, spans, phases, slot) for slot in range(int(random.integers(0, 4)))
    ]
    if random.random() < 1 / 3:
        data["bundle"] |= {"arm_damping": 0.0} if conductors > 1 else {}
        section = data["section"]
        for tower in (*section["suspensions"], section["left_end"], section["right_end"]):
            tower |= {"damping": 0.0} if "string" in tower["kind"] else {}
        data["devices"] = [d for d in data["devices"] if d["kind"] != "damper"]
        data["numerics"]["integrator"] = str(random.choice(["newmark", "gauss6"]))
    else:
        data["aerodynamics"] = CURVES["cubic"]
        data["wind"] = {"speed": float(random.uniform(0.0, 20.0))}
        data["initial"]["wind"] = str(random.choice(["at_once", "mean_wind_equilibrium"]))
    return data


def suspension(random: np.random.Generator, conductors: int) -> dict[str, Any]:
    kinds = ["string", "string", "string", "post"] + ["v_string"] * (conductors == 1)
    kind = str(random.choice(kinds))
    if kind == "post":
        return {"kind": kind}
    found = {
        "kind": kind,
        "length": float(random.uniform(1.0, 4.0)),
        "weight": float(random.uniform(100.0, 2000.0)),
    }
    if kind == "v_string":
        found["half_spread"] = float(random.uniform(0.5, 0.9) * found["length"])
    elif random.random() < 0.2 and conductors == 1:
        found["clamp_torsional_stiffness"] = float(random.uniform(10.0, 1e3))
    return found


def end(random: np.random.Generator) -> dict[str, Any]:
    kind = str(random.choice(["rigid", "rigid", "springs", "string"]))
    if kind == "springs":
        return {"kind": kind, "stiffness_x1": 1e5, "stiffness_x3": 1e5}
    return {"kind": kind, "length": 2.0, "weight": 500.0} if kind == "string" else {"kind": kind}


def device(random: np.random.Generator, spans: int, phases: int, slot: int) -> dict[str, Any]:
    kinds = ["pendulum", "mass", "damper", "interval"] + ["interphase_spacer"] * (phases > 1)
    kind = str(random.choice(kinds))
    found: dict[str, Any] = {"kind": kind, "span": int(random.integers(1, spans + 1))}
    place = 0.11 + 0.23 * slot + float(random.uniform(0.0, 0.05))
    if kind == "interval":
        return found | {"from_station": place, "to_station": place + 0.1, "ice": "none"}
    found["station"] = place
    if kind == "interphase_spacer":
        return found | {"phases": [1, 2], "mass": 10.0}
    if kind == "damper":
        return found | {"damping": 100.0, "axis": str(random.choice(["x1", "x2", "x3"]))}
    found["mass"] = float(random.uniform(1.0, 30.0))
    return found | {"arm": 0.5} if kind == "pendulum" else found


def run(data: dict[str, Any], seconds: float = SECONDS) -> tuple[str, str, float]:
    """Outcome, message and, of a line without losses, the relative drift of the energy."""
    try:
        scene = gf.LineScene.from_dict(data)
    except gf.SceneError as error:
        return "refused", str(error), np.nan
    try:
        model = Model(scene, inputs=False)
        state = model.start()
    except gf.SimulationError as error:
        return error.report.outcome.name, str(error), np.nan
    before = state.observe(ENERGIES)
    nodes = np.array([chain.middle for chain in model.map.chains], dtype=np.int32)
    record = state.run(round(seconds / STEP), 1, CHANNELS, nodes)
    values = record.node_values[: record.done] if hasattr(record, "done") else record.node_values
    outcome = record.report.outcome.name
    if outcome == "COMPLETED":
        assert np.isfinite(values).all(), "a completed run has records that are no numbers"
    drift = np.nan
    if "wind" not in data and outcome == "COMPLETED":
        after = state.observe(ENERGIES)
        scale = max(before.sum(), after[0], 1.0)
        drift = float((after.sum() - before.sum()) / scale)
    return outcome, str(record.report), drift
