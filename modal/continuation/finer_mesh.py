"""Confirmation of events of an orbit on a finer mesh."""

from __future__ import annotations

import numpy as np

from modal.continuation import collocation as co
from modal.continuation.equations import OrbitEquations, length
from modal.continuation.events import SINGULAR, Event
from modal.continuation.path import Settings, Stepper
from modal.continuation.problem import ContinuationError

MAX_CHANGE = 0.05
"""Change of the critical multiplier on a finer mesh up to which an event is confirmed."""

CHANGES_STABILITY = ("torus", "period doubling", "symmetry breaking", "branch point")
"""Events at which a multiplier of an orbit reaches the unit circle."""


def mesh_doubt(event: Event, settings: Settings) -> str:
    """Reason why an event of an orbit is not confirmed on a finer mesh; empty if it is.

    A fast, nearly undamped disturbance has a multiplier on the unit circle whose angle depends on
    the mesh, although the orbit itself is resolved. With twice as many intervals, an event has a
    multiplier near the same place.

    Parameters
    ----------
    event
        A change of stability.
    settings
        Bounds of the continuation that found it.
    """
    point, old = event.point, event.point.equations
    if event.kind not in CHANGES_STABILITY or not isinstance(old, OrbitEquations):
        return ""
    fine = old.remeshed(point.x, min(2 * old.intervals, co.MAX_INTERVALS))
    x, along = old.transferred(point.x, fine), old.transferred(point.tangent, fine)
    is_double = event.kind in ("symmetry breaking", "branch point")
    try:
        found = Stepper(settings).correct(
            fine, x, x, along / length(fine, along), 0.0, cutoff=SINGULAR if is_double else 0.0
        )
    except ContinuationError as error:
        return f"with {fine.intervals} intervals in place of {old.intervals}: {error}"
    away = float(np.min(np.abs(found.spectrum - event.value)))
    if away <= MAX_CHANGE:
        return ""
    return (
        f"the multiplier {_rounded(event.value)} at {point.parameter:.6g} belongs to the mesh: with"
        f" {fine.intervals} intervals in place of {old.intervals}, the nearest one is {away:.2g}"
        " away"
    )


def _rounded(value: complex) -> str:
    return f"{value:.3g}" if value.imag else f"{value.real:.3g}"
