"""Comparison of nonlinear simulation, mode superposition and linear theory of one span."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Oscillation, Result, Scene, SimulationError, simulate
from gallop_fmu.foundation.deprecation import warn_renamed
from gallop_fmu.scene.line_scene import one_span
from gallop_fmu.simulation.result import frequency_text
from modal.foundation import one_span as instead
from modal.linear.modes import Family
from modal.superposition.modal_model import ModalModel
from modal.superposition.mode_superposition import (
    HORIZONTAL,
    TORSIONAL,
    VERTICAL,
    linear_motion,
    nonlinear_motion,
)

Array = NDArray[np.float64]

CHANNELS = {"u2": "m", "u3": "m", "theta": "rad"}
"""Channels compared at mid-span, and their units."""

LEVELS = (0.05, 0.2)
"""Differences, relative to the running amplitude of the simulation, that count as divergence."""

HEADINGS = "    u2 [m]     [Hz]    u3 [m]     [Hz]  theta [rad]  up to [s]  motion"
"""Headings of the table of amplitudes."""


@dataclass(frozen=True)
class LinearMode:
    """A mode of small motion about the equilibrium in mean wind, by linear theory.

    Attributes
    ----------
    family : str
        Family of the natural modes with the largest share of it.
    frequency_hz : float
        Frequency [Hz]; 0 if it does not oscillate.
    growth_rate : float
        Rate sigma [1/s] of the amplitude exp(sigma t); negative if it decays.
    """

    family: Family
    frequency_hz: float
    growth_rate: float


@dataclass(frozen=True)
class Divergence:
    """Time from which a simpler model differs from the nonlinear one.

    Attributes
    ----------
    model : str
        ``"superposition"`` or ``"linear"``.
    channel : str
        ``"u2"``, ``"u3"`` or ``"theta"`` at mid-span.
    level : float
        Difference, relative to the running amplitude of the simulation.
    history : float or None
        Time [s] at which the two histories first differ by more; a small difference in frequency
        is enough. None if they do not while both models run.
    amplitude : float or None
        Time [s] from which the two running amplitudes differ by more, up to the end of the shorter
        run. None if they do not differ there.
    """

    model: str
    channel: str
    level: float
    history: float | None
    amplitude: float | None


@dataclass(frozen=True)
class Comparison:
    """Three models of one span.

    Attributes
    ----------
    nonlinear : Result
        The simulation.
    superposition : Result
        Linear structure, nonlinear wind load.
    linear : Result
        Linear structure, wind load linearised about the equilibrium in mean wind. An unstable
        model ends when its attack angle leaves the coefficient curve; nothing else limits it.
    linear_modes : tuple of LinearMode
        Modes of the linear model, the fastest-growing first.
    divergences : tuple of Divergence
        One for each simpler model, channel and level.
    """

    nonlinear: Result = field(repr=False)
    superposition: Result = field(repr=False)
    linear: Result = field(repr=False)
    linear_modes: tuple[LinearMode, ...]
    divergences: tuple[Divergence, ...]

    @property
    def models(self) -> dict[str, Result]:
        """The three results by name."""
        return {
            "nonlinear": self.nonlinear,
            "superposition": self.superposition,
            "linear": self.linear,
        }

    def amplitudes(self) -> dict[str, dict[str, Oscillation]]:
        """Oscillation of u2 [m], u3 [m], theta [rad] at mid-span at the end, by model."""
        found = {}
        for name, result in self.models.items():
            motions = result.steady()
            found[name] = {channel: motions[channel] for channel in CHANNELS}
        return found

    def divergence(self, model: str, channel: str, level: float) -> Divergence:
        """Return one of `divergences`."""
        key = (model, channel, level)
        return next(
            found for found in self.divergences if (found.model, found.channel, found.level) == key
        )

    @property
    def partings(self) -> tuple[Divergence, ...]:
        """Deprecated name of `divergences`."""
        warn_renamed("Comparison.partings", "divergences")
        return self.divergences

    def parting(self, model: str, channel: str, level: float) -> Divergence:
        """Deprecated name of `divergence`."""
        warn_renamed("Comparison.parting", "divergence")
        return self.divergence(model, channel, level)

    def as_dict(self) -> dict[str, Any]:
        """Return all results except the histories as numbers and texts, for JSON."""
        return {
            "title": self.nonlinear.scene.title,
            "models": {
                name: {
                    "outcome": self.models[name].outcome.name.lower(),
                    "message": str(self.models[name].report),
                    "warnings": list(self.models[name].warnings),
                    "motion": str(self.models[name].motion),
                    "stop_time": self.models[name].report.time,
                    "midspan": {channel: motion.as_dict() for channel, motion in motions.items()},
                }
                for name, motions in self.amplitudes().items()
            },
            "linear_modes": [asdict(mode) for mode in self.linear_modes],
            "divergences": [asdict(divergence) for divergence in self.divergences],
        }

    def __str__(self) -> str:
        """Table of amplitudes, and the warnings, with their models unless they hold for all."""
        lines = [f"{'':14}{HEADINGS}"]
        for name, motions in self.amplitudes().items():
            u2, u3, theta = (motions[channel] for channel in CHANNELS)
            lines.append(
                f"{name:14}"
                f"{u2.amplitude:10.4f}{frequency_text(u2.frequency_hz):>9}"
                f"{u3.amplitude:10.4f}{frequency_text(u3.frequency_hz):>9}"
                f"{theta.amplitude:13.4f}{self.models[name].report.time:11.1f}"
                f"  {self.models[name].motion}"
            )
        warned: dict[str, list[str]] = {}  # names of the models of each warning
        for name, result in self.models.items():
            for sentence in result.warnings:
                warned.setdefault(sentence, []).append(name)
        for sentence, names in warned.items():
            about = "" if len(names) == len(self.models) else f" ({', '.join(names)})"
            lines.append(f"warning{about}: {sentence}")
        return "\n".join(lines)


def compare(scene: Scene, stop_time: float | None = None) -> Comparison:
    """Run the nonlinear simulation, mode superposition and linear theory on one scene.

    All start from the same state. Mode superposition and linear theory have the same modes; they
    differ by the nonlinear wind load. Mode superposition and simulation differ by the nonlinear
    structure.

    Parameters
    ----------
    scene
        The span; the linear model uses the mean wind speed.
    stop_time
        Simulated time [s]; None takes the scene's.

    Raises
    ------
    SceneError
        If an argument is not allowed, the mesh has too few modes, or a tower moves.
    SimulationError
        If the simulation cannot start. A run that ends early raises nothing; see its outcome.
    """
    scene = one_span(scene, "a comparison", instead.COMPARISON)
    span = ModalModel.of(scene, vertical=VERTICAL, horizontal=HORIZONTAL, torsional=TORSIONAL)
    linear = linear_motion(span, scene.wind.mean_speed, stop_time)
    superposition = nonlinear_motion(span, stop_time)
    nonlinear = simulate(scene, stop_time, on_failure="return")
    if not nonlinear.started:
        raise SimulationError(nonlinear.report, nonlinear)
    slowest = 1.0 / min(mode.frequency_hz for mode in span.modes)
    assert isinstance(superposition, Result)
    assert isinstance(linear, Result)
    divergences = [
        _divergence(nonlinear, other, name, channel, level, slowest)
        for name, other in (("superposition", superposition), ("linear", linear))
        for channel in CHANNELS
        for level in LEVELS
    ]
    return Comparison(nonlinear, superposition, linear, _linear_modes(span), tuple(divergences))


def _linear_modes(span: ModalModel) -> tuple[LinearMode, ...]:
    """Modes of the linear model in the mean wind, the fastest-growing first."""
    values, vectors = np.linalg.eig(span.linear_system(span.scene.wind.mean_speed)[0])
    families = np.array([mode.family for mode in span.modes])
    weight = np.abs(vectors[len(families) :]) ** 2
    found = []
    for k in np.flatnonzero(values.imag >= 0.0):
        parts = {
            family: float(weight[families == family, k].sum())
            for family in dict.fromkeys(families.tolist())
        }
        frequency = float(values[k].imag) / (2.0 * np.pi)
        found.append(
            LinearMode(max(parts, key=parts.__getitem__), frequency, float(values[k].real))
        )
    return tuple(sorted(found, key=lambda mode: -mode.growth_rate))


def _divergence(
    nonlinear: Result, other: Result, model: str, channel: str, level: float, period: float
) -> Divergence:
    """Compare the histories of a channel from the first `period` [s] to the end of the shorter."""
    count = min(nonlinear.dataset.sizes["time"], other.dataset.sizes["time"])
    time = nonlinear.dataset.time.values[:count]
    truth, simple = (result.midspan()[channel].values[:count] for result in (nonlinear, other))
    width = int(np.searchsorted(time, period)) + 1
    amplitude = running_amplitude(truth, width)

    differs = np.abs(simple - truth) > level * amplitude
    size_differs = np.abs(running_amplitude(simple, width) - amplitude) > level * amplitude
    first = np.flatnonzero(differs & (time >= period))
    last_agreement = np.flatnonzero(~size_differs | (time < period))[-1]
    return Divergence(
        model=model,
        channel=channel,
        level=level,
        history=float(time[first[0]]) if len(first) else None,
        amplitude=float(time[last_agreement + 1]) if last_agreement + 1 < count else None,
    )


def running_amplitude(values: Array, width: int) -> Array:
    """Half peak-to-peak over the last `width` samples up to each one, or fewer at the start."""
    from scipy.ndimage import maximum_filter1d, minimum_filter1d  # slow to import

    shift = (width - 1) // 2  # the window ends at the sample
    top, bottom = (
        pick(values, width, mode="nearest", origin=shift)
        for pick in (maximum_filter1d, minimum_filter1d)
    )
    return np.asarray(0.5 * (top - bottom))
