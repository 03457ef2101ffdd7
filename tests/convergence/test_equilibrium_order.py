"""Order of convergence of the initial equilibrium with the number of elements."""

import numpy as np
from scipy.optimize import brentq

from gallop_fmu.engine.model import Model
from gallop_fmu.scene.scene import Scene

ELEMENTS = (4, 8, 16, 32)  # at 64 round-off begins to show
CONDUCTOR = {
    "diameter": 0.028, "mass_per_length": 1.5, "axial_stiffness": 4e7, "torsional_stiffness": 150.0,
    "torsional_inertia": 1.5e-4,
}  # fmt: skip
WEIGHT = 1.5 * 9.81


def equilibrium(elements, **given):
    span = {"length": 100.0, **given}
    scene = {
        "title": "a span",
        "span": span,
        "conductor": CONDUCTOR,
        "numerics": {"elements": elements},
    }
    return Model(Scene.from_dict(scene)).equilibrium()


def sag_of(c):
    return c * (np.cosh(50.0 / c) - 1.0)


def orders(errors):
    return np.log2(np.abs(errors[:-1]) / np.abs(errors[1:]))


def test_sag_and_length_from_tension():
    found = [equilibrium(n, horizontal_tension=4600.0) for n in ELEMENTS]
    c = 4600.0 / WEIGHT
    sag = np.array([e.sag for e in found]) / sag_of(c) - 1.0
    length = np.array([e.length for e in found]) / (2.0 * c * np.sinh(50.0 / c)) - 1.0
    assert np.all(np.abs(orders(sag) - 4.0) < 0.05)  # observed 4.006, 4.001, 4.000
    assert np.all(np.abs(orders(length) - 4.0) < 0.1)  # observed 3.94, 3.98, 4.00
    assert abs(sag[0]) < 1e-6  # observed 2.2e-7


def test_tension_from_sag():
    c = brentq(lambda c: sag_of(c) - 4.0, 100.0, 1000.0, xtol=1e-12)
    found = (
        np.array([equilibrium(n, sag=4.0).horizontal_tension for n in ELEMENTS]) / (c * WEIGHT)
        - 1.0
    )
    assert np.all(np.abs(orders(found) - 4.0) < 0.05)  # observed 4.006, 4.002, 4.000
    assert abs(found[0]) < 1e-6  # observed 2.2e-7
