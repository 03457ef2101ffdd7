"""Ice that falls from spans, by OpenSees and mechaphlowers: the jump, and ice left on one span.

python benchmarks/peers/line_shedding.py    # 1 minute

Writes tests/peers/data/lines/ice_on_one_span.json, and the field `repeated` of
ice_shed_zebra_300m.json. No code is shared with gallop_fmu.
"""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import line_mechaphlowers as mechaphlowers
import line_opensees as opensees
import numpy as np
from line_opensees import Array, Line, Span, ops
from line_references import EXPANSION, FOLDER, ICE_DENSITY, extrapolated, write

STEP = 0.001
"""Time step [s] of the jump."""

THICKNESS = 0.012
"""Radial ice [m] on the section."""

AREA, MODULUS, DIAMETER = 468.5e-6, 29.0e6 / 468.5e-6, 0.02814
"""Drake with EA = 29 MN."""


def jump(case: dict[str, Any], elements: int) -> dict[str, float]:
    """Free vibration of the bare span from its equilibrium under the weight of the ice."""
    scene, conductor = case["scene"], case["scene"]["conductor"]
    line = Line(
        (Span(scene["spans"][0]["length"]),),
        (),
        conductor["mass_per_rest_length"],
        conductor["axial_stiffness"],
        scene["horizontal_tension"],
        elements,
        scene["gravity"],
    )
    rest = opensees.strung(line, line.spans[0]).rest
    built = opensees.build(line)
    for tag in built.free:
        built.load(
            tag, opensees.NOTHING, (0.0, -scene["ice"]["mass_per_length"] * rest * 9.81, 0.0)
        )
    opensees.settle(built, 10)
    middle = built.chains[0][0][elements // 2]
    iced = ops.nodeCoord(middle)[1] + opensees.displacement(middle)[1]
    ops.remove("loadPattern", 2)
    opensees.analysis("Transient", 1e-8, "Newmark", 0.5, 0.25)
    height = []
    for _ in range(round(1.6 / STEP)):
        assert ops.analyze(1, STEP) == 0, "no convergence"
        height.append(ops.nodeCoord(middle)[1] + opensees.displacement(middle)[1] - iced)
    peak = next(k for k in range(1, len(height)) if height[k + 1] < height[k])
    return {
        "iced_sag": float(-iced),
        "rise_at_1_s": float(height[round(1.0 / STEP) - 1]),
        "first_peak_mid_span": float(height[peak]),
        "time_of_first_peak": STEP * (peak + 1),
    }


def repeat_jump() -> None:
    file = FOLDER / "ice_shed_zebra_300m.json"
    case = json.loads(file.read_text(encoding="utf-8"))
    found = {f"{elements} elements": jump(case, elements) for elements in (80, 160)}
    case["repeated"] = {
        "by": "benchmarks/peers/line_shedding.py",
        "note": "the stored peak is the displacement at 1.0 s; the first peak is earlier",
        **found,
    }
    file.write_text(json.dumps(case, indent=2) + "\n", encoding="utf-8")
    print(found)


def static_values(line: Line) -> dict[str, Array]:
    """Clamps, forces along the line and string pulls of a section, extrapolated to a fine mesh."""
    meshes = []
    for factor in (1, 2):
        built = opensees.build(line.refined(factor))
        opensees.settle(built, 20)
        ops.reactions()
        chain = built.chains[0]
        along = [-ops.nodeReaction(tags)[0] for tags in (chain[0][0], chain[-1][-1])]
        tops = [int(ops.eleNodes(e)[0]) for e in built.strings]
        meshes.append(
            {
                "clamps": np.array([opensees.displacement(tag) for tag in built.clamps[0]]),
                "ends_along": np.array(along),
                "unbalanced_pull": np.array([-ops.nodeReaction(tag)[0] for tag in tops]),
                "string_pull": np.array(
                    [ops.eleResponse(e, "axialForce")[0] for e in built.strings]
                ),
            }
        )
    return {key: extrapolated(meshes[0][key], meshes[1][key])[0] for key in meshes[0]}


def ice_on_one_span() -> None:
    """Three spans with ice; what remains in equilibrium once it has fallen from two of them."""
    gravity, strings = mechaphlowers.GRAVITY, ((2.4, 600.0), (2.4, 600.0))
    lengths, tension, mass = (300.0, 350.0, 280.0), 25e3, 1.628
    ice = np.pi * THICKNESS * (THICKNESS + DIAMETER) * ICE_DENSITY / gravity
    bare = Line(
        tuple(map(Span, lengths)), strings, mass, MODULUS * AREA, tension, 160, gravity, EXPANSION
    )
    bare = replace(bare, mass=mass**2 / bare.mass_per_hanging_length)
    share = bare.mass / mass
    peer = mechaphlowers.Section(
        lengths,
        (20.0,) * 4,
        ((mechaphlowers.SHORTEST, 1.0), *strings, (mechaphlowers.SHORTEST, 1.0)),
        mass, AREA, MODULUS, DIAMETER, EXPANSION, tension,
    )  # fmt: skip
    states = []
    for iced in ((1, 1, 1), (0, 1, 0), (1, 0, 0)):
        spans = tuple(
            Span(length, ice=float(ice * share * on))
            for length, on in zip(lengths, iced, strict=True)
        )
        ours = static_values(replace(bare, spans=spans))
        their = mechaphlowers.solve(peer, 15.0, np.zeros(3), THICKNESS * np.array(iced, float))
        offsets = their.offsets[1:-1] + np.array([[0.0, a, 0.0] for a, _ in strings])
        pull = np.diff(their.horizontal)
        states.append(
            {
                "iced": iced,
                "opensees": ours,
                "mechaphlowers": {
                    "clamps": offsets,
                    "horizontal_tension": their.horizontal,
                    "unbalanced_pull": pull,
                },
            }
        )
        print(iced, ours, states[-1]["mechaphlowers"])
    scene = {
        "gravity": gravity,
        "spans": [{"length": length, "height_difference": 0.0} for length in lengths],
        "strings": [{"length": a, "weight": b} for a, b in strings],
        "ends": "rigid",
        "conductor": {
            "name": "Drake",
            "mass_per_length": mass,
            "mass_per_rest_length": bare.mass,
            "axial_stiffness": MODULUS * AREA,
            "diameter": DIAMETER,
        },
        "horizontal_tension": tension,
        "horizontal_tension_state": "bare",
        "ice": {"mass_per_length": ice, "thickness": THICKNESS},
        "twist": False,
    }
    results = {
        "unit": "m, N; displacements (x1, x2, x3) from the strung state",
        "iced": "1 for each span with ice",
        "unbalanced_pull": "force of each string on its tower along the line, towards +x1",
        "ends_along": "force of the conductor on the left and the right tower along the line",
        "states": states,
    }
    write(
        "ice_on_one_span", "ice on one span", scene, results,
        program=["OpenSees", "mechaphlowers"], source="benchmarks/peers/line_shedding.py",
    )  # fmt: skip


if __name__ == "__main__":
    repeat_jump()
    ice_on_one_span()
