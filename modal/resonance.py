"""How near a span is to the 2:1 internal resonance that lets vertical galloping drive a horizontal swing."""

from __future__ import annotations

from dataclasses import dataclass

from gallop_fmu import Scene, SceneError
from modal.modes import Family, Mode, natural_modes

SEARCHED = 24
"""Modes among which the first symmetric ones are looked for; between rigid ends at most five lie below them, and more
only where the conductor is very soft in torsion."""

CLEAR_SHARE = 0.6
"""Part of the kinetic energy above which a mode belongs to its family beyond doubt."""


@dataclass(frozen=True)
class FrequencyRatio:
    """First symmetric vertical and horizontal frequency [Hz], their ratio, and how far that is from 2."""

    vertical_hz: float
    horizontal_hz: float

    @property
    def ratio(self) -> float:
        """Vertical over horizontal frequency; 2 is the internal resonance of Liu et al. (2009)."""
        return self.vertical_hz / self.horizontal_hz

    @property
    def detuning(self) -> float:
        """Relative distance from the resonance: ratio / 2 - 1, positive where the vertical mode is too fast."""
        return self.ratio / 2.0 - 1.0


def frequency_ratio(scene: Scene) -> FrequencyRatio:
    """Ratio of the first symmetric vertical to the first symmetric horizontal natural frequency.

    A ratio near 2 lets vertical galloping feed a horizontal swing of half its frequency once its amplitude passes a
    threshold (Liu, Yan, Zhang, Zhou 2009, Example 3).

    Raises
    ------
    SceneError
        If one of the two modes cannot be told among the lowest ones.
    SimulationError
        If no initial equilibrium exists.
    """
    unknowns = 4 * (2 * scene.numerics.elements - 1)  # at least so many: the ends are rigid or held by springs
    modes = natural_modes(scene, min(SEARCHED, unknowns))
    return FrequencyRatio(
        vertical_hz=_first_symmetric(modes, "vertical").frequency_hz,
        horizontal_hz=_first_symmetric(modes, "horizontal").frequency_hz,
    )


def _first_symmetric(modes: list[Mode], family: Family) -> Mode:
    found = [mode for mode in modes if mode.family == family and mode.symmetric]
    if not found:
        raise SceneError(
            f"no symmetric {family} mode among the lowest {len(modes)}, up to {modes[-1].frequency_hz:.4g} Hz; look at "
            "natural_modes(scene, count=...) with a larger count"
        )
    first = found[0]
    if first.shares[family] < CLEAR_SHARE:
        shares = ", ".join(f"{name} {share:.0%}" for name, share in first.shares.items())
        raise SceneError(
            f"the first symmetric {family} mode at {first.frequency_hz:.4g} Hz is a mixture ({shares}), so the "
            "frequency ratio means nothing; the eccentric ice or the supports couple the families, see "
            "natural_modes(scene)"
        )
    return first
