"""A variable of the FMU, for model description, run-time, documentation and tests."""

from __future__ import annotations

import enum
import math
from dataclasses import dataclass
from typing import Literal, NamedTuple


class Origin(enum.IntEnum):
    """Source of the value of a variable: resource_origin in kernel/resource.h."""

    PARAMETER = 0
    INPUT = 1
    SUM = 2
    """Output: the sum of its terms."""
    TURN = 3
    """Output: atan2 of the sums of the first and the second half of its terms [rad]."""
    STATUS = 4
    """Outcome of the last call."""
    STATIC = 5
    """Output: the sum of its terms in the initial equilibrium, in still air."""


class TargetKind(enum.IntEnum):
    """What an input sets: resource_target_kind."""

    WIND = 0
    ATTACK_ANGLE = 1
    MOTION = 2
    WIND_DIRECTION = 3
    VELOCITY = 4


class Target(NamedTuple):
    """A number that an input sets: speed or direction of a field, or the motion of a junction."""

    kind: TargetKind
    item: int = 0
    axis: int = 0


POINT = -1
"""Object of a term: the node nearest to `station` of a chain, a fraction of its nodes."""

CONSTANT = -2
"""Object of a term: the number one."""


class Term(NamedTuple):
    """A part of an output: `weight` times the value of a probe."""

    object: int
    item: int = 0
    channel: int = 0
    station: float = 0.0
    weight: float = 1.0


@dataclass(frozen=True, slots=True)
class Variable:
    """One variable of the FMU.

    Attributes
    ----------
    name, reference
        Name and value reference; a reference is not used twice, whatever the type.
    origin, key
        Source of the value: the name of an input, the dotted path of a parameter, the name
        of a channel.
    causality, variability, initial, type
        As in FMI 2.0; `initial` is empty where the standard forbids it.
    unit
        Unit of a Real, one of `gallop_fmu.fmu.units.BASE_UNITS`; "1" for pure numbers, empty for
        whole numbers.
    description
        One phrase.
    start
        Start value; None for calculated variables.
    minimum, maximum
        Bounds of the host's values; FMI's are inclusive.
    minimum_excluded, maximum_excluded
        True if the bound itself is refused.
    nominal
        Order of magnitude; every continuous variable has one.
    enumeration
        Of an Enumeration: its name in `gallop_fmu.fmu.enumerations.ENUMERATIONS`.
    targets
        Of an input: what it sets.
    terms
        Of an output: what it consists of.
    """

    name: str
    reference: int
    origin: Origin
    key: str
    causality: Literal["input", "output", "parameter"]
    variability: Literal["continuous", "discrete", "fixed"]
    initial: Literal["", "calculated", "exact"]
    type: Literal["Real", "Integer", "Enumeration"]
    unit: str
    description: str
    start: float | int | None = None
    minimum: float | int | None = None
    maximum: float | int | None = None
    minimum_excluded: bool = False
    maximum_excluded: bool = False
    nominal: float | None = None
    enumeration: str = ""
    targets: tuple[Target, ...] = ()
    terms: tuple[Term, ...] = ()

    def allows(self, value: float) -> bool:
        """Return True if the bounds include a value."""
        low = -math.inf if self.minimum is None else self.minimum
        high = math.inf if self.maximum is None else self.maximum
        above = value > low if self.minimum_excluded else value >= low
        return above and (value < high if self.maximum_excluded else value <= high)

    @property
    def allowed(self) -> str:
        """Return the bounds in words, as `bounds_of` in kernel/cosim_values.c; may be empty."""
        low = "greater than" if self.minimum_excluded else "at least"
        high = "less than" if self.maximum_excluded else "at most"
        bounds = ((low, self.minimum), (high, self.maximum))
        return " and ".join(f"{word} {bound:.6g}" for word, bound in bounds if bound is not None)
