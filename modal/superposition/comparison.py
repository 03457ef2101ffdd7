"""Comparison of nonlinear simulation, mode superposition and linear theory of a span or line."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import (
    LineResult,
    Oscillation,
    Result,
    SimulationError,
    simulate,
)
from gallop_fmu.foundation.deprecation import warn_renamed
from gallop_fmu.foundation.figures import drawn
from gallop_fmu.input.scene_like import SceneLike, as_scene
from gallop_fmu.simulation.oscillation import Oscillations, frequency_text
from gallop_fmu.simulation.steadiness import Motion
from modal.foundation.one_thread import one_thread
from modal.linear.line_modes import LineFamily
from modal.linear.modes import Family
from modal.superposition.modal_model import ModalModel, mean_wind
from modal.superposition.mode_superposition import (
    HORIZONTAL,
    TORSIONAL,
    VERTICAL,
    linear_motion,
    nonlinear_motion,
)

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
AnyResult = Result | LineResult
Place = tuple[int, int]
"""Span and phase, from 1."""

CHANNELS = {"u2": "m", "u3": "m", "theta": "rad"}
"""Channels compared at mid-span, and their units; of a bundle those of its centre."""

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

    family: Family | LineFamily
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
    span, phase : int
        Numbers, from 1, of the mid-span.
    """

    model: str
    channel: str
    level: float
    history: float | None
    amplitude: float | None
    span: int = 1
    phase: int = 1


@dataclass(frozen=True)
class Comparison:
    """Three models of one span or line.

    Attributes
    ----------
    nonlinear : Result or LineResult
        The simulation.
    superposition : Result or LineResult
        Linear structure, nonlinear wind load.
    linear : Result or LineResult
        Linear structure, wind load linearised about the equilibrium in mean wind. An unstable
        model ends when its attack angle leaves the coefficient curve; nothing else limits it.
    linear_modes : tuple of LinearMode
        Modes of the linear model, the fastest-growing first.
    divergences : tuple of Divergence
        One for each simpler model, channel, level and mid-span.
    """

    nonlinear: AnyResult = field(repr=False)
    superposition: AnyResult = field(repr=False)
    linear: AnyResult = field(repr=False)
    linear_modes: tuple[LinearMode, ...]
    divergences: tuple[Divergence, ...]

    @property
    def models(self) -> dict[str, AnyResult]:
        """The three results by name."""
        return {
            "nonlinear": self.nonlinear,
            "superposition": self.superposition,
            "linear": self.linear,
        }

    @property
    def places(self) -> tuple[Place, ...]:
        """Span and phase of each mid-span; of one span (1, 1)."""
        return places_of(self.nonlinear)

    def amplitudes(
        self, span: int | None = None, phase: int = 1
    ) -> dict[str, dict[str, Oscillation]]:
        """Oscillation of u2 [m], u3 [m], theta [rad] at mid-span at the end, by model.

        Parameters
        ----------
        span, phase
            Their numbers in a line, from 1; the span may be omitted if there is one.

        Raises
        ------
        SceneError
            There is no such span or phase, or the span is missing.
        """
        found = {}
        for name, result in self.models.items():
            motions = _steady(result, span, phase)
            found[name] = {channel: motions[channel] for channel in CHANNELS}
        return found

    def divergence(
        self, model: str, channel: str, level: float, span: int = 1, phase: int = 1
    ) -> Divergence:
        """Return one of `divergences`."""
        key = (model, channel, level, span, phase)
        return next(
            found
            for found in self.divergences
            if (found.model, found.channel, found.level, found.span, found.phase) == key
        )

    def plot(self, **options: Any) -> Any:
        """Draw the histories and paths by `modal.plots.comparison_figure`, with its options.

        Returns
        -------
        matplotlib.figure.Figure
        """
        return drawn("Comparison.plot", self, **options)

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
                    "outcome": result.outcome.name.lower(),
                    "message": str(result.report),
                    "warnings": list(result.warnings),
                    "motion": str(result.motion),
                    "stop_time": result.report.time,
                    **self._midspans(name),
                }
                for name, result in self.models.items()
            },
            "linear_modes": [asdict(mode) for mode in self.linear_modes],
            "divergences": [asdict(divergence) for divergence in self.divergences],
        }

    def _midspans(self, model: str) -> dict[str, Any]:
        """Amplitudes of a model for JSON: of one span, or by span and phase of a line."""
        rows = [
            {channel: motion.as_dict() for channel, motion in self.amplitudes(*at)[model].items()}
            for at in self.places
        ]
        if isinstance(self.nonlinear, Result):
            return {"midspan": rows[0]}
        places = [{"span": span, "phase": phase} for span, phase in self.places]
        return {"spans": [at | {"midspan": row} for at, row in zip(places, rows, strict=True)]}

    def __str__(self) -> str:
        """Table of amplitudes, and the warnings, with their models unless they hold for all."""
        lines = [f"{'':14}{HEADINGS}"]
        for place in self.places:
            if isinstance(self.nonlinear, LineResult):
                lines.append(f"{self.nonlinear.label(*place)}:")
            rows = self.amplitudes(*place).items()
            lines += [self._row(name, motions, place) for name, motions in rows]
        warned: dict[str, list[str]] = {}  # names of the models of each warning
        for name, result in self.models.items():
            for sentence in result.warnings:
                warned.setdefault(sentence, []).append(name)
        for sentence, names in warned.items():
            about = "" if len(names) == len(self.models) else f" ({', '.join(names)})"
            lines.append(f"warning{about}: {sentence}")
        return "\n".join(lines)

    def _row(self, name: str, motions: dict[str, Oscillation], place: Place) -> str:
        """Row of the table of amplitudes."""
        result = self.models[name]
        u2, u3, theta = (motions[channel] for channel in CHANNELS)
        return (
            f"{name:14}"
            f"{u2.amplitude:10.4f}{frequency_text(u2.frequency_hz):>9}"
            f"{u3.amplitude:10.4f}{frequency_text(u3.frequency_hz):>9}"
            f"{theta.amplitude:13.4f}{result.report.time:11.1f}"
            f"  {motion_of(result, place)}"
        )


