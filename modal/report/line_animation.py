"""Motion of a line over a few periods, as shapes and their amplitudes, for the animation."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.line_plots import tower_points
from gallop_fmu.simulation.line_result import LineResult
from modal.report.animation import DECIMALS, OTHER_PERIODS, shown_part

Array = NDArray[np.float64]

MAX_POINTS = 24
"""Largest number of points of a span that are drawn, besides its left end."""

MAX_FRAMES = 800
"""Largest number of records in a page; the script interpolates the amplitudes by cubics."""

MAX_ERROR = 0.005
"""Largest error [m] of a position by leaving out shapes."""


@dataclass(frozen=True)
class LineAnimation:
    """A moving line: a place at rest, and the sum of shapes times amplitudes.

    Attributes
    ----------
    part : str
        Name of the part of the run that is shown.
    time : ndarray, shape (frame,)
        Times [s].
    rest : ndarray, shape (point, 3)
        Positions x1, x2, x3 [m] at rest, of the centre of each bundle.
    conductors : list of tuple of int
        First and last point of each span and phase.
    strings : list of tuple
        Point of a tower, x1, x2, x3 [m], and the number of the point of the clamp.
    shapes : ndarray, shape (shape, point, 2)
        Upward and downwind displacement [m] for the amplitude 1.
    amplitude : ndarray, shape (frame, shape)
        Amplitude of each shape.
    """

    part: str
    time: Array
    rest: Array
    conductors: list[tuple[int, int]]
    strings: list[tuple[Array, int]]
    shapes: Array
    amplitude: Array

    @property
    def moved(self) -> Array:
        """Height x2 and downwind place x3 [m] over frames and points."""
        return np.asarray(self.rest[:, 1:] + np.einsum("fs,spk->fpk", self.amplitude, self.shapes))

    def packed(self) -> dict[str, Any]:
        """Convert to nested lists of rounded numbers, for JavaScript."""
        moved = self.moved
        clamps = [(point.round(2).tolist(), clamp) for point, clamp in self.strings]
        return {
            "time": self.time.round(3).tolist(),
            "rest": self.rest.round(3).tolist(),
            "conductors": self.conductors,
            "strings": clamps,
            "shapes": self.shapes.round(5).tolist(),
            "amplitude": self.amplitude.round(DECIMALS).tolist(),
            "lowest": moved.min(axis=0).round(3).tolist(),
            "highest": moved.max(axis=0).round(3).tolist(),
        }


def part_of_line(result: LineResult, span: int) -> tuple[str, NDArray[np.intp]]:
    """Select the part of a run that is shown, by the motion of a span, counted from 1.

    Returns
    -------
    str, ndarray
        Name of the part, and its records.
    """
    middle = result.bundle(span, 1)
    histories = [np.asarray(middle[name].values) for name in ("u2", "u3")]
    return shown_part(np.asarray(middle.time.values), histories, OTHER_PERIODS)


def line_animation(result: LineResult, span: int) -> LineAnimation:
    """Select the last periods of a span, or those of its largest motion if that decays later.

    The displacements of all points over the frames are a sum of orthogonal shapes with amplitudes
    (singular value decomposition); as many shapes are kept as `MAX_ERROR` needs.

    Parameters
    ----------
    result
        A run with all nodes.
    span
        Span whose period decides, from 1.
    """
    data = result.dataset
    time = np.asarray(data.time.values)
    part, chosen = part_of_line(result, span)
    frames = chosen[:: math.ceil(len(chosen) / MAX_FRAMES)]
    columns, conductors = _points(result)
    rest = _means([data[name].values for name in ("x1", "x2", "x3")], columns)
    moves = _means([data[name].values[frames] for name in ("u2", "u3")], columns)
    flat = moves.transpose(1, 2, 0).reshape(len(frames), -1)  # frame; point and direction
    left, sizes, right = np.linalg.svd(flat, full_matrices=False)
    count = _shapes_needed(flat, left * sizes, right)
    return LineAnimation(
        part=part,
        time=time[frames],
        rest=rest.T,
        conductors=conductors,
        strings=_strings(result, rest.T),
        shapes=right[:count].reshape(count, -1, 2),
        amplitude=(left * sizes)[:, :count],
    )


def _points(result: LineResult) -> tuple[list[NDArray[np.intp]], list[tuple[int, int]]]:
    """Columns of the nodes whose mean is a point, and first and last point of each conductor."""
    place = {node: column for column, node in enumerate(result.dataset.node.values.tolist())}
    columns: list[NDArray[np.intp]] = []
    conductors = []
    for phase in range(1, result.map.phases + 1):
        for span in range(1, result.map.spans + 1):
            chains = result.map.bundle(span, phase)
            count = 2 * chains[0].elements + 1
            points = np.linspace(0, count - 1, min(count, MAX_POINTS + 1)).round().astype(int)
            conductors.append((len(columns), len(columns) + len(points) - 1))
            columns += [np.array([place[chain.first_node + k] for chain in chains]) for k in points]
    return columns, conductors


def _means(values: list[Array], columns: list[NDArray[np.intp]]) -> Array:
    """Mean of the columns of each point, over values and points (and, before these, frames)."""
    return np.stack([np.stack([v[..., own].mean(-1) for own in columns], -1) for v in values])


def _shapes_needed(moves: Array, amplitude: Array, shapes: Array) -> int:
    """Smallest number of shapes whose sum is within `MAX_ERROR` of all moves; at least 1."""
    rest = moves.copy()
    for count in range(1, len(shapes) + 1):
        rest -= np.outer(amplitude[:, count - 1], shapes[count - 1])
        if np.abs(rest).max() <= MAX_ERROR:
            return count
    return len(shapes)


def _strings(result: LineResult, rest: Array) -> list[tuple[Array, int]]:
    """Points of the towers with the numbers of the points nearest to the clamps."""
    found = []
    for tower in result.map.towers:
        junctions = [int(result.map.node_of_junction[j]) for j in tower.junctions]
        nodes = result.dataset.node.values.tolist()
        if tower.has_string and set(junctions) <= set(nodes):
            own = [nodes.index(node) for node in junctions]
            clamp = np.array([result.dataset[x].values[own].mean() for x in ("x1", "x2", "x3")])
            nearest = int(np.argmin(np.linalg.norm(rest - clamp, axis=1)))
            found += [(point, nearest) for point in tower_points(result, tower)]
    return found
