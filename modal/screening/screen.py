"""Screening of a span: vertical galloping, and the horizontal swing that it starts."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass, field
from typing import Any, overload

from gallop_fmu import LineScene, Scene, SceneError
from gallop_fmu.foundation.deprecation import warn_renamed
from gallop_fmu.foundation.figures import drawn
from gallop_fmu.foundation.notebook_table import notebook_table
from gallop_fmu.input.scene_like import SceneLike, as_scene
from modal.foundation.normal_wind import check_wind_is_normal
from modal.foundation.one_thread import one_thread
from modal.motions.reduced_model import ReducedModel
from modal.screening.cycles import Cycle, StableState, Transfer
from modal.screening.line_screen import LineScreening, screen_line
from modal.screening.other_modes import OtherMode
from modal.screening.span_diagram import span_diagram, span_model
from modal.screening.two_mode_estimate import TwoMode, estimate
from modal.screening.verdict import RISK_OF, Risk, judge
from modal.stability.frequency_ratio import FrequencyRatio, frequency_ratio

__all__ = ["Cycle", "Screening", "StableState", "Transfer", "screen"]

MAX_WIND_RATIO = 1.5
"""Default of the highest wind speed, relative to the scene's."""

MIN_DAMPING_RATIO = 1e-4
"""Smallest structural damping ratio of the pair; damping of the twist alone may give 1e-5."""


