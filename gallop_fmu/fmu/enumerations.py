"""Enumerations of the FMU's variables: what their whole numbers mean."""

from __future__ import annotations

from typing import NamedTuple

from gallop_fmu.foundation.integrators import INTEGRATORS
from gallop_fmu.foundation.outcome import Outcome


class Item(NamedTuple):
    """A number of an enumeration, its name and what it means."""

    value: int
    name: str
    description: str


STATUS, INTEGRATOR = "Status", "Integrator"

ENUMERATIONS = {
    STATUS: tuple(
        Item(outcome.code, outcome.name.lower(), outcome.sentence)
        for outcome in Outcome
        if outcome is not Outcome.STOPPED_BY_USER  # only Python's own runs can be stopped
    ),
    INTEGRATOR: tuple(
        Item(one.code, one.name, one.description)
        for one in sorted(INTEGRATORS.values(), key=lambda one: one.code)
    ),
}
"""Items by the name of the enumeration, in the order of their values."""
