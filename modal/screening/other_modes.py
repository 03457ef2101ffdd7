"""Galloping of the modes beside the first symmetric vertical one, which the search for a 2:1 swing does not follow."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import SceneError
from modal.linear.mode_basis import mirrored
from modal.linear.mode_tracking import ALIKE
from modal.linear.modes import FAMILIES, Family, by_family, half_waves
from modal.screening.reduced_model import MeanState, ReducedModel, lopsided_model, mean_state

Array = NDArray[np.float64]

WINDS = 24
"""Wind speeds up to the highest at which the modes are examined before the lowest onset is narrowed down."""

HALVINGS = 20
"""Halvings of the interval that holds the lowest onset."""

FOLLOWED = 3
"""Times that a step is halved to follow the first vertical mode past another."""

NUMBERS = ("no", "one", "two", "three", "four", "five", "six")


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
        number = NUMBERS[self.loops] if self.loops < len(NUMBERS) else str(self.loops)
        loops = f"{number} loop{'' if self.loops == 1 else 's'}"
        what = f"{loops} gallop{'s' if self.loops == 1 else ''}"
        if self.family != "vertical":
            what = f"a {self.family} mode of {loops} grows"
        return f"{what} from {self.wind_speed:.3g} m/s"


def first_other_mode(model: ReducedModel, highest: float) -> OtherMode | None:
    """The mode that grows at the lowest wind, the first symmetric vertical one apart; None if there is none.

    Linear theory in the reduced coordinates: the lowest modes of each family and both symmetries
    about the equilibrium in each wind. Winds in which the span has no stable equilibrium end the
    search.

    Parameters
    ----------
    model
        The reduced span.
    highest
        Highest wind speed [m/s] looked at.
    """
    wide = lopsided_model(model) if mirrored(model.scene) else model
    low, before = 0.0, _modes(model, wide, 0.0)
    for high in (highest * np.arange(1, WINDS + 1) / WINDS).tolist():
        try:
            found = _followed(model, wide, before, low, high)
        except SceneError:
            return None
        if found.growth() > 0.0:
            break
        low, before = high, found
    else:
        return None
    for _ in range(HALVINGS):
        middle = 0.5 * (low + high)
        try:
            between = _followed(model, wide, before, low, middle)
        except SceneError:
            break
        if between.growth() > 0.0:
            high, found = middle, between
        else:
            low, before = middle, between
    best = found.fastest_other()
    wave, family = _wave(wide, found.vectors[:, best])
    return OtherMode(
        family, half_waves(wave), high, abs(float(found.rates[best].imag)) / (2.0 * np.pi)
    )


@dataclass(frozen=True)
class _Modes:
    """The oscillating modes in one wind: eigenvalues [1/s], vectors in columns, and the place of the first vertical."""

    rates: NDArray[np.complex128]
    vectors: NDArray[np.complex128]
    mass: Array
    own: int

    def fastest_other(self) -> int:
        """Place of the mode that grows fastest beside the first vertical one."""
        growth = self.rates.real.copy()
        growth[self.own] = -np.inf
        return int(np.argmax(growth))

    def growth(self) -> float:
        """Its rate of growth [1/s]."""
        return float(self.rates[self.fastest_other()].real)

    def likeness(self, other: _Modes) -> Array:
        """Modal assurance criterion of the first vertical mode here with every mode there."""
        here, there = self.vectors[:, self.own], other.vectors
        weighed = other.mass @ there
        sizes = (
            np.vdot(here, other.mass @ here).real
            * np.einsum("im,im->m", there.conj(), weighed).real
        )
        return np.asarray(np.abs(here.conj() @ weighed) ** 2 / sizes)


def _modes(model: ReducedModel, wide: ReducedModel, wind: float) -> _Modes:
    state: MeanState = mean_state(model, wind)
    n = wide.size
    q = np.zeros((1, n))
    q[0, : model.size] = state.displacement
    forces = wide.forces(q, np.zeros_like(q), np.zeros_like(q), wind)
    mass, damping, stiffness = forces.mass[0], forces.damping[0], forces.stiffness[0]
    lower = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
    rates, vectors = np.linalg.eig(np.vstack([np.eye(n, 2 * n, n), lower]))
    kept = rates.imag > 0.0
    return _Modes(
        rates[kept], vectors[:n, kept], mass, int(np.argmin(np.abs(rates[kept] - state.vertical)))
    )


def _followed(
    model: ReducedModel,
    wide: ReducedModel,
    before: _Modes,
    low: float,
    high: float,
    halvings: int = FOLLOWED,
) -> _Modes:
    """The modes in a wind, with the first vertical one followed from a lower wind: its shape becomes another's."""
    found = _modes(model, wide, high)
    likeness = before.likeness(found)
    if likeness.max() < ALIKE and halvings > 0:
        middle = 0.5 * (low + high)
        between = _followed(model, wide, before, low, middle, halvings - 1)
        return _followed(model, wide, between, middle, high, halvings - 1)
    return replace(found, own=int(np.argmax(likeness)))


def _wave(wide: ReducedModel, vector: NDArray[np.complex128]) -> tuple[Array, Family]:
    """Displacement along the span, in the family that moves most, at the instant at which it moves most."""
    shape = by_family(wide.scene, np.einsum("m,mni->ni", vector, wide.shapes))
    inertia = wide.scene.conductor.torsional_inertia + wide.scene.ice.torsional_inertia
    mass = wide.scene.conductor.mass_per_length + wide.scene.ice.mass_per_length
    energy = np.sum(np.abs(shape) ** 2, axis=0) * np.array([mass, mass, mass, inertia])
    dominant = int(np.argmax(energy))
    wave = shape[:, dominant]
    phase = np.exp(-0.5j * np.angle(np.sum(wave**2)))
    return (wave * phase).real, FAMILIES[dominant]
