"""Sections and bundles at random, from a seed; rounded, so that a case can be read."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

SEED = 13

CONDUCTORS = {  # mass [kg/m] when hanging, area [m2], modulus [Pa], diameter [m]
    "Drake": (1.628, 468.5e-6, 62.0e9, 0.02813),
    "Zebra": (1.621, 484.5e-6, 69.0e9, 0.02862),
    "Aster 570": (1.574, 570.2e-6, 54.0e9, 0.03105),
}
"""Typical values of three conductors; what counts is that all programs use the same."""

EXPANSION = 2.0e-5


@dataclass(frozen=True)
class Draw:
    """A section: spans [m], rises [m], strings (length [m], weight [N]), horizontal tension [N]."""

    conductor: str
    spans: tuple[float, ...]
    rises: tuple[float, ...]
    strings: tuple[tuple[float, float], ...]
    tension: float

    @property
    def mass(self) -> float:
        return CONDUCTORS[self.conductor][0]

    @property
    def axial_stiffness(self) -> float:
        return CONDUCTORS[self.conductor][1] * CONDUCTORS[self.conductor][2]


def draw(rng: np.random.Generator, spans: int, gravity: float) -> Draw:
    """A section whose conductor presses on every string by at least 0.4 of its weight span."""
    while True:
        conductor = str(rng.choice(sorted(CONDUCTORS)))
        lengths = np.round(rng.uniform(180.0, 420.0, spans))
        rises = np.round(lengths * rng.uniform(-0.09, 0.09, spans), 1)
        weight = CONDUCTORS[conductor][0] * gravity
        tension = float(np.round(weight * rng.uniform(1300.0, 2000.0), -2))
        strings = tuple(
            (float(np.round(rng.uniform(1.6, 3.4), 1)), float(np.round(rng.uniform(300, 900), -1)))
            for _ in range(spans - 1)
        )
        slope = rises / lengths
        carried = 0.5 * weight * (lengths[:-1] + lengths[1:]) + tension * (slope[:-1] - slope[1:])
        if np.all(carried > 0.2 * weight * (lengths[:-1] + lengths[1:])):
            return Draw(conductor, tuple(lengths.tolist()), tuple(rises.tolist()), strings, tension)


def polygon(count: int, spacing: float) -> tuple[tuple[float, float], ...]:
    """Offsets (up, downwind) [m] of a bundle: twin vertical, triple with one below, quad square."""
    if count == 2:
        return ((0.5 * spacing, 0.0), (-0.5 * spacing, 0.0))
    radius = 0.5 * spacing / np.sin(np.pi / count)
    angles = 2.0 * np.pi * np.arange(count) / count + (np.pi / 4 if count == 4 else np.pi)
    return tuple((float(radius * np.cos(a)), float(radius * np.sin(a))) for a in angles)
