"""Gap between two phases: from the area that the motion covers, and from the ellipses of a rule.

Phases that nothing connects move alike, but not at the same time: the gap is that between any two
points of their areas. An area is described by its support function: the farthest point in each
direction, of which the convex hull follows. Two convex areas with the support functions
h1(n) and h2(n) have the gap

    max over n of (n . d - h1(n) - h2(-n)),

with d the distance of their origins; a negative gap is an overlap.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.simulation.clearance import cigre_322_single_loop, davison_single_loop
from gallop_fmu.simulation.line_result import LineResult

Array = NDArray[np.float64]

DIRECTIONS = 360
"""Number of directions of a support function; the error of a gap is 4e-5 of it."""

STATIONS = (0.25, 0.5, 0.75)
"""Places in a span at which orbits are compared."""

_ANGLE = np.linspace(0.0, 2.0 * math.pi, DIRECTIONS, endpoint=False)
NORMALS = np.stack([np.sin(_ANGLE), np.cos(_ANGLE)], axis=1)
"""Directions (x2, x3); the opposite of direction k is direction k + `DIRECTIONS` / 2."""


START_UP = 20.0
"""Time [s] after which a motion is no longer that of the sudden wind at the start."""


def motion_window(result: LineResult) -> tuple[float, float]:
    """Start and end [s] of the part of a run whose motion counts.

    That is the window of the amplitudes at the end; if the iced section turned over, the whole run
    after `START_UP`, because the motion is often small after that.
    """
    last = float(result.dataset.time[-1])
    if result.motion.kind == "turned over" and last > 2.0 * START_UP:
        return START_UP, last
    return result.window()


def support(x2: Array, x3: Array) -> Array:
    """Return the farthest distance [m] of points in each direction."""
    return np.asarray((NORMALS @ np.stack([np.ravel(x2), np.ravel(x3)])).max(axis=1))


def gap(first: Array, second: Array, distance: Array) -> float:
    """Return the gap [m] between two areas; negative if they overlap.

    Parameters
    ----------
    first, second : ndarray, shape (direction,)
        Their support functions.
    distance : ndarray, shape (2,)
        Origin of the second from that of the first, x2 and x3 [m].
    """
    opposite = np.roll(second, DIRECTIONS // 2)
    return float(np.max(NORMALS @ distance - first - opposite))


def phase_distances(offsets: Sequence[Sequence[float]]) -> dict[tuple[int, int], Array]:
    """Return the distance x2, x3 [m] of each two phases, which count from 1."""
    pairs = combinations(range(1, len(offsets) + 1), 2)
    return {
        (i, j): np.subtract(offsets[j - 1], offsets[i - 1]).astype(np.float64) for i, j in pairs
    }


def orbit_gaps(result: LineResult, offsets: Sequence[Sequence[float]]) -> dict[int, float]:
    """Return the smallest gap [m] of phases in each span, from the orbits in `motion_window`.

    Parameters
    ----------
    result
        A run of the line with one phase, or with all.
    offsets
        Position x2, x3 [m] of each phase.
    """
    distances = phase_distances(offsets)
    if not distances or len(result.dataset.time) < 2:
        return {}
    areas = _areas(result)
    one = result.map.phases == 1
    found: dict[int, float] = {}
    for span in range(1, result.map.spans + 1):
        found[span] = min(
            gap(
                areas[span, 1 if one else i, station],
                areas[span, 1 if one else j, station],
                distance,
            )
            for (i, j), distance in distances.items()
            for station in STATIONS
        )
    return found


def _areas(result: LineResult) -> dict[tuple[int, int, float], Array]:
    """Support functions of the motion of each phase in each span, from its place at rest."""
    start, stop = motion_window(result)
    data = result.dataset
    part = (data.time.values >= start - 1e-9) & (data.time.values <= stop + 1e-9)
    offsets = [phase.offset for phase in result.scene.phases]
    recorded = {node: column for column, node in enumerate(data.node.values.tolist())}
    u2, u3 = data["u2"].values, data["u3"].values
    x2, x3 = data["x2"].values, data["x3"].values
    areas: dict[tuple[int, int, float], Array] = {}
    for span in range(1, result.map.spans + 1):
        for phase in range(1, result.map.phases + 1):
            for station in STATIONS:
                columns = [
                    recorded[node]
                    for chain in result.map.bundle(span, phase)
                    if (node := chain.nearest_node(station)) in recorded
                ]
                centre = float(np.mean(x2[columns]))
                # Height of the bundle's centre at rest is the origin; offsets are horizontal parts.
                areas[span, phase, station] = support(
                    u2[np.ix_(part, columns)] + (x2[columns] - centre),
                    u3[np.ix_(part, columns)] + (x3[columns] - offsets[phase - 1][1]),
                )
    return areas


def ellipse_gaps(
    sags: Mapping[int, float], diameter: float, offsets: Sequence[Sequence[float]]
) -> dict[str, dict[int, float]]:
    """Return the smallest gap [m] of the ellipses of phases in each span, by rule.

    Parameters
    ----------
    sags
        Sag [m] of each span, from 1, with ice.
    diameter
        Diameter of the conductor without ice [m].
    offsets
        Position x2, x3 [m] of each phase.
    """
    distances = phase_distances(offsets)
    found: dict[str, dict[int, float]] = {"CIGRE 322": {}, "Davison": {}}
    for span, sag in sags.items() if distances else ():
        ellipses = {"Davison": davison_single_loop(sag)}
        if sag > 6.25 * diameter:
            ellipses["CIGRE 322"] = cigre_322_single_loop(sag, diameter)
        for name, ellipse in ellipses.items():
            x3, x2 = ellipse.outline()
            area = support(x2, x3)
            found[name][span] = min(gap(area, area, d) for d in distances.values())
    return found