@dataclass(frozen=True, repr=False)
class Screening:
    """Motions of a span in its wind, and the effect of galloping on the horizontal swing.

    Attributes
    ----------
    risk : {"none", "other", "detuned", "possible", "certain", "turns over", "undetermined"}
        Risk of a swing or, if none starts, of turning over. ``"none"``: no mode gallops up to
        `highest_wind`. ``"other"``: the first symmetric vertical mode does not gallop, so that no
        2:1 swing starts, but another mode does. ``"detuned"``: the first symmetric vertical mode
        gallops, but starts no swing. ``"possible"``: it starts a swing only at other wind speeds,
        or after a strong disturbance. ``"certain"``: galloping starts the swing at the scene's
        wind. ``"turns over"``: no swing
        starts, but rest is statically unstable in a wind up to `highest_wind`, or it is unstable at
        the scene's wind and a stable state is turned over. ``"undetermined"``: the span is unstable
        at the scene's wind, but no motion was found that it settles at; `reason` says why.
    reason : str
        Reason for the risk, as a sentence.
    wind_speed, highest_wind : float
        The scene's wind speed and the highest one of the search [m/s].
    frequencies : FrequencyRatio
        Natural frequencies of the pair, their ratio and its detuning from 2.
    coupling : float
        Relative change of the swing's stiffness per metre of vertical mid-span displacement [1/m].
    galloping_from, galloping_until : float or None
        Wind speeds [m/s] at which galloping begins, and at which it ends again if that is below
        `highest_wind`.
    limit_cycle : tuple of Cycle
        Vertical galloping without swing over the wind speed, in the order of continuation.
    galloping : Cycle or None
        The same at the scene's wind; None if it does not gallop there.
    onset_wind_speed, threshold_amplitude : float or None
        Wind speed [m/s] at which the swing starts, and the vertical amplitude [m] there.
    until_wind_speed : float or None
        Wind speed [m/s] from which galloping no longer starts the swing, if that is below
        `highest_wind`.
    saturated : Cycle or None
        The one of `states` with the largest swing; None if there is none. Its multiplier is 1 if
        it was simulated.
    antisymmetric_growth : float or None
        Factor by which an antisymmetric disturbance of the symmetric motion with swing, such as
        two-loop galloping, grows (above 1) in one vertical cycle; None without swing, or for a span
        without mirror symmetry. `states` has what it grows to.
    other_mode : OtherMode or None
        The mode, other than the first symmetric vertical one, that gallops at the lowest wind up to
        `highest_wind`.
    divergence_from : float or None
        Wind speed [m/s] from which rest is statically unstable; None: it is not.
    states : tuple of StableState
        All stable states at the scene's wind that were found: equilibria, periodic motions, and
        beating ones, which are simulated. Which of them the span reaches depends on its start.
    transfers : tuple of Transfer
        Growing disturbances of the unstable motions at the scene's wind, with their growth rates
        and the time that they take.
    unresolved : tuple of str
        What could not be found out, and why.
    warnings : tuple of str
        Warnings of the scene.
    estimate : TwoMode
        The closed-form two-mode estimate, for comparison.
    seconds : float
        CPU time [s].
    """

    risk: Risk
    reason: str
    wind_speed: float
    highest_wind: float
    frequencies: FrequencyRatio
    coupling: float
    galloping_from: float | None
    galloping_until: float | None
    limit_cycle: tuple[Cycle, ...] = field(repr=False)
    galloping: Cycle | None
    onset_wind_speed: float | None
    threshold_amplitude: float | None
    until_wind_speed: float | None
    saturated: Cycle | None
    antisymmetric_growth: float | None
    other_mode: OtherMode | None
    divergence_from: float | None
    states: tuple[StableState, ...]
    transfers: tuple[Transfer, ...]
    unresolved: tuple[str, ...]
    warnings: tuple[str, ...]
    estimate: TwoMode = field(repr=False)
    seconds: float

    def __repr__(self) -> str:
        lines = [f"Screening at {self.wind_speed:g} m/s: {self.risk}; {self.reason}"]
        return "\n".join([*lines, *(f"warning: {sentence}" for sentence in self.warnings)])

    def _repr_html_(self) -> str:
        """Table for notebooks."""
        pair, saturated = self.frequencies, self.saturated
        gallops = self.galloping and self.galloping.vertical
        rows = (
            ("frequency ratio", pair.ratio, "1"),
            ("galloping from a wind of", self.galloping_from, "m/s"),
            ("vertical amplitude without swing", gallops, "m"),
            ("swing from a wind of", self.onset_wind_speed, "m/s"),
            ("statically unstable from a wind of", self.divergence_from, "m/s"),
            ("vertical amplitude at which it starts", self.threshold_amplitude, "m"),
            ("vertical amplitude with swing", saturated and saturated.vertical, "m"),
            ("horizontal amplitude with swing", saturated and saturated.horizontal, "m"),
        )
        return notebook_table(
            f"{RISK_OF.capitalize()}, {self.wind_speed:g} m/s: {self.risk}",
            ("", "value", "unit"),
            [(name, "-" if value is None else f"{value:.4g}", unit) for name, value, unit in rows],
            (self.reason, *self.warnings),
        )

    def plot(self) -> Any:
        """Draw motion and growth over the wind speed by `modal.plots.screening_figure`.

        Returns
        -------
        matplotlib.figure.Figure
        """
        return drawn("Screening.plot", self)

    @property
    def swings(self) -> bool:
        """True if galloping starts the swing at the scene's wind."""
        return self.risk == "certain"

    @property
    def growth_per_cycle(self) -> float | None:
        """Growth of a small swing in one vertical cycle at the scene's wind.

        None without galloping.
        """
        return None if self.galloping is None else self.galloping.multiplier

    @property
    def lopsided_growth(self) -> float | None:
        """Deprecated name of `antisymmetric_growth`."""
        warn_renamed("Screening.lopsided_growth", "antisymmetric_growth")
        return self.antisymmetric_growth


@overload
def screen(scene: Scene, highest_wind: float | None = None) -> Screening: ...


@overload
def screen(scene: LineScene, highest_wind: float | None = None) -> LineScreening: ...


@overload
def screen(scene: SceneLike, highest_wind: float | None = None) -> Screening | LineScreening: ...


