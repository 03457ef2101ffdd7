"""Outcomes of a calculation, each with a sentence and a remedy."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

from gallop_fmu.foundation.deprecation import warn_renamed


class Outcome(Enum):
    """Outcome of a calculation, with the codes of the kernel's ``gallop_outcome``.

    ``outcome.sentence`` states the fact, ``outcome.cure`` the remedy.
    """

    COMPLETED = (0, "the calculation was completed", "")
    NEWTON_STALLED = (
        1,
        (
            "the Newton iteration did not converge, even after the time step was halved as often as"
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
            "raise the tension, or lower the wind or load, or apply it more gradually; "
            'conductor.slack = "tension_only" allows a slack cable'
        ),
    )
    EQUILIBRIUM_NOT_FOUND = (
        5,
        "no static equilibrium was found, although the load was applied in steps",
        (
            "check sag, tension, wind and support displacement; an equilibrium may not exist (twist"
            " divergence, or ice above the conductor that rotates it: ice.first_moment_x2 g L^2 >"
            " pi^2 GJ)"
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
            No member has this code.
        """
        for member in cls:
            if member.code == code:
                return member
        raise ValueError(f"there is no outcome with the code {code!r}")


MAX_HALVED_SHARE = 0.01
"""Number of halvings over number of steps above which the time step is too long."""

MAX_STEP_ROTATION = 1.0
"""Rotation of a section [rad] within one step above which the time step is too long."""


@dataclass(frozen=True, slots=True)
class Report:
    """Report of the kernel on a calculation.

    Attributes
    ----------
    outcome
        Outcome of the calculation.
    time
        Time [s] reached, or of the failure.
    element
        0-based element of the failure; None if it concerns no single element.
    value, limit
        The value that caused the failure and its limit; their meaning depends on the outcome. An
        attack angle is given within the turn centred on the curve's range: below the limit, the
        lower end was exceeded.
    field
        Name of the number of an invalid scene, of the argument of an invalid call, or of the
        quantity of the device.
    lowest_tension
        Lowest tension [N] at any Gauss point since the start.
    largest_turn
        Largest rotation [rad] of a section about the span within one step since the start; 0 with a
        tolerance, which limits it.
    steps, substeps, iterations, refactorisations, halvings, rejections
        Counts since the start.
    device
        0-based device of the kernel that has no equilibrium; None if it concerns no single device.
    place
        Place of the failure in a line, in words.
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
    device: int | None = None
    place: str | None = None

    @property
    def step_too_long(self) -> bool:
        """True if the time step is too long for the motion, so that its energy may be wrong.

        Many steps were halved, or a section rotated by a large angle within one step. This
        indicator is cheap: of ten thousand random runs without it, none had an energy imbalance of
        more than a few per cent (docs/reference/stability.md). It does not detect axial waves that
        the steps do not resolve but that still converge;
        `gallop_fmu.simulation.energy_balance.energy_balance` does.
        """
        return self._has_many_halvings or self._has_large_rotation

    @property
    def doubtful(self) -> bool:
        """Former name of `step_too_long`; to be removed in the next release."""
        warn_renamed("Report.doubtful", "Report.step_too_long")
        return self.step_too_long

    @property
    def _has_many_halvings(self) -> bool:
        return self.halvings > MAX_HALVED_SHARE * self.steps

    @property
    def _has_large_rotation(self) -> bool:
        return self.largest_turn > MAX_STEP_ROTATION

    @property
    def warnings(self) -> tuple[str, ...]:
        """Warnings that limit the trust in the results, each a fact and a remedy."""
        signs = []
        if self._has_many_halvings:
            signs.append(f"{self.steps} steps were halved {self.halvings} times")
        if self._has_large_rotation:
            signs.append(
                f"a section rotated by {math.degrees(self.largest_turn):.0f} deg within one step"
            )
        if not signs:
            return ()
        return (
            "The time step is too long for this motion, whose energy may be wrong:"
            f" {' and '.join(signs)}. Reduce numerics.time_step.",
        )

    def __str__(self) -> str:
        if self.outcome is Outcome.COMPLETED:
            return f"completed at {self.time:g} s"
        place = "" if self.place is None else f" {self.place}"
        if self.place is None and self.element is not None:
            place = f" in element {self.element + 1} (counted from the left)"
        cure = f" What to do: {self.outcome.cure}." if self.outcome.cure else ""
        return f"At {self.time:.6g} s{place} {self.outcome.sentence}{self._detail}.{cure}"

    @property
    def _detail(self) -> str:
        """Numbers of a failure; `detail_of` in kernel/cosim_message.c writes the same text."""
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
    """A calculation that ended early; ``report`` has the reason, ``result`` what was computed."""

    def __init__(self, report: Report, result: object = None) -> None:
        super().__init__(str(report))
        self.report = report
        self.result = result

    def __reduce__(self) -> tuple[type[SimulationError], tuple[Report, object]]:
        return type(self), (self.report, self.result)
