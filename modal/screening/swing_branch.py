"""Onset of the swing on the branch of limit cycles, and the motions with swing that start there."""

from __future__ import annotations

import numpy as np

from modal.linear.mode_basis import mirrored
from modal.motions.reduced_model import ReducedModel
from modal.screening.continuation import FIRST_SIZE, LimitCycles, amplitude_scale, rejection_reason
from modal.screening.floquet import (
    antisymmetric_multiplier,
    flip_determinant,
    flip_shape,
    multipliers,
)
from modal.screening.harmonic_balance import SWING, NotConvergedError, Orbit, doubled
from modal.screening.orbit_family import Track

ONSET_TOLERANCE = 1e-3
"""Accuracy of a stability limit, relative to the distance of two orbits."""

LOW_WIND_RATIO, HIGH_WIND_RATIO = 0.7, 1.1
"""Wind speeds at which the branch with swing ends, relative to its onset and the scene's wind."""


def stability_limits(branch: LimitCycles) -> list[tuple[Orbit, bool]]:
    """Orbits at which the swing starts (True) or no longer starts (False), along the branch.

    Orbits above the highest wind speed do not count, nor changes next to a rejected orbit.
    """
    is_unstable = [abs(one.swing) > 1.0 for one in branch.growth]
    is_rejected = [bool(rejection_reason(one)) for one in branch.growth]
    found = [
        (_stability_limit(branch, branch.orbits[k], branch.orbits[k + 1]), is_unstable[k + 1])
        for k in range(len(branch.orbits) - 1)
        if is_unstable[k] != is_unstable[k + 1] and not (is_rejected[k] or is_rejected[k + 1])
    ]
    return [(orbit, starts) for orbit, starts in found if orbit.wind_speed <= branch.highest]


def _stability_limit(branch: LimitCycles, low: Orbit, high: Orbit) -> Orbit:
    """Orbit between two neighbours at which a small swing neither grows nor decays.

    Where Hill's determinant changes its sign, its zero is sought, which is smooth; otherwise the
    multiplier 1 of the swing.
    """
    from scipy.optimize import brentq  # slow to import

    (sign_low, size), (sign_high, _) = (flip_determinant(branch.model, one) for one in (low, high))
    changes_sign = sign_low != sign_high
    a, b = low.packed(), high.packed()

    def level(part: float) -> float:
        orbit = branch.track.between(a, b, part) if 0.0 < part < 1.0 else (low, high)[int(part)]
        if not changes_sign:
            return abs(multipliers(branch.model, orbit).swing) - 1.0
        sign, logarithm = flip_determinant(branch.model, orbit)
        return sign * float(np.exp(logarithm - size))

    return branch.track.between(a, b, float(brentq(level, 0.0, 1.0, xtol=ONSET_TOLERANCE)))


def swing_branch(model: ReducedModel, onset: Orbit, wind: float) -> tuple[list[Orbit], Track]:
    """Follow the motions with swing from their onset to a wind speed [m/s].

    They have twice the period of the limit cycle without swing, and start in the direction of the
    disturbance whose multiplier is -1 there.

    Returns
    -------
    list of Orbit, Track
        Orbits in the order of continuation (none if Newton's method fails), and their family.
    """
    scale = amplitude_scale(model, model.horizontal, 2, wind)
    track = Track(model, SWING, model.horizontal, wind, scale)
    shape, phase = flip_shape(model, onset)
    base = doubled(onset, SWING.harmonics).shifted(phase)
    size = FIRST_SIZE * scale
    start = Orbit(base.wind_speed, base.omega, base.coefficients + size * shape)
    try:
        first, matrix, _ = track.of_size(start.packed(), size)
    except NotConvergedError:
        return [], track
    low = LOW_WIND_RATIO * min(wind, onset.wind_speed)
    high = max(wind, HIGH_WIND_RATIO * onset.wind_speed)

    def stop(orbit: Orbit) -> bool:
        return not low < orbit.wind_speed < high or track.size(orbit) <= 0.0

    return list(track.follow(first, matrix, track.growing, stop)), track


def antisymmetric_growth(model: ReducedModel, orbit: Orbit, cycles: int) -> float | None:
    """Growth of an antisymmetric disturbance in one vertical cycle.

    None for a span without mirror symmetry. `cycles` is the number of vertical cycles in the orbit.
    """
    if not mirrored(model.scene):
        return None
    return float(antisymmetric_multiplier(model, orbit, cycles) ** (1.0 / cycles))
