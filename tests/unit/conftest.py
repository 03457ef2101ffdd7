"""A valid scene to modify, and the command line in an empty folder."""

import pytest
from typer.testing import CliRunner

from gallop_fmu.cli import main


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


@pytest.fixture
def invoke(tmp_path, monkeypatch):
    """Run a command of gallop-fmu, or of another `app`, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "200")
    return lambda *words, app=main.app: CliRunner().invoke(app, [str(word) for word in words])
