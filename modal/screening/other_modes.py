"""Galloping of modes other than the first symmetric vertical one, which the screening follows."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import SceneError
from modal.linear.mode_basis import mirrored
from modal.linear.mode_tracking import MIN_MAC
from modal.linear.modes import FAMILIES, Family, by_family
from modal.linear.wave import half_waves
from modal.motions.motion_words import NUMBER_WORDS
from modal.motions.reduced_model import (
    MeanState,
    ReducedModel,
    mean_state,
    with_antisymmetric_modes,
)

Array = NDArray[np.float64]

WIND_POINTS = 24
"""Wind speeds up to the highest at which the modes are examined before the onset is bisected."""

BISECTIONS = 20
"""Halvings of the interval that contains the lowest onset."""

TRACKING_HALVINGS = 3
"""Largest number of halvings of a wind step while the first vertical mode is tracked."""


@dataclass(frozen=True)
class OtherMode:
    """A mode that grows in the wind.

    Attributes
    ----------
    family : str
        As in `modal.Mode`.
    loops : int
        Half-waves along the span.
    wind_speed : float
        Lowest wind speed [m/s] at which it grows.
    frequency_hz : float
        Its frequency [Hz] there.
    """

    family: Family
    loops: int
    wind_speed: float
    frequency_hz: float

    def __str__(self) -> str:
        known = self.loops < len(NUMBER_WORDS)
        number = NUMBER_WORDS[self.loops] if known else str(self.loops)
        loops = f"{number} loop{'' if self.loops == 1 else 's'}"
        what = f"{loops} gallop{'s' if self.loops == 1 else ''}"
        if self.family != "vertical":
            what = f"a {self.family} mode of {loops} grows"
        return f"{what} from {self.wind_speed:.3g} m/s"


def first_other_mode(model: ReducedModel, highest: float) -> OtherMode | None:
    """Find the mode that grows at the lowest wind, except the first symmetric vertical mode.

    Linear theory about the equilibrium in each wind, in the coordinates of the reduced model: the
    lowest modes of each family, symmetric and antisymmetric. The search ends at a wind speed
    without a stable equilibrium.

    Parameters
    ----------
    model
        The reduced span.
    highest
        Highest wind speed [m/s] of the search.

    Returns
    -------
    OtherMode or None
        None if no other mode grows.
    """
    wide = with_antisymmetric_modes(model) if mirrored(model.scene) else model
    low, before = 0.0, _modes(model, wide, 0.0)
    for high in (highest * np.arange(1, WIND_POINTS + 1) / WIND_POINTS).tolist():
        try:
            found = _tracked(model, wide, before, low, high)
        except SceneError:
            return None
        if found.growth() > 0.0:
            break
        low, before = high, found
    else:
        return None
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        try:
            between = _tracked(model, wide, before, low, middle)
        except SceneError:
            break
        if between.growth() > 0.0:
            high, found = middle, between
        else:
            low, before = middle, between
    number = found.fastest_other()
    wave, family = _wave(wide, found.vectors[:, number])
    frequency = abs(float(found.rates[number].imag)) / (2.0 * np.pi)
    return OtherMode(family, half_waves(wave), high, frequency)


@dataclass(frozen=True)
class _Modes:
    """Oscillating modes in one wind.

    Attributes
    ----------
    rates : ndarray, shape (mode,)
        Eigenvalues [1/s].
    vectors : ndarray, shape (coordinate, mode)
        Eigenvectors.
    mass : ndarray, shape (coordinate, coordinate)
        Mass matrix.
    first_vertical : int
        Number of the first symmetric vertical mode.
    """

    rates: NDArray[np.complex128]
    vectors: NDArray[np.complex128]
    mass: Array
    first_vertical: int

    def fastest_other(self) -> int:
        """Number of the fastest-growing mode except the first vertical one."""
        growth = self.rates.real.copy()
        growth[self.first_vertical] = -np.inf
        return int(np.argmax(growth))

    def growth(self) -> float:
        """Growth rate [1/s] of that mode."""
        return float(self.rates[self.fastest_other()].real)

    def likeness(self, other: _Modes) -> Array:
        """Modal assurance criterion of the first vertical mode with every mode of `other`."""
        vector, vectors = self.vectors[:, self.first_vertical], other.vectors
        weighted = other.mass @ vectors
        norm = np.vdot(vector, other.mass @ vector).real
        norms = norm * np.einsum("im,im->m", vectors.conj(), weighted).real
        return np.asarray(np.abs(vector.conj() @ weighted) ** 2 / norms)


def _modes(model: ReducedModel, wide: ReducedModel, wind: float) -> _Modes:
    """Modes about the equilibrium of `model` in a wind [m/s], in the coordinates of `wide`."""
    state: MeanState = mean_state(model, wind)
    n = wide.size
    q = np.zeros((1, n))
    q[0, : model.size] = state.displacement
    forces = wide.forces(q, np.zeros_like(q), np.zeros_like(q), wind)
    mass, damping, stiffness = forces.mass[0], forces.damping[0], forces.stiffness[0]
    lower = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
    rates, vectors = np.linalg.eig(np.vstack([np.eye(n, 2 * n, n), lower]))
    kept = rates.imag > 0.0
    nearest = int(np.argmin(np.abs(rates[kept] - state.vertical)))
    return _Modes(rates[kept], vectors[:n, kept], mass, nearest)


def _tracked(
    model: ReducedModel,
    wide: ReducedModel,
    before: _Modes,
    low: float,
    high: float,
    halvings: int = TRACKING_HALVINGS,
) -> _Modes:
    """Modes in a wind, with the first vertical one tracked by its shape from a lower wind."""
    found = _modes(model, wide, high)
    likeness = before.likeness(found)
    if likeness.max() < MIN_MAC and halvings > 0:
        middle = 0.5 * (low + high)
        between = _tracked(model, wide, before, low, middle, halvings - 1)
        return _tracked(model, wide, between, middle, high, halvings - 1)
    return replace(found, first_vertical=int(np.argmax(likeness)))


def _wave(wide: ReducedModel, vector: NDArray[np.complex128]) -> tuple[Array, Family]:
    """Displacement along the span in the dominant family, at the phase of its largest motion."""
    shape = by_family(wide.scene, np.einsum("m,mni->ni", vector, wide.shapes))
    inertia = wide.scene.conductor.torsional_inertia + wide.scene.ice.torsional_inertia
    mass = wide.scene.conductor.mass_per_length + wide.scene.ice.mass_per_length
    energy = np.sum(np.abs(shape) ** 2, axis=0) * np.array([mass, mass, mass, inertia])
    dominant = int(np.argmax(energy))
    wave = shape[:, dominant]
    phase = np.exp(-0.5j * np.angle(np.sum(wave**2)))
    return (wave * phase).real, FAMILIES[dominant]
