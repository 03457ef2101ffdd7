"""Phases of a line: conductors or bundles side by side."""

from __future__ import annotations

from typing import ClassVar

from gallop_fmu.scene.bundle import Offset
from gallop_fmu.scene.fields import Section, Text, quantity, setting


class Phase(Section):
    """One phase: a conductor or a bundle at its own place on the towers."""

    NUMBERED: ClassVar[str] = "phase"

    name: Text = setting(..., "name of the phase")
    offset: Offset = quantity((0.0, 0.0), "m", "position x2, x3 of the attachment points")
