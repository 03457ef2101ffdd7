"""Scenes of the stress suite that a test is about."""

import json
import sys
from pathlib import Path

import pytest

sys.path[:0] = [str(Path(__file__).resolve().parents[2] / "benchmarks")]

from stress.scenes import Stress  # noqa: E402

DATA = Path(__file__).parent / "data"


@pytest.fixture
def kept_scene():
    """A scene of `data` by its name: the seed and the number with which the suite once drew it."""
    return lambda name: Stress(**json.loads((DATA / f"{name}.json").read_text("utf-8")))
