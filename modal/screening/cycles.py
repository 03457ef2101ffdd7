"""Results of a screening: motions over the wind, states at the scene's wind, growth from one."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

StateKind = Literal["rest", "periodic", "beating", "not settled"]


@dataclass(frozen=True)
class Cycle:
    """A periodic motion of the span; amplitudes are half peak-to-peak at mid-span.

    Attributes
    ----------
    wind_speed : float
        Wind speed [m/s].
    vertical, horizontal, twist : float
        Amplitudes [m], [m], [rad].
    frequency_hz : float
        Frequency of the vertical motion [Hz].
    multiplier : float
        Factor by which a small swing grows (above 1) or decays in one vertical cycle. For a motion
        with swing: the factor of the disturbance that decays slowest.
    """

    wind_speed: float
    vertical: float
    horizontal: float
    twist: float
    frequency_hz: float
    multiplier: float


@dataclass(frozen=True)
class StableState:
    """A stable state of the span in the scene's wind: equilibrium or motion.

    Attributes
    ----------
    name : str
        The state in words, such as "one loop with swing at half frequency" or "rest, turned over".
    kind : {"rest", "periodic", "beating", "not settled"}
        ``"beating"``: the amplitudes vary, of two frequencies or irregularly. ``"not settled"``:
        they still changed at the end of the simulation.
    vertical, horizontal, twist : float
        Largest amplitudes (half peak-to-peak) [m], [m], [rad] at mid-span.
    quarter : float
        Amplitude [m] of the antisymmetric vertical motion at the quarter points.
    mean_twist : float
        Mean twist [rad] at mid-span.
    frequency_hz : float or None
        Frequency [Hz] of the vertical motion.
    has_swing : bool
        True if the span swings at half the vertical frequency.
    is_simulated : bool
        True if the amplitudes are those of a simulation with the full model.
    separation : float or None
        Difference [m] of amplitudes to the nearest unstable motion from which the span can leave
        this state: the size of the disturbance that ends it. None if there is no such motion.
    growth_rate : float or None
        Growth rate [1/s] of the disturbance that decays slowest; None if simulated.
    """

    name: str
    kind: StateKind
    vertical: float
    horizontal: float
    twist: float
    quarter: float
    mean_twist: float
    frequency_hz: float | None
    has_swing: bool
    is_simulated: bool
    separation: float | None = None
    growth_rate: float | None = None

    @property
    def is_turned_over(self) -> bool:
        """True if the ice, or a bundle, has turned by more than 90 degrees."""
        return self.name.endswith("turned over")

    @property
    def largest(self) -> float:
        """Largest of the displacement amplitudes [m]."""
        return max(self.vertical, self.horizontal, self.quarter)

    def __str__(self) -> str:
        if self.kind == "rest":
            return f"{self.name} (mean twist {math.degrees(self.mean_twist):.0f} deg)"
        sizes = f"{self.vertical:.3g} m vertical and {self.horizontal:.3g} m horizontal"
        if self.quarter > 0.1 * self.largest:
            sizes += f" at mid-span, {self.quarter:.3g} m antisymmetric at the quarter points"
        kind = "" if self.kind == "periodic" else f", {self.kind}"
        return f"{self.name}{kind} ({sizes}{', simulated' if self.is_simulated else ''})"


@dataclass(frozen=True)
class Transfer:
    """Growth of a small disturbance of an unstable motion, or of rest, in the scene's wind.

    Attributes
    ----------
    origin : str
        The unstable state in words.
    disturbance : str
        The disturbance that grows, in words.
    growth_rate : float
        Its growth rate [1/s].
    frequency_hz : float
        Its frequency [Hz].
    """

    origin: str
    disturbance: str
    growth_rate: float
    frequency_hz: float

    def time(self, start: float = 1e-3, visible: float = 0.1) -> float:
        """Time [s] in which the disturbance grows from one amplitude to another.

        It grows exponentially while it is small against the motion that it disturbs.

        Parameters
        ----------
        start
            Amplitude [m] of the growing motion at the start.
        visible
            Amplitude [m] at which it can be seen.

        Raises
        ------
        ValueError
            If an amplitude is not positive.
        """
        if not (start > 0.0 and visible > 0.0):
            raise ValueError(f"start = {start} m, visible = {visible} m: must be positive")
        return max(0.0, math.log(visible / start)) / self.growth_rate
