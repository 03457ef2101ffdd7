"""Interface between the codes and the measurement."""

from __future__ import annotations

from collections.abc import Callable, Hashable
from dataclasses import dataclass

from scenes import Array

OURS = "gallop-fmu"


class NotReachedError(Exception):
    """The code did not get through the run with this setting."""


@dataclass(frozen=True)
class Case:
    """One code with one setting.

    Attributes
    ----------
    code, family, setting
        For example ``OpenSees``, ``OpenSees, Newmark, consistent mass`` and ``step 0.01 s``; a
        family is one curve.
    model
        What the case shares with its converged solution: mesh and mass; None if only the total
        error is wanted.
    prepare
        Builds the model and returns the function that is timed: the time loop, giving u2 and u3 at
        mid-span as (output times, 2) [m].
    """

    code: str
    family: str
    setting: str
    model: Hashable | None
    prepare: Callable[[], Callable[[], Array]]
