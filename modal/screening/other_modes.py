"""Oscillations that begin on the equilibrium of a span: which mode, from which wind."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from modal.continuation.events import Event
from modal.linear.modes import FAMILIES, Family, by_family
from modal.linear.wave import half_waves
from modal.motions.motion_words import loops_in_words
from modal.motions.span_model import SpanModel

Array = NDArray[np.float64]

MIN_SHARE = 0.25
"""Least share of the first symmetric vertical mode in the energy of the mode that is called so."""


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
        loops = loops_in_words(self.loops)
        what = f"{loops} gallop{'s' if self.loops == 1 else ''}"
        if self.family != "vertical":
            what = f"a {self.family} mode of {loops} grows"
        return f"{what} from {self.wind_speed:.3g} m/s"


def shape_at(event: Event, model: SpanModel) -> NDArray[np.complex128]:
    """Complex shape (mode,) of the oscillation that begins at a Hopf point, of unit energy."""
    point = event.point
    jacobian = point.equations.problem.rates(point.states, point.parameter).by_state[0]
    values, vectors = np.linalg.eig(jacobian)
    shape = vectors[: model.size, np.argmin(np.abs(values - 1j * abs(event.value.imag)))]
    return np.asarray(shape / np.linalg.norm(shape))


def first_pair(events: Sequence[Event], model: SpanModel) -> Event | None:
    """Hopf point at which the first symmetric vertical mode begins to gallop; None if none is."""
    shares = [float(np.abs(shape_at(event, model)[model.vertical]) ** 2) for event in events]
    best = int(np.argmax(shares)) if shares else 0
    return events[best] if shares and shares[best] > MIN_SHARE else None


def other_mode(event: Event, model: SpanModel) -> OtherMode:
    """Describe the oscillation that begins at a Hopf point."""
    vector = shape_at(event, model)
    displacement = by_family(model.scene, np.einsum("m,mni->ni", vector, model.shapes))
    conductor, ice = model.scene.conductor, model.scene.ice
    mass = conductor.mass_per_length + ice.mass_per_length
    inertia = conductor.torsional_inertia + ice.torsional_inertia
    energy = np.sum(np.abs(displacement) ** 2, axis=0) * np.array([mass, mass, mass, inertia])
    dominant = int(np.argmax(energy))
    wave = displacement[:, dominant]
    phase = np.exp(-0.5j * np.angle(np.sum(wave**2)))
    frequency = abs(event.value.imag) / (2.0 * np.pi)
    return OtherMode(
        FAMILIES[dominant], half_waves((wave * phase).real), event.parameter, frequency
    )