@one_thread
def compare(scene: SceneLike, stop_time: float | None = None) -> Comparison:
    """Run the nonlinear simulation, mode superposition and linear theory on one scene.

    All start from the same state. Mode superposition and linear theory have the same modes; they
    differ by the nonlinear wind load. Mode superposition and simulation differ by the nonlinear
    structure.

    Parameters
    ----------
    scene
        The span or line; the linear model uses the mean wind speed, of a line that of each span.
    stop_time
        Simulated time [s]; None takes the scene's.

    Raises
    ------
    SceneError
        If an argument is not allowed, the mesh has too few modes, or the scene has what
        `mode_superposition` refuses.
    SimulationError
        If the simulation cannot start. A run that ends early raises nothing; see its outcome.
    """
    scene = as_scene(scene)
    model = ModalModel.of(scene, vertical=VERTICAL, horizontal=HORIZONTAL, torsional=TORSIONAL)
    linear = linear_motion(model, mean_wind(scene), stop_time)
    superposition = nonlinear_motion(model, stop_time)
    nonlinear = simulate(scene, stop_time, on_failure="return")
    if not nonlinear.started:
        raise SimulationError(nonlinear.report, nonlinear)
    slowest = 1.0 / min(mode.frequency_hz for mode in model.modes)
    divergences = [
        _divergence(nonlinear, (name, other), channel, level, slowest, place)
        for name, other in (("superposition", superposition), ("linear", linear))
        for place in places_of(nonlinear)
        for channel in CHANNELS
        for level in LEVELS
    ]
    return Comparison(nonlinear, superposition, linear, _linear_modes(model), tuple(divergences))


def places_of(result: AnyResult) -> tuple[Place, ...]:
    """Span and phase of each mid-span of a result; of one span (1, 1)."""
    if isinstance(result, Result):
        return ((1, 1),)
    spans, phases = result.map.spans, result.map.phases
    return tuple((span + 1, phase + 1) for span in range(spans) for phase in range(phases))


def midspan_of(result: AnyResult, span: int | None, phase: int) -> xr.Dataset:
    """Histories of mid-span, or of the bundle's centre and twist at a mid-span of a line."""
    return result.midspan() if isinstance(result, Result) else result.bundle(span, phase)


def motion_of(result: AnyResult, place: Place) -> Motion:
    """Judgement of the motion of one mid-span."""
    return result.motion if isinstance(result, Result) else result.motion_of(*place)


def _steady(result: AnyResult, span: int | None, phase: int) -> Oscillations:
    return result.steady() if isinstance(result, Result) else result.steady(None, span, phase)


def _linear_modes(model: ModalModel) -> tuple[LinearMode, ...]:
    """Modes of the linear model in the mean wind, the fastest-growing first."""
    values, vectors = np.linalg.eig(model.linear_system(mean_wind(model.scene))[0])
    families = np.array([mode.family for mode in model.modes])
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
    nonlinear: AnyResult,
    other: tuple[str, AnyResult],
    channel: str,
    level: float,
    period: float,
    place: Place,
) -> Divergence:
    """Compare the histories of a channel from the first `period` [s] to the end of the shorter."""
    model, simpler = other
    count = min(nonlinear.dataset.sizes["time"], simpler.dataset.sizes["time"])
    time = nonlinear.dataset.time.values[:count]
    truth, simple = (
        midspan_of(result, *place)[channel].values[:count] for result in (nonlinear, simpler)
    )
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
        span=place[0],
        phase=place[1],
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
