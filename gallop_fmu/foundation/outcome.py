"""How a calculation ended: one enumeration, each member with a sentence and a cure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum


class Outcome(Enum):
    """How a calculation ended.  The values are those of the kernel's ``gallop_outcome``.

    ``outcome.sentence`` says what happened, ``outcome.cure`` what to do about it.
    """

    COMPLETED = (0, "the calculation was completed", "")
    NEWTON_STALLED = (
        1,
        (
            "the Newton iteration did not converge, although the time step was halved as often as"
            " allowed"
        ),
        (
            "reduce numerics.time_step, raise numerics.max_halvings, or check the scene for a"
            " sudden jump in load or wind"
        ),
    )
    NON_FINITE = (
        2,
        "the motion became infinite or not a number",
        (
            "reduce numerics.time_step and check stiffness, mass and the aerodynamic coefficients"
            " of the scene"
        ),
    )
    ANGLE_OUT_OF_RANGE = (
        3,
        "the attack angle left the validity range of the aerodynamic curve",
        'give a curve that covers the motion, or set aerodynamics.outside to "hold" or "periodic"',
    )
    SLACK = (
        4,
        (
            "the tension fell below zero: the cable went slack, and a cable element cannot carry"
            " compression"
        ),
        (
            "raise the tension, lower the wind or the load, or let it act more gradually; "
            'conductor.slack = "tension_only" lets the full model go slack'
        ),
    )
    EQUILIBRIUM_NOT_FOUND = (
        5,
        "no static equilibrium was found, although the load was applied in steps",
        (
            "check sag, tension, wind and support displacement; there may be none (twist"
            " divergence, or ice above the conductor that rolls it over: ice.first_moment_x2 g L^2"
            " > pi^2 GJ)"
        ),
    )
    INVALID_SCENE = (6, "a number of the scene is impossible", "check the scene's values")
    OUT_OF_MEMORY = (7, "there is not enough memory for the model", "use fewer elements")
    BAD_CALL = (
        8,
        "the call is not allowed",
        "correct the argument; times must be finite and increase, and a state belongs to one model",
    )
    STOPPED_BY_USER = (100, "the run was stopped on request", "")

    def __init__(self, code: int, sentence: str, cure: str) -> None:
        self.code = code
        self.sentence = sentence
        self.cure = cure

    @classmethod
    def from_code(cls, code: int) -> Outcome:
        """Return the member with the kernel's code.

        Raises
        ------
        ValueError
            If there is none.
        """
        for member in cls:
            if member.code == code:
                return member
        raise ValueError(f"there is no outcome with the code {code!r}")


DOUBTFUL_SHARE = 0.01
"""Divisions over steps above which a completed run is doubtful."""

DOUBTFUL_TURN = 1.0
"""Turn of a section within one step [rad] above which a completed run is doubtful: ice and wind turn with it."""


@dataclass(frozen=True, slots=True)
class Report:
    """What the kernel says about a calculation.

    Attributes
    ----------
    outcome
        How it ended.
    time
        Time [s] reached, or of the failure.
    element
        0-based element of the failure, None where it has no place.
    value, limit
        The offending value and what is allowed; their meaning follows from the outcome. An attack
        angle is given within the turn centred on the curve's range: below the limit, the lower end
        was left.
    field
        Which number of an invalid scene, or which argument of a call that is not allowed.
    lowest_tension
        Lowest tension [N] at any Gauss point since the start.
    largest_turn
        Largest turn [rad] of a section about the span within one step since the start; under a
        tolerance, which looks after it, 0.
    steps, substeps, iterations, refactorisations, halvings, rejections
        Work done since the start.
    """

    outcome: Outcome
    time: float
    element: int | None = None
    value: float = math.nan
    limit: float = math.nan
    field: str | None = None
    lowest_tension: float = math.nan
    largest_turn: float = 0.0
    steps: int = 0
    substeps: int = 0
    iterations: int = 0
    refactorisations: int = 0
    halvings: int = 0
    rejections: int = 0

    @property
    def doubtful(self) -> bool:
        """Whether steps were so long for the motion that its energy need not be right.

        That is where many of them had to be halved, or a section turned far within one of them. A
        cheap sign: of ten thousand random runs none without it was out of balance by more than a
        few per cent of its energy (docs/reference/stability.md). It counts the share of steps that were
        halved, whatever their length. Steps that are just short enough to converge leave it silent
        about axial waves that they do not resolve;
        `gallop_fmu.simulation.energy_balance.energy_balance` is the sure test.
        """
        return self._often_halved or self._turned_far

    @property
    def _often_halved(self) -> bool:
        return self.halvings > DOUBTFUL_SHARE * self.steps

    @property
    def _turned_far(self) -> bool:
        return self.largest_turn > DOUBTFUL_TURN

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences on what limits the trust in the numbers: each states a fact, then the remedy."""
        signs = []
        if self._often_halved:
            signs.append(f"{self.steps} steps were halved {self.halvings} times")
        if self._turned_far:
            signs.append(
                f"the section turned by {math.degrees(self.largest_turn):.0f} deg within one step"
            )
        if not signs:
            return ()
        return (
            (
                "The time step is too long for this motion, whose energy may be wrong:"
                f" {' and '.join(signs)}. Reduce numerics.time_step."
            ),
        )

    def __str__(self) -> str:
        if self.outcome is Outcome.COMPLETED:
            return f"completed at {self.time:g} s"
        place = (
            ""
            if self.element is None
            else f" in element {self.element + 1} (counted from the left)"
        )
        cure = f" What to do: {self.outcome.cure}." if self.outcome.cure else ""
        return f"At {self.time:.6g} s{place} {self.outcome.sentence}{self._detail}.{cure}"

    @property
    def _detail(self) -> str:
        """The numbers of a failure; `detail_of` in kernel/cosim_message.c writes the same."""
        field = "" if self.field is None else f": {self.field}"
        if self.outcome is Outcome.ANGLE_OUT_OF_RANGE:
            value, limit = math.degrees(self.value), math.degrees(self.limit)
            end = "below the curve's lower" if value < limit else "above the curve's upper"
            return f": {value:.6g} deg, {abs(value - limit):.2g} deg {end} limit of {limit:.6g} deg"
        if self.outcome is Outcome.SLACK:
            return f": {self.value:.4g} N"
        if self.outcome is Outcome.STOPPED_BY_USER or (
            self.field is None and not math.isfinite(self.value)
        ):
            return ""
        given = {"value": self.value, "limit": self.limit}
        numbers = ", ".join(
            f"{name} {number:.4g}" for name, number in given.items() if not math.isnan(number)
        )
        return field + (f" ({numbers})" if numbers else "")


class SimulationError(RuntimeError):
    """A calculation that ended early; ``report`` says how, ``result`` holds what was computed up to then."""

    def __init__(self, report: Report, result: object = None) -> None:
        super().__init__(str(report))
        self.report = report
        self.result = result

    def __reduce__(self) -> tuple[type[SimulationError], tuple[Report, object]]:
        return type(self), (self.report, self.result)
