"""Names of motions in words: rest, one loop, one loop with swing at half frequency, two loops."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal.continuation.branch import Branch
from modal.continuation.equations import GRID
from modal.continuation.events import Event
from modal.continuation.path import Point
from modal.motions.line_model import STRING_SWING
from modal.motions.span_model import SpanModel

Array = NDArray[np.float64]

NUMBER_WORDS = ("no", "one", "two", "three", "four", "five", "six")

MIN_SHARE, MIN_HALF_SHARE = 0.03, 0.005
"""Kinetic energy of a part of a motion, relative to the largest part, above which it is named; the
second for a part at half the frequency of that one."""

ROTATED, TURNED_OVER = 30.0, 90.0
"""Mean twist [deg] at mid-span above which an equilibrium is called rotated, or turned over."""

GRID_OF_SHAPE = 16
"""Phases at which a small oscillation is looked at for its name."""

SAMPLES = 8
"""Largest number of points of a branch that are looked at for its name."""


@dataclass(frozen=True)
class Part:
    """Part of a motion in one family and one symmetry about mid-span.

    Attributes
    ----------
    family : str
        Family of its modes.
    loops : int
        Half-waves of its strongest mode.
    energy : float
        Mean kinetic energy [J].
    harmonic : int
        Strongest harmonic, of the frequency of the periodic motion.
    """

    family: str
    loops: int
    energy: float
    harmonic: int


def parts_of(point: Point, model: SpanModel) -> list[Part]:
    """Parts of a periodic motion that move noticeably, the strongest first."""
    velocity = point.at(GRID)[:, model.size :]
    energy = 0.5 * np.mean(velocity**2, axis=0)  # the shapes are orthonormal in the mass
    found = []
    for family, alike in model.groups():
        strongest = max(alike, key=lambda i: energy[i])
        harmonics = np.abs(np.fft.rfft(velocity[:, strongest]))
        found.append(
            Part(
                family,
                model.loops(strongest),
                float(energy[alike].sum()),
                int(np.argmax(harmonics[1:])) + 1,
            )
        )
    found.sort(key=lambda part: -part.energy)
    first = found[0]
    return [part for part in found if part.energy > _least_share(part, first) * first.energy]


def _least_share(part: Part, first: Part) -> float:
    return MIN_HALF_SHARE if 2 * part.harmonic == first.harmonic else MIN_SHARE


def name_of_motion(point: Point, model: SpanModel) -> str:
    """Name of an equilibrium or of a periodic motion."""
    degrees = float(np.degrees(point.mean[: model.size] @ model.middle[:, 3]))
    if point.equations.kind == "equilibrium":
        if abs(degrees) > TURNED_OVER:
            return "rest, turned over"
        return "rest, rotated" if abs(degrees) > ROTATED else "rest"
    first, *others = parts_of(point, model)
    words = " and ".join(_other(part, first) for part in others)
    name = _main(first) + (f" with {words}" if words else "")
    name += model.where(model.watched_at(point.at(GRID)[:, : model.size]))
    return f"{name}, turned over" if abs(degrees) > TURNED_OVER else name


def name_of_branch(branch: Branch, model: SpanModel) -> str:
    """Name of a branch: of its point with the most parts, among the stable ones if there are any.

    Equilibria have the name of the first point, or of the last if they begin on another branch.
    """
    points = branch.points
    if branch.kind == "equilibrium":
        return name_of_motion(points[0 if branch.origin is None else -1], model)
    stable = [point for point in points if point.is_stable]
    candidates = stable or points
    step = -(-len(candidates) // SAMPLES)
    candidates = candidates[len(candidates) // 2 :: step] or candidates[-1:]
    return name_of_motion(max(candidates, key=lambda one: len(parts_of(one, model))), model)


def name_of_disturbance(event: Event, model: SpanModel) -> str:
    """Name of the motion that begins at a torus: the strongest part of the growing disturbance."""
    word, strongest = disturbance_of(event, model)
    return _main(Part(word, model.loops(strongest), 0.0, 1))


def disturbance_of(event: Event, model: SpanModel) -> tuple[str, int]:
    """Family of the disturbance that begins to grow at an event of an orbit, and its main mode.

    A disturbance x of the state at the start of a period, with the multiplier m, is a solution of
    (A + m B) x = 0, with the matrices of `modal.continuation.condensation`.
    """
    from scipy.linalg import eig

    condensed = event.point.linear.matrix
    values, vectors = eig(-condensed.first, condensed.last)
    critical = np.exp(2j * np.pi * event.rotation)
    x = vectors[:, int(np.argmin(np.abs(values - critical)))]
    squares = np.abs(x) ** 2
    rates = np.abs(np.diag(model.stiffness)) * squares[: model.size] + squares[model.size :]
    word, alike = max(model.groups(), key=lambda one: float(rates[one[1]].sum()))
    return word, max(alike, key=lambda i: rates[i])


def name_of_oscillation(shape: NDArray[np.complex128], model: SpanModel) -> tuple[str, int, str]:
    """Family, half-waves, and name of a small oscillation with a complex shape (mode,)."""
    energy = np.abs(shape) ** 2  # the shapes are orthonormal in the mass
    word, alike = max(model.groups(), key=lambda one: float(energy[one[1]].sum()))
    loops = model.loops(max(alike, key=lambda i: energy[i]))
    turns = np.exp(2j * np.pi * np.arange(GRID_OF_SHAPE) / GRID_OF_SHAPE)
    moves = model.watched_at(np.real(turns[:, None] * shape))
    return word, loops, _main(Part(word, loops, 0.0, 1)) + model.where(moves)


def loops_in_words(number: int) -> str:
    """Number of loops in words."""
    word = NUMBER_WORDS[number] if number < len(NUMBER_WORDS) else str(number)
    return f"{word} loop{'' if number == 1 else 's'}"


def _main(part: Part) -> str:
    if part.family == "vertical":
        return loops_in_words(part.loops)
    if part.family == STRING_SWING:
        return STRING_SWING
    name = {"horizontal": "swing", "torsional": "twist", "sub-span": "sub-span motion"}.get(
        part.family, part.family
    )
    return f"{name} in {loops_in_words(part.loops)}"


def _other(part: Part, first: Part) -> str:
    name = _main(part)
    if part.family == "horizontal" and part.loops == 1:
        name = "swing"
    return f"{name} at half frequency" if 2 * part.harmonic == first.harmonic else name