@one_thread
def screen(scene: SceneLike, highest_wind: float | None = None) -> Screening | LineScreening:
    """Find out how a span or line gallops, and if that starts a swing (2:1 resonance).

    The span is reduced to its lowest modes with all nonlinear terms (`modal.motions.span_model`).
    From the lowest wind on in which one of them grows, the motions that begin at rest and those
    that branch off them are followed up to the highest wind (`modal.continuation`). A swing starts
    where a Floquet multiplier passes -1. A motion that loses its stability otherwise, mostly as it
    begins to beat, is simulated with the full model.

    Of a section or bundle (`modal.motions.line_model`), all motions that begin on rest are found,
    and the first one is followed up to where it starts another. The states in the scene's wind are
    found by simulations with the full model that start near the motions that the wind drives most.

    Parameters
    ----------
    scene
        The span or line, with wind, coefficient curve and structural damping. A wind history counts
        with its mean.
    highest_wind
        Highest wind speed [m/s] of the search; None takes 1.5 times the scene's.

    Returns
    -------
    Screening or LineScreening

    Raises
    ------
    SceneError
        If the pair cannot be identified; if the scene has no wind, no curve or no structural
        damping; or if the span has no equilibrium in the mean wind, and no galloping begins below.
    SimulationError
        If no initial equilibrium exists.

    Notes
    -----
    Limits: steady wind, for a line uniform. ``loads`` and seeds of the scene are ignored. Onsets
    and motions do not depend on the scene's wind. Motions not connected with rest are not found;
    unstable ones are not followed beyond three growing disturbances. Where a stable orbit is more
    than 10 % away from the full model after a period, it is simulated, too. Simulations have eight
    elements, start with a small disturbance, and last 500 to 6000 periods, until the amplitudes no
    longer change; those of an irregular motion are the largest of at least 2000 periods.

    Limits for a line: at most five simulations, of up to 1200 periods (3600 as long as no state is
    known), so that states which none of them reaches are not found; transitions are those of the
    first motion alone.

    Examples
    --------
    >>> import gallop_fmu as gf, modal
    >>> found = modal.screen(gf.load_scene("example3"))
    >>> found.risk, round(found.onset_wind_speed, 2)
    ('certain', 5.04)
    """
    began = clock.process_time()
    scene = as_scene(scene)
    wind = scene.wind.mean_speed
    highest = MAX_WIND_RATIO * wind if highest_wind is None else highest_wind
    check_wind(scene, wind, highest)
    if isinstance(scene, LineScene):
        return screen_line(scene, highest)
    frequencies = frequency_ratio(scene)
    rough = estimate(scene, wind, highest)
    model = span_model(scene)
    _check_damping(model)
    judged = judge(span_diagram(model, highest), frequencies)
    return Screening(
        risk=judged.risk,
        reason=judged.reason,
        wind_speed=wind,
        highest_wind=highest,
        frequencies=frequencies,
        coupling=rough.coupling.modulation,
        galloping_from=judged.galloping_from,
        galloping_until=judged.galloping_until,
        limit_cycle=judged.limit_cycle,
        galloping=judged.galloping,
        onset_wind_speed=None if judged.onset is None else judged.onset.wind_speed,
        threshold_amplitude=None if judged.onset is None else judged.onset.vertical,
        until_wind_speed=judged.until_wind_speed,
        saturated=judged.saturated,
        antisymmetric_growth=judged.antisymmetric_growth,
        other_mode=judged.other_mode,
        divergence_from=judged.divergence_from,
        states=judged.states,
        transfers=judged.transfers,
        unresolved=judged.unresolved,
        warnings=scene.warnings,
        estimate=rough,
        seconds=clock.process_time() - began,
    )


def check_wind(scene: Scene | LineScene, wind: float, highest: float) -> None:
    """Raise SceneError if a scene has no coefficient curve or no wind, or the range is empty."""
    if scene.aerodynamics is None:
        raise SceneError(
            "aerodynamics is not given: without a coefficient curve the wind has no effect; give"
            " one"
        )
    check_wind_is_normal(scene, "screening", wind, oblique=True)
    if not wind > 0.0:
        raise SceneError("wind.speed = 0 m/s: screening needs wind; set wind.speed")
    if not highest >= wind:
        raise SceneError(
            f"highest_wind = {highest} m/s: must be at least the scene's wind, {wind} m/s"
        )


def _check_damping(model: ReducedModel) -> None:
    """Raise SceneError if a mode of the pair has almost no structural damping."""
    for name, mode, frequency in zip(
        ("vertical", "horizontal"),
        (model.vertical, model.horizontal),
        model.frequencies,
        strict=True,
    ):
        ratio = model.damping[mode, mode] / (2.0 * frequency)
        if ratio < MIN_DAMPING_RATIO:
            raise SceneError(
                f"the structural damping ratio of the first {name} mode is {ratio:.2g}: without"
                " damping galloping has no critical wind and the swing no threshold; give"
                f" damping.translation (at least {MIN_DAMPING_RATIO:g})"
            )
