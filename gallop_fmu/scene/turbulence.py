"""Turbulence of the wind: the values that describe it, and its spectra.

Spectra S(f) are one-sided: their integral over the frequency f is the variance. With n = f L/U and
the integral length scale L of a component along the wind, S(0) = 4 L/U times the variance.

- von Karman (Simiu and Scanlan, Wind Effects on Structures; ESDU 85020): along the wind
  f S = 4 n/(1 + 70.8 n^2)^(5/6), across and upwards 4 n (1 + 755.2 n^2)/(1 + 283.2 n^2)^(11/6);
- Kaimal (IEC 61400-1): f S = 4 n/(1 + 6 n)^(5/3) for each component. With L = 1.7 L(z) it is that
  of EN 1991-1-4, B.1.
"""

from __future__ import annotations

from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from pydantic import model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.fields import Number, Section, WholeNumber, quantity, setting

Values = NDArray[np.float64]
Spectrum = Literal["von_karman", "kaimal"]

DIRECTIONS = ("along", "across", "upwards")
"""Components of the turbulence: along the wind, horizontally across it, upwards."""


class Component(NamedTuple):
    """One component of the turbulence.

    Attributes
    ----------
    direction : str
        One of `DIRECTIONS`.
    intensity : float
        Standard deviation over mean speed.
    length_scale : float
        Integral length scale along the wind [m].
    """

    direction: str
    intensity: float
    length_scale: float


class Turbulence(Section):
    """Gusts relative to the mean speed: stationary, Gaussian, with a spectrum and a coherence."""

    spectrum: Spectrum = setting(..., "spectrum of each component")
    intensity: Number = quantity(
        ..., "1", "standard deviation of the speed along the wind over the mean speed", ge=0, le=1
    )
    intensity_across: Number = quantity(
        0.0,
        "1",
        "the same, horizontally across the wind; typical are 0.75 to 0.9 of intensity",
        ge=0,
        le=1,
    )
    intensity_upwards: Number = quantity(
        0.0, "1", "the same, upwards; typical is half of intensity", ge=0, le=1
    )
    length_scale: Number = quantity(
        ...,
        "m",
        "integral length scale along the wind of the speed along it; typical are 50 to 150 m at"
        " 10 to 30 m height",
        gt=0,
        le=1e4,
    )
    length_scale_across: Number | None = quantity(
        None,
        "m",
        "the same, of the speed across; typical is a quarter to a half of length_scale",
        gt=0,
        le=1e4,
    )
    length_scale_upwards: Number | None = quantity(
        None,
        "m",
        "the same, of the upward speed; typical is a tenth to a half of length_scale",
        gt=0,
        le=1e4,
    )
    decay: Number = quantity(
        10.0, "1", "C of the coherence exp(-C f d/U) at a distance d across the wind", gt=0, le=100
    )
    seed: WholeNumber = quantity(1, "1", "number that selects the realisation", ge=0, le=2**31 - 1)
    time_step: Number = quantity(
        0.1, "s", "time between gusts; they are linear between", gt=0, le=60
    )
    spacing: Number | None = quantity(
        None,
        "m",
        "distance of gusts along the line; they are linear between (default: the coherent length"
        " 2 U/(C f) at 1 Hz)",
        gt=0,
    )
    duration: Number | None = quantity(
        None, "s", "duration of the gusts, after which they repeat (default: run.stop_time)", gt=0
    )

    @model_validator(mode="after")
    def _length_of_each_component(self) -> Turbulence:
        for name, typical in (("across", "a quarter to a half"), ("upwards", "a tenth to a half")):
            if getattr(self, f"intensity_{name}") and getattr(self, f"length_scale_{name}") is None:
                raise SceneError(
                    f"length_scale_{name}: missing, but intensity_{name} ="
                    f" {getattr(self, f'intensity_{name}'):g}; give it in m (typical is {typical}"
                    f" of length_scale = {self.length_scale:g} m), or intensity_{name} = 0"
                )
        return self

    @property
    def components(self) -> tuple[Component, ...]:
        """The component along the wind, or all three if the others have an intensity."""
        along = Component("along", self.intensity, self.length_scale)
        if not (self.intensity_across or self.intensity_upwards):
            return (along,)
        across, upwards = self.length_scale_across, self.length_scale_upwards
        return (
            along,
            Component("across", self.intensity_across, across or self.length_scale),
            Component("upwards", self.intensity_upwards, upwards or self.length_scale),
        )

    @property
    def is_calm(self) -> bool:
        """True if all intensities are 0."""
        return not any(component.intensity for component in self.components)

    def spectral_density(
        self, component: Component, frequency_hz: ArrayLike, mean_speed: float
    ) -> Values:
        """Spectral density [1/Hz] of a relative gust; one-sided, its integral is intensity^2."""
        scale = component.length_scale / abs(mean_speed)
        n = np.asarray(frequency_hz, dtype=np.float64) * scale
        if self.spectrum == "kaimal":
            shape = 4.0 / (1.0 + 6.0 * n) ** (5.0 / 3.0)
        elif component.direction == "along":
            shape = 4.0 / (1.0 + 70.8 * n**2) ** (5.0 / 6.0)
        else:
            shape = 4.0 * (1.0 + 755.2 * n**2) / (1.0 + 283.2 * n**2) ** (11.0 / 6.0)
        return np.asarray(component.intensity**2 * scale * shape)
