"""A valid scene to modify."""

import pytest


@pytest.fixture
def minimal():
    """A minimal scene as plain data."""
    return {
        "title": "a span",
        "span": {"length": 100.0, "sag": 4.0},
        "conductor": {
            "diameter": 0.028,
            "mass_per_length": 1.5,
            "axial_stiffness": 4e7,
            "torsional_stiffness": 150.0,
            "torsional_inertia": 1.5e-4,
        },
    }
