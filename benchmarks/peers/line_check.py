"""Compare the programs for lines with the stored numbers of others, and store what they give.

python benchmarks/peers/line_check.py [NAME ...]    # all cases take 6 minutes

Each case of tests/peers/data/lines that these programs did not compute gets a field `repeated`.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import line_galloping
import line_lumped as lumped
import line_mechaphlowers as mechaphlowers
import line_opensees as opensees
import numpy as np
from line_opensees import Array, End, Line, Span, ops
from line_references import FOLDER, extrapolated, pulse_law
from line_sampler import polygon

Found = dict[str, Any]


def section_line(scene: Found, elements: int) -> Line:
    c = scene["conductor"]
    return Line(
        tuple(Span(span["length"], span["height_difference"]) for span in scene["spans"]),
        tuple((s["length"], s["weight"]) for s in scene.get("strings", ())),
        c["mass_per_rest_length"],
        c["axial_stiffness"],
        scene["horizontal_tension"],
        elements,
        scene["gravity"],
    )


def section_frequencies(case: Found) -> Found:
    """Frequencies of two meshes and their limit; the mode count is that of the stored case."""
    wanted = [len(case["results"][plane]) for plane in ("in_plane", "out_of_plane")]
    line = section_line(case["scene"], case["scene"]["elements_per_span"] or 80)
    meshes = []
    for factor in (1, 2):
        built = opensees.build(line.refined(factor))
        opensees.settle(built)
        found = opensees.planes(built, 2 * sum(wanted) + 4)
        meshes.append([plane[:count] for plane, count in zip(found, wanted, strict=True)])
    limits = [extrapolated(*pair) for pair in zip(*meshes, strict=True)]
    return {
        "elements": [line.elements, 2 * line.elements],
        "in_plane": [meshes[0][0], meshes[1][0]],
        "out_of_plane": [meshes[0][1], meshes[1][1]],
        "in_plane_extrapolated": limits[0][0],
        "out_of_plane_extrapolated": limits[1][0],
    }


def bundle_frequencies(case: Found) -> Found:
    bundle = case["scene"]["bundle"]
    count, spacers = bundle["subconductors"], bundle["spacers"]
    stations = tuple((k + 1) / (spacers + 1) for k in range(spacers))
    line = replace(
        section_line(case["scene"], 20 * (spacers + 1)),
        conductors=polygon(count, bundle["spacing"]),
        frames=stations,
    )
    meshes = []
    for factor in (4, 8):
        built = opensees.build(line.refined(factor))
        opensees.settle(built)
        found = opensees.families(built, 10)
        meshes.append({family: values[:2] for family, values in found.items()})
    return {
        "elements": [4 * line.elements, 8 * line.elements],
        **{f"{key}_extrapolated": extrapolated(meshes[0][key], meshes[1][key])[0] for key in found},
    }


def twin_frequencies(case: Found) -> Found:
    """The horizontal twin with clamp springs, in the lumped chain; 48 and 96 elements."""
    scene, bundle, c = case["scene"], case["scene"]["bundle"], case["scene"]["conductor"]
    half = 0.5 * bundle["spacing"]
    conductor = lumped.Conductor(
        c["mass_per_rest_length"],
        c["axial_stiffness"],
        c["torsional_stiffness"],
        c["torsional_inertia"],
        0.028,
    )
    meshes = []
    for elements in (48, 96):
        model = lumped.build(
            lumped.Case(
                conductor,
                scene["horizontal_tension"],
                (scene["spans"][0]["length"],),
                lumped.Wind(0.0, 0.0, (), ()),
                (0.0, 0.0),
                elements,
                conductors=((0.0, half), (0.0, -half)),
                frames=tuple(
                    lumped.Frame(k / 6.0, bundle["clamp_torsional_stiffness"]) for k in range(1, 6)
                ),
            )
        )
        meshes.append(_twin_families(model))
    return {
        "elements": [48, 96],
        **{key: [mesh[key] for mesh in meshes] for key in meshes[0]},
        **{f"{key}_extrapolated": extrapolated(*(m[key] for m in meshes))[0] for key in meshes[0]},
    }


def _twin_families(model: lumped.Model) -> dict[str, Array]:
    found, shapes = lumped.frequencies(model, 16)
    one, two = (shapes[:, nodes[0]] for nodes in model.nodes)
    size = np.abs(np.stack([one[..., 2] + two[..., 2], one[..., 1] + two[..., 1],
                            one[..., 1] - two[..., 1]])).max(axis=2)  # fmt: skip
    family = size.argmax(axis=0)
    wanted = {"horizontal": 2, "vertical": 3, "torsion": 4}
    return {
        name: found[family == number][:count] for number, (name, count) in enumerate(wanted.items())
    }


def bundle_torque(case: Found) -> Found:
    """Turn [deg] under a torque that follows the frame, and under dead increments of 20 N m."""
    torques = case["results"]["torque_n_m"]
    return {
        "turn_deg_follower_torque": [_turn(case, torque, True) for torque in torques],
        "turn_deg_dead_increments_of_20_n_m": [_turn(case, torque, False) for torque in torques],
        "remark": "The stored turns are those of dead increments: each is tangential to the frame"
        " at the start of the increment and keeps its direction. A torque follows the frame.",
    }


def _turn(case: Found, torque: float, follower: bool) -> float:
    bundle = case["scene"]["bundle"]
    spacers = bundle["spacers"]
    line = replace(
        section_line(case["scene"], 10 * (spacers + 1)),
        conductors=polygon(4, bundle["spacing"]),
        frames=tuple((k + 1) / (spacers + 1) for k in range(spacers)),
    )
    built = opensees.build(line)
    opensees.settle(built)
    tags = [chains[0][line.elements // 2] for chains in built.chains]
    arms = np.array(line.conductors)
    turn, applied, number = 0.0, np.zeros((4, 2)), 10
    increments = round(torque / 20.0)
    for increment in range(1, increments + 1):
        for _ in range(50 if follower else 1):
            radial = arms @ np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
            unit = np.stack([-radial[:, 1], radial[:, 0]], axis=1) / (arms**2).sum()
            force = 20.0 * increment * unit if follower else applied + 20.0 * unit
            number += 1
            _hold(tags, force, number)
            before, turn = turn, _turn_of(tags, arms)
            if abs(turn - before) < 1e-8:
                break
        applied = force
    return float(np.degrees(turn))


def _hold(tags: list[int], force: Array, number: int) -> None:
    if number > 11:
        ops.remove("loadPattern", number - 1)
    ops.timeSeries("Constant", number)
    ops.pattern("Plain", number, number)
    for tag, value in zip(tags, force, strict=True):
        ops.load(tag, 0.0, *value.tolist())
    opensees.analysis("Static", 1e-10, "LoadControl", 0.0)
    assert ops.analyze(1) == 0


def _turn_of(tags: list[int], arms: Array) -> float:
    moved = arms + np.array([opensees.displacement(tag)[1:] for tag in tags])
    moved -= moved.mean(axis=0)
    cross = arms[:, 0] * moved[:, 1] - arms[:, 1] * moved[:, 0]
    return float(np.arctan2(cross.sum(), (arms * moved).sum()))


def interphase_frequencies(case: Found) -> Found:
    rows = []
    for row in case["results"]["opposed_in_plane"]:
        line = replace(
            section_line(case["scene"], 72),
            conductors=((0.0, 0.0), (5.0, 0.0)),
            bars=tuple((station, 0.0) for station in row["spacers_at"]),
        )
        meshes = []
        for factor in (2, 4):
            built = opensees.build(line.refined(factor))
            opensees.settle(built)
            meshes.append(_opposed(built, len(row["frequencies"])))
        rows.append(
            {"spacers_at": row["spacers_at"], "frequencies_extrapolated": extrapolated(*meshes)[0]}
        )
    return {"opposed_in_plane": rows}


def _opposed(built: opensees.Built, count: int) -> Array:
    """In-plane modes in which the two phases move against each other."""
    found, shapes = opensees.frequencies(built, 20)
    half = len(built.free) // 2
    vertical = np.abs(shapes[:, :, 2]).max(axis=1) < 0.5
    against = (shapes[:, :half] * shapes[:, half:]).sum(axis=(1, 2)) < 0.0
    return found[vertical & against][:count]


def statics(case: Found) -> Found:
    """The section with end strings, in both programs."""
    scene, states = case["scene"], case["results"]["states"]
    c, gravity = scene["conductor"], scene["gravity"]
    tension = scene["strung"]["horizontal_tension_over_weight"] * c["mass_per_length"] * gravity
    modulus = 60e9
    peer = mechaphlowers.Section(
        tuple(span["length"] for span in scene["spans"]),
        (30.0,) * 4,
        tuple((scene[end]["length"], scene[end]["weight"]) for end in ("left_end",))
        + tuple((s["length"], s["weight"]) for s in scene["strings"])
        + tuple((scene[end]["length"], scene[end]["weight"]) for end in ("right_end",)),
        c["mass_per_length"],
        c["axial_stiffness"] / modulus,
        modulus,
        c["diameter"],
        c["thermal_expansion"],
        tension,
    )
    found = []
    for state in states:
        ice = state["ice"]["thickness"] if state["ice"] else 0.0
        their = mechaphlowers.solve(
            peer, 15.0, np.full(3, state["wind_pressure_pa"]), np.full(3, ice)
        ).offsets
        ours = _end_strings(scene, tension, state["wind_pressure_pa"], ice)
        found.append(
            {
                "state": state["state"],
                **{
                    name: dict(zip(("along", "down", "across"), offsets.T.tolist(), strict=True))
                    for name, offsets in (("mechaphlowers", their), ("opensees", ours))
                },
            }
        )
    return {"states": found}


def _end_strings(scene: Found, tension: float, pressure: float, thickness: float) -> Array:
    """OpenSees; the strung state of the end strings is that of mechaphlowers in still air."""
    along, down = (2.971873, -2.981119), (0.409839, 0.336051)
    c, gravity = scene["conductor"], scene["gravity"]
    rises = (down[0], 0.0, -down[1])
    lengths = [span["length"] for span in scene["spans"]]
    lengths[0] -= along[0]
    lengths[2] += along[1]
    diameter = c["diameter"]
    ice = np.pi * thickness * (thickness + diameter) * 6000.0 / gravity
    line = Line(
        tuple(Span(a, b, ice, pressure * diameter) for a, b in zip(lengths, rises, strict=True)),
        ((3.0, 500.0),) * 2,
        c["mass_per_length"],
        c["axial_stiffness"],
        tension,
        160,
        gravity,
        c["thermal_expansion"],
        15.0,
        string_stiffness=5e8 / 3.0,
        string_taut=False,
        rest_lengths=tuple(scene["rest_lengths_at_0_deg_c"]),
        ends=(End((-along[0], down[0]), 3.0, 1000.0), End((-along[1], down[1]), 3.0, 1000.0)),
    )
    built = opensees.build(line)
    opensees.settle(built, 40)
    tags = [built.end_clamps[0], *built.clamps[0], built.end_clamps[1]]
    start = [[along[0], -down[0], 0.0], [0.0, -3.0, 0.0], [0.0, -3.0, 0.0]]
    return np.array([opensees.displacement(tag) for tag in tags]) + np.array(
        [*start, [along[1], -down[1], 0.0]]
    )


def section_pulse(case: Found) -> Found:
    scene, load = case["scene"], case["scene"]["load"]
    stored = np.loadtxt(FOLDER / case["results"]["file"], delimiter=",", skiprows=1)
    line = section_line(scene, 320)
    built = opensees.build(line)
    opensees.settle(built)
    chains = built.chains[0]
    watched = [tags[160] for tags in chains] + built.clamps[0][:1]
    place = chains[load["span"] - 1][round(320 * load["station_of_rest_length"])]
    found = opensees.pulse(built, place, load["force"], pulse_law, 0.001, 20.0, 50, watched)
    rms = np.sqrt(((found - stored) ** 2).mean(axis=0) / (stored**2).mean(axis=0))
    return {"elements": 320, "relative_rms_of_the_columns": rms[1:]}


def galloping_case(scene: Found, elements: int) -> lumped.Case:
    """The case in the words of the lumped chain."""
    c, bundle = scene["conductor"], scene.get("bundle")
    ice, curve = scene["ice"], scene["aerodynamics"]
    changes: Found = {}
    if bundle:
        half = 0.5 * bundle["spacing"]
        changes["conductors"] = ((0.0, half), (0.0, -half))
        stations = [(k + 1) / (bundle["spacers"] + 1) for k in range(bundle["spacers"])]
        changes["frames"] = tuple(
            lumped.Frame(station, bundle["clamp_torsional_stiffness"]) for station in stations
        )
    devices = scene.get("devices", [])
    if "phases" in scene:
        changes["conductors"] = tuple(tuple(phase) for phase in scene["phases"])
        changes["bars"] = tuple(device["station"] for device in devices)
    else:
        changes["pendulums"] = tuple((d["station"], d["mass"], d["arm"]) for d in devices)
    return lumped.Case(
        conductor=lumped.Conductor(
            c["mass_per_rest_length"],
            c["axial_stiffness"],
            c["torsional_stiffness"],
            c["torsional_inertia"],
            c["diameter"],
            ice["first_moment_x2"],
            ice["first_moment_x3"],
        ),
        tension=scene["horizontal_tension"],
        spans=tuple(span["length"] for span in scene["spans"]),
        strings=tuple((s["length"], s["weight"]) for s in scene.get("strings", ())),
        wind=lumped.Wind(
            scene["wind"]["speed"],
            float(np.radians(ice["attack_angle_deg"])),
            tuple(curve["lift"]),
            tuple(curve["drag"]),
            tuple(curve["moment"]),
            density=scene["wind"]["air_density"],
        ),
        damping=(
            scene["damping"]["translation_mass_proportional"],
            scene["damping"]["twist_mass_proportional"],
        ),
        elements=elements,
        **changes,
    )


def galloping(case: Found) -> Found:
    elements = 42 if "devices" in case["scene"] else 40
    coarse = galloping_case(case["scene"], elements)
    duration = 450.0 if len(coarse.spans) > 1 else 300.0 if coarse.pendulums else 600.0
    rows = []
    for factor in (1, 2):
        model = lumped.build(replace(coarse, elements=factor * elements))
        if coarse.pendulums:
            model = lumped.settled(model, lumped.largest_step(model.case))
        rows.append({"elements": factor * elements, **line_galloping.windows(model, duration)})
    return {"meshes": rows}


def slope_growth(case: Found) -> Found:
    scene = case["scene"]
    c, curve = scene["conductor"], scene["aerodynamics"]
    conductor = lumped.Conductor(
        c["mass_per_rest_length"],
        c["axial_stiffness"],
        c["torsional_stiffness"],
        c["torsional_inertia"],
        c["diameter"],
    )
    rows = []
    for one in case["results"]["cases"]:
        growths = []
        for elements in (30, 60):
            wind = lumped.Wind(
                one["wind_speed"],
                np.pi,
                tuple(curve["lift"]),
                tuple(curve["drag"]),
                centre=np.pi,
                yaw=float(np.radians(one["yaw_deg"])),
            )
            model = lumped.build(
                lumped.Case(
                    conductor,
                    scene["horizontal_tension"],
                    (scene["span_length"],),
                    wind,
                    (0.10, 10.0),
                    elements,
                    rises=(one["height_difference"],),
                    seed=(1e-3, 0.0),
                )
            )
            time, moved = lumped.simulate(model, 200.0, [model.middle(0, 0)])
            ends = np.arange(120.0, 201.0, 20.0)
            sizes = [
                np.ptp(moved[(time > end - 20.0) & (time <= end + 1e-9), 0, 1]) for end in ends
            ]
            growths.append(float(np.polyfit(ends, np.log(sizes), 1)[0]))
        rows.append({"wind_speed": one["wind_speed"], "growth": growths})
    return {"elements": [30, 60], "cases": rows}


def ice_shed(case: Found) -> Found:
    """Ice leaves elements of an iced span at once: jump of mid-span and the new equilibrium."""
    scene, rows = case["scene"], []
    c, ice = scene["conductor"], scene["ice"]["mass_per_length"]
    damping = scene["damping"]["translation_mass_proportional"]
    mass = c["mass_per_rest_length"]
    for one in case["results"]["cases"]:
        start, end = one["shed"]
        found: Found = {"shed": one["shed"]}
        for elements in (80, 160):
            iced = lumped.Case(
                lumped.Conductor(mass + ice, c["axial_stiffness"], 159.0, 2e-4, 0.028),
                scene["horizontal_tension"],
                (scene["spans"][0]["length"],),
                lumped.Wind(0.0, 0.0, (), ()),
                (0.0, 0.0),
                elements,
                seed=(0.0, 0.0),
            )
            model = lumped.build(iced)
            left = model.tables.mass.copy()
            middle = (np.arange(elements) + 0.5) / elements
            for e in np.flatnonzero((middle >= start) & (middle <= end)):
                left[[e, e + 1]] -= 0.5 * ice * model.tables.rest[e]
            tables = model.tables._replace(
                mass=left, weight=left * scene["gravity"], damped=damping * left
            )
            step = 0.5 * lumped.largest_step(iced)  # of the heavier conductor
            bare = lumped.Model(iced, tables, model.nodes, model.seed)
            node = model.middle(0, 0)
            nodes = [node, node - elements // 4]
            time, moved = lumped.simulate(bare, 6.0, nodes, step, 0.01, windy=False)
            jump = int(np.argmax(moved[:, 0, 1]))
            rise = lumped.settled(bare, step).tables.x[node, 1] - model.tables.x[node, 1]
            found[f"{elements} elements"] = {
                "iced_sag": float(-model.tables.x[node, 1]),
                "jump": float(moved[jump, 0, 1]),
                "time_of_jump": float(time[jump]),
                "final_rise": float(rise),
            }
            if "quarter_point" in one:
                found[f"{elements} elements"]["quarter_point"] = float(moved[:, 1, 1].max())
        rows.append(found)
    return {"cases": rows}


KINDS: dict[str, Callable[[Found], Found]] = {
    "frequencies": section_frequencies,
    "bundle frequencies": bundle_frequencies,
    "bundle torque": bundle_torque,
    "statics": statics,
    "pulse": section_pulse,
    "galloping": galloping,
    "growth": slope_growth,
}


NAMES = {
    "bundle_frequencies_twin_drake": twin_frequencies,
    "interphase_frequencies_zebra": interphase_frequencies,
    "ice_shed_drake_300m": ice_shed,
}
"""Cases that are computed in another way than their kind."""


def repeat(name: str) -> None:
    file = FOLDER / f"{name}.json"
    case = json.loads(file.read_text(encoding="utf-8"))
    compute = NAMES.get(name) or KINDS.get(case["kind"])
    if compute is None:
        return
    case["repeated"] = {"by": "benchmarks/peers/line_check.py", **compute(case)}
    text = json.dumps(case, indent=2, default=_plain)
    file.write_text(text + "\n", encoding="utf-8")
    print(name, json.dumps(case["results"], default=_plain), sep="\n  ")
    print(" ", json.dumps(case["repeated"], default=_plain))


def _plain(value: Any) -> Any:
    return np.round(value, 7).tolist() if isinstance(value, np.ndarray) else value.item()


def main() -> None:
    names = sys.argv[1:] or sorted(file.stem for file in FOLDER.glob("*.json"))
    for name in names:
        if not name.startswith("new_"):
            repeat(name)


if __name__ == "__main__":
    main()
