"""The exact shape of a hanging cable, solved without finite elements."""

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve

GAUSS, WEIGHT = np.polynomial.legendre.leggauss(10)


@dataclass
class ExactCable:
    """A perfectly flexible cable between two points under a uniform load and point loads.

    The forces are statics alone: between two point loads the cable force changes linearly along the
    initial arc length, F(s) = F(0) - q s - (point loads so far). The position follows from dr/ds =
    stretch F / |F|, and F(0) from where the cable has to end. Only the relation of force and
    stretch is a choice:

    - "engineering": Hooke's law on the unstretched length, the elastic catenary of the textbooks;
    - "green": axial Green strain from the initial equilibrium, as in Liu, Yan, Zhang, Zhou (2009).
    """

    length: float  # span [m]
    weight: float  # per metre of the initial equilibrium [N/m]
    horizontal_tension: float  # of the initial equilibrium [N]
    axial_stiffness: float
    height: float = 0.0
    law: str = "green"
    points: list = field(default_factory=list)  # (fraction of the conductor's length, force [N])

    def __post_init__(self):
        c = self.horizontal_tension / self.weight
        self.lowest = self.length / 2 - c * np.arcsinh(
            self.height / (2 * c * np.sinh(self.length / (2 * c)))
        )
        self.arc_to_lowest = c * np.sinh(self.lowest / c)
        self.arc = c * np.sinh((self.length - self.lowest) / c) + self.arc_to_lowest
        self.sag = self.height / 2 - c * (
            np.cosh((self.length / 2 - self.lowest) / c) - np.cosh(self.lowest / c)
        )

    def stretch(self, tension, s):
        """Length over initial length of a piece that was under T0(s) and is under `tension`."""
        initial = np.hypot(self.horizontal_tension, self.weight * (s - self.arc_to_lowest))
        ea = self.axial_stiffness
        if self.law == "engineering":
            return (1.0 + tension / ea) / (1.0 + initial / ea)
        stretch = np.ones_like(tension)
        for _ in range(20):  # tension = stretch (T0 + EA (stretch^2 - 1) / 2)
            error = stretch * (initial + ea * (stretch**2 - 1.0) / 2.0) - tension
            stretch = stretch - error / (initial + ea * (3.0 * stretch**2 - 1.0) / 2.0)
        return stretch

    def solve(self, load=(0.0, 0.0, 0.0), left=(0.0, 0.0, 0.0), right=(0.0, 0.0, 0.0), at=()):
        """Cable force [N] at both ends, and positions [m] at the fractions `at` of the length.

        `load` is per metre of the initial equilibrium, on top of the weight; `left` and `right`
        move the ends.
        """
        q = np.array(load) - [0.0, self.weight, 0.0]
        cuts = sorted({0.0, 1.0, *at, *(fraction for fraction, _ in self.points)})
        ends = np.array([self.length, self.height, 0.0]) + right

        def march(force):
            position, places = np.array(left, dtype=float), {0.0: np.array(left, dtype=float)}
            for a, b in pairwise(cuts):
                force = force - sum(
                    (np.array(f) for fraction, f in self.points if fraction == a), np.zeros(3)
                )
                s = self.arc * (0.5 * (a + b) + 0.5 * (b - a) * GAUSS)
                along = force - q * (s[:, None] - self.arc * a)
                tension = np.linalg.norm(along, axis=1)
                step = self.stretch(tension, s)[:, None] * along / tension[:, None]
                position = position + 0.5 * (b - a) * self.arc * (WEIGHT @ step)
                places[b] = position
                force = force - q * self.arc * (b - a)
            return position, force, places

        h = self.horizontal_tension
        start = np.array([h, self.weight * self.arc_to_lowest, 0.0]) - 0.5 * self.arc * np.array(
            [0.0, *load[1:]]
        )
        scale = np.array([h, self.weight * self.arc, self.weight * self.arc])
        found, _, _, message = fsolve(
            lambda f: march(start + f * scale)[0] - ends, np.zeros(3), xtol=1e-13, full_output=True
        )
        assert np.abs(march(start + found * scale)[0] - ends).max() < 1e-9 * self.length, message
        force = start + found * scale
        _, last, places = march(force)
        return force, last, np.array([places[fraction] for fraction in at])

    @classmethod
    def of(cls, scene, **options):
        """The exact cable of a scene given by its sag or its horizontal tension."""
        span, conductor = scene.span, scene.conductor
        weight = (conductor.mass_per_length + scene.ice.mass_per_length) * span.gravity

        def with_tension(h):
            return cls(
                span.length, weight, h, conductor.axial_stiffness, span.height_difference, **options
            )

        if span.horizontal_tension is not None:
            return with_tension(span.horizontal_tension)
        guess = weight * span.length**2 / (8.0 * span.sag)
        return with_tension(
            brentq(lambda h: with_tension(h).sag - span.sag, 0.5 * guess, 2.0 * guess, xtol=1e-10)
        )


@pytest.fixture(scope="session")
def exact_cable():
    """`ExactCable.of`, from a scene to its exact cable."""
    return ExactCable.of


@pytest.fixture
def span():
    """A steel-reinforced conductor over 300 m, as plain data; its elastic elongation matters."""
    return {
        "title": "a span",
        "span": {"length": 300.0, "horizontal_tension": 20000.0},
        "conductor": {
            "diameter": 0.028,
            "mass_per_length": 1.6,
            "axial_stiffness": 3e7,
            "torsional_stiffness": 250.0,
            "torsional_inertia": 1.6e-4,
        },
    }
