"""Inputs and outputs of the FMU of a line.

Spans, phases and stations count from 1, towers from 0 (left end) to the number of spans (right
end). The host's inputs replace the scene's wind, attack angle and motion of the towers:

- ``wind_speed``, or ``span[1].wind_speed`` ... of each span, replaces ``wind``; ``wind_direction``
  of a scene whose wind has a direction, a profile or gusts replaces its direction,
- ``attack_angle`` replaces that of the ice on the first span,
- ``tower[0].x1`` ... replace the motion of the ends and suspensions: every clamp, or the tower's
  point of every string, of all phases.

The outputs of a span are those of its conductor or, of a bundle, of its centre; several phases have
them one by one, as in ``span[2].phase[3].midspan.x2``.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from gallop_fmu.engine.line_map import LineMap, MappedChain, MappedTower
from gallop_fmu.engine.pack import Packed
from gallop_fmu.engine.probes import Object
from gallop_fmu.fmu.ports import (
    AXES,
    INPUT,
    MEANINGS,
    NOMINAL,
    OUTPUT,
    WIND_SPEED,
    Ports,
    attack_angle_input,
    common_outputs,
    motion_input,
    preload_output,
    velocity_input,
)
from gallop_fmu.fmu.variable import CONSTANT, Origin, Target, TargetKind, Term
from gallop_fmu.foundation.channels import NODE_CHANNELS, NODE_INDEX
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.wind import MAX_WIND_SPEED

DIRECTIONS = ("along the line", "upwards", "across the line, downwind")
OF_A_CONDUCTOR = ("theta", "v1", "v2", "v3", "omega", "tension", "angle_of_attack")
OF_A_BUNDLE = ("v1", "v2", "v3", "tension", "angle_of_attack")
"""Channels of a node beyond its displacement; `TURN` has the twist of a bundle."""

PULL, LEAN_ALONG, LEAN_ACROSS = 3, 4, 5
"""Channels of a string: gallop_device_channel."""

NAMES = {"u1": "x1", "u2": "x2", "u3": "x3"}
"""Names of channels in the FMU, where they differ."""


def line_inputs(scene: LineScene, ports: Ports, packed: Packed) -> Iterator[dict[str, Any]]:
    """Yield the attributes of each input."""
    spans = range(1, packed.map.spans + 1)
    if ports.wind == "span":
        for span in spans:
            yield _wind(scene, f"span[{span}].wind_speed", f"span {span}", (span,))
    else:
        yield _wind(scene, "wind_speed", "all spans", spans)
    angle = packed.tables["cross_section"][0].attack_angle
    yield attack_angle_input(angle, " of span 1 (others alike)")
    for tower, junctions in enumerate(packed.map.junctions_of_towers):
        motions = []
        for axis, direction in enumerate(DIRECTIONS):
            name, place = f"tower[{tower}].{AXES[axis]}", f"tower {tower} {direction}"
            targets = tuple(Target(TargetKind.MOTION, j, axis) for j in junctions)
            motions.append((motion_input(name, name, place, targets), place))
        yield from (motion for motion, _ in motions)
        yield from (velocity_input(motion, place) for motion, place in motions)


def line_outputs(scene: LineScene, ports: Ports, packed: Packed) -> Iterator[dict[str, Any]]:
    """Yield the attributes of each output."""
    parts = packed.map
    tension = scene.strung_tension
    for span in range(1, parts.spans + 1):
        for phase in range(1, parts.phases + 1):
            place, where = _names(parts, f"span[{span}]", f"span {span}", phase)
            bundle = _Bundle(scene, parts.bundle(span, phase), tension)
            yield from bundle.at(0.5, f"{place}.midspan", f"mid-span of {where}", tension)
            for number, station in enumerate(ports.stations, start=1):
                at = f"{place}.station[{number}]"
                yield from bundle.at(station, at, f"{station:g} of {where}")
    for tower in range(parts.spans + 1):
        held = [parts.tower(tower, phase) for phase in range(1, parts.phases + 1)]
        yield from _tower_force(parts, tower, held, tension)
        for one in held:
            yield from _string(parts, one, tension)
    yield from common_outputs()


def _wind(scene: LineScene, name: str, where: str, spans: Sequence[int]) -> dict[str, Any]:
    """Attributes of the wind speed of spans; there is one field for each."""
    blows = scene.aerodynamics is not None or any(
        getattr(device, "aerodynamics", None) is not None for device in scene.devices
    )
    return INPUT | {
        "name": name,
        "key": name,
        "unit": "m/s",
        "nominal": NOMINAL["wind_speed"],
        "description": f"{WIND_SPEED} {where}, constant in a step",
        "start": float(scene.wind_of_span(spans[0]).at(0.0)),
        "minimum": -MAX_WIND_SPEED if blows else 0.0,
        "maximum": MAX_WIND_SPEED if blows else 0.0,
        "targets": tuple(Target(TargetKind.WIND, span - 1) for span in spans),
    }


def _names(parts: LineMap, name: str, words: str, phase: int) -> tuple[str, str]:
    """Name and words for a part of a phase; a single phase is not named."""
    if parts.phases == 1:
        return name, words
    return f"{name}.phase[{phase}]", f"{words}, phase {phase}"


class _Bundle:
    """The subconductors of a phase in a span, as one conductor."""

    def __init__(self, scene: LineScene, chains: tuple[MappedChain, ...], tension: float) -> None:
        self.chains, self.tension = chains, tension
        positions = np.array(scene.bundle.positions)
        self.arms = positions - positions.mean(axis=0)

    def at(
        self, station: float, name: str, where: str, tension: float | None = None
    ) -> Iterator[dict[str, Any]]:
        """Outputs at a station; tension and attack angle only if a nominal tension is given."""
        nodes = [chain.nearest_node(station) for chain in self.chains]
        several = len(nodes) > 1
        channels = ["u1", "u2", "u3", *(OF_A_BUNDLE if several else OF_A_CONDUCTOR)]
        of_what = f"{where} (mean of the subconductors)" if several else where
        for key in channels:
            channel = NODE_CHANNELS[NODE_INDEX[key]]
            if key in ("tension", "angle_of_attack") and tension is None:
                continue
            weight = 1.0 / len(nodes)
            terms = tuple(Term(Object.NODE, node, NODE_INDEX[key], weight=weight) for node in nodes)
            full = f"{name}.{NAMES.get(key, key)}"
            yield OUTPUT | {
                "name": full,
                "key": full,
                "origin": Origin.SUM,
                "unit": channel.unit,
                "description": MEANINGS[key].format(where=of_what),
                "nominal": tension if channel.unit == "N" else NOMINAL[key],
                "terms": terms,
            }
        if several:
            yield OUTPUT | {
                "name": f"{name}.theta",
                "key": f"{name}.theta",
                "origin": Origin.TURN,
                "unit": "rad",
                "nominal": NOMINAL["theta"],
                "description": f"rotation of the bundle about the line at {where}, best fit",
                "terms": self._turn(nodes),
            }

    def _turn(self, nodes: list[int]) -> tuple[Term, ...]:
        """Rotation that fits the displaced subconductors best: atan2(sum r x x, sum r . x).

        r is the place of a subconductor in the bundle, x = r + u where it is now.
        """
        u2, u3 = NODE_INDEX["u2"], NODE_INDEX["u3"]
        across: list[Term] = []
        along: list[Term] = []
        for node, (r2, r3) in zip(nodes, self.arms.tolist(), strict=True):
            across += [
                Term(Object.NODE, node, u3, weight=r2),
                Term(Object.NODE, node, u2, weight=-r3),
            ]
            along += [
                Term(Object.NODE, node, u2, weight=r2),
                Term(Object.NODE, node, u3, weight=r3),
            ]
        across.append(Term(CONSTANT, weight=0.0))
        along.append(Term(CONSTANT, weight=math.fsum((self.arms**2).ravel().tolist())))
        return (*across, *along)


def _tower_force(
    parts: LineMap, tower: int, held: Sequence[MappedTower], tension: float
) -> Iterator[dict[str, Any]]:
    """Force on a tower, of all phases and, if there are several, of each."""
    groups = {f"tower[{tower}]": (f"tower {tower}", held)}
    if parts.phases > 1:
        groups |= {
            f"tower[{tower}].phase[{one.phase}]": (f"tower {tower} of phase {one.phase}", (one,))
            for one in held
        }
    for name, (where, members) in groups.items():
        for axis, direction in enumerate(DIRECTIONS):
            terms = tuple(
                Term(Object.JUNCTION, junction, axis)
                for one in members
                for junction in one.junctions
            )
            force = OUTPUT | {
                "name": f"{name}.f{axis + 1}",
                "key": f"{name}.f{axis + 1}",
                "origin": Origin.SUM,
                "unit": "N",
                "description": f"force on {where} {direction}, of conductors and strings",
                "nominal": tension * len(terms),
                "terms": terms,
            }
            yield force
            yield preload_output(force, f"{where} {direction}")


def _string(parts: LineMap, held: MappedTower, tension: float) -> Iterator[dict[str, Any]]:
    """Pull and lean of the strings of a phase at a tower."""
    if not held.has_string:
        return
    name, where = _names(parts, f"tower[{held.tower}]", f"tower {held.tower}", held.phase)
    count = len(held.devices)
    whole = "all strings" if count > 1 else "the string"
    mean = "mean lean of the strings" if count > 1 else "lean of the string"
    for key, channel, unit, meaning, weight in (
        ("pull", PULL, "N", f"pull of {whole}", 1.0),
        ("lean_along", LEAN_ALONG, "rad", f"{mean} along the line", 1.0 / count),
        ("lean_across", LEAN_ACROSS, "rad", f"{mean} across the line", 1.0 / count),
    ):
        full = f"{name}.string.{key}"
        yield OUTPUT | {
            "name": full,
            "key": full,
            "origin": Origin.SUM,
            "unit": unit,
            "description": f"{meaning} at {where}",
            "nominal": tension if unit == "N" else NOMINAL["lean"],
            "terms": tuple(
                Term(Object.DEVICE, device, channel, weight=weight) for device in held.devices
            ),
        }
