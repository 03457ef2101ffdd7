"""Scenes of the stress suite that a test is about."""

import json
from pathlib import Path

import pytest

from support.random_spans import Stress

DATA = Path(__file__).parent / "data"


@pytest.fixture
def kept_scene():
    """A scene of `data` by its name, the seed and number with which it was drawn."""
    return lambda name: Stress(**json.loads((DATA / f"{name}.json").read_text("utf-8")))
