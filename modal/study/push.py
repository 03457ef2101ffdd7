"""A start of a simulation that is unlike on all spans and phases."""

from __future__ import annotations

import math
from typing import Any

from gallop_fmu import LineScene

PUSH, PUSH_TIME = 0.05, 1.0
"""Largest force that starts a simulation, relative to the weight of a span, and its rise [s]."""

GOLDEN = 2.4
"""Difference of phase [rad] of the forces on the spans and phases, so that all start unlike."""


def pushed(scene: LineScene) -> LineScene:
    """Return the line with forces in its first seconds, unlike on each span and phase."""
    law = {
        "kind": "pulse",
        "initial": 0.0,
        "peak": 1.0,
        "start": 0.0,
        "rise": PUSH_TIME,
        "fall_start": 1.5 * PUSH_TIME,
        "fall": 0.5 * PUSH_TIME,
    }
    loads: list[dict[str, Any]] = scene.model_dump(mode="json", exclude_none=True)["loads"]
    for span, one in enumerate(scene.section.spans, start=1):
        per_length = scene.conductor.mass_per_length + scene.ice_of_span(span).mass_per_length
        most = PUSH * per_length * one.length * scene.section.gravity
        for phase in range(1, len(scene.phases) + 1):
            up = most * math.cos(GOLDEN * ((span - 1) * len(scene.phases) + phase - 1))
            loads.append(
                {
                    "span": span,
                    "phase": phase,
                    "position": 0.5,
                    "force": [0.0, up, 0.2 * most],
                    "law": law,
                }
            )
    return scene.with_values({"loads": loads})
