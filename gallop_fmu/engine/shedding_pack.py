"""Ice that falls from a line, packed into the kernel's table."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from gallop_fmu.engine.ctypes_structs import CShedding
from gallop_fmu.engine.line_map import MappedChain, MappedShedding
from gallop_fmu.engine.tables import Tables
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.shedding import Shedding
from gallop_fmu.scene.stations import Conductor, conductors_of, icy_pieces

ASSUMED_CURVE = "bare conductor"
"""In place of the dotted path of a curve that the scene does not give."""


def pack_sheddings(
    tables: Tables, scene: LineScene, chains: Sequence[MappedChain]
) -> Iterator[MappedShedding]:
    """Add the table of falling ice; yield its items.

    Parameters
    ----------
    tables
        Tables, of which only this one is missing.
    scene
        The line.
    chains
        Its chains with their stations.
    """
    places = [Conductor(chain.span, chain.phase, chain.subconductor) for chain in chains]
    sections: dict[str, int] = {}
    for number, shedding in enumerate(scene.shedding, start=1):
        path = f"shedding.{number - 1}"
        for conductor in conductors_of(scene, shedding):
            index = places.index(conductor)
            for piece in icy_pieces(scene, shedding, conductor):
                corner = np.argmin(np.abs(np.array(chains[index].fractions) - piece.from_station))
                item = CShedding(
                    chain=index,
                    corner=chains[index].corners[int(corner)],
                    cross_section=_bare_section(tables, scene, shedding, path, sections),
                    time=math.inf,
                    acceleration=math.inf,
                )
                tables.add("shedding", item)
                tables.copy(shedding, "shedding", path, {"time": None, "acceleration": None})
                yield MappedShedding(
                    number,
                    *conductor,
                    piece.from_station,
                    piece.to_station,
                    piece.ice.mass_per_length,
                )


def _bare_section(
    tables: Tables, scene: LineScene, shedding: Shedding, path: str, sections: dict[str, int]
) -> int:
    """Index of the cross-section without ice; parts with the same curve share it."""
    own = shedding.aerodynamics is not None
    curve_path = f"{path}.aerodynamics" if own else ASSUMED_CURVE
    if curve_path not in sections:
        sections[curve_path] = len(tables.tables["cross_section"])
        tables.add_cross_section(scene.conductor, None, "", scene.damping)
        if own or scene.aerodynamics is not None:
            curve = shedding.bare_curve
            tables.set_curve(curve, tables.add_curve(curve, curve_path), curve_path)
    return sections[curve_path]
