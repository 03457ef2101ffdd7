"""Whether, and from which wind on, vertical galloping starts the horizontal swing of an iced span."""

from __future__ import annotations

import time as clock
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from gallop_fmu import Scene, SceneError
from modal.linear.mode_basis import at_rest
from modal.screening.continuation import Cycle, Search
from modal.screening.floquet import multipliers
from modal.screening.harmonic_balance import NotConvergedError
from modal.screening.other_modes import OtherMode, first_other_mode
from modal.screening.reduced_model import ReducedModel, reduced_model
from modal.screening.two_mode_estimate import TwoMode, estimate
from modal.stability.frequency_ratio import FrequencyRatio, frequency_ratio

__all__ = ["Cycle", "Screening", "screen"]

Risk = Literal["none", "other", "detuned", "possible", "certain", "undetermined"]

REACH = 1.5
"""Highest wind speed looked at, as a multiple of the scene's, unless one is given."""

NOTICEABLE = 1.002
"""Growth in a cycle from which a loss of mirror symmetry is mentioned: tenfold in about half an hour."""

LEAST_DAMPING = 1e-4
"""Damping ratio of the pair below which there is no threshold to speak of; twist damping alone may give 1e-5."""


@dataclass(frozen=True)
class Screening:
    """What vertical galloping does to the horizontal swing.

    Attributes
    ----------
    risk : {"none", "other", "detuned", "possible", "certain", "undetermined"}
        ``"none"``: no mode gallops up to `highest_wind`; ``"other"``: the first symmetric vertical
        mode does not, so that no 2:1 swing starts, but another mode does; ``"detuned"``: the first
        symmetric vertical mode gallops, but starts no swing up to there; ``"possible"``: not at the
        scene's wind, but at a higher one, or only if kicked; ``"certain"``: at the scene's wind
        galloping starts the swing; ``"undetermined"``: it gallops there, but no periodic motion was
        found, the one that was found is unresolved, or it leaves the coefficient curve.
    reason : str
        Why, in words.
    wind_speed, highest_wind : float
        The scene's wind, and up to where was looked [m/s].
    frequencies : FrequencyRatio
        Natural frequencies of the pair, their ratio and its detuning from 2.
    coupling : float
        Relative change of the swing's stiffness per metre of vertical mid-span displacement [1/m].
    galloping_from, galloping_until : float or None
        Wind speed [m/s] at which galloping begins, and that at which it has died out again, if
        below `highest_wind`.
    limit_cycle : tuple of Cycle
        Vertical galloping without swing over the wind speed, in the order of continuation.
    galloping : Cycle or None
        The same at the scene's wind; None where it does not gallop.
    onset_wind_speed, threshold_amplitude : float or None
        Wind speed [m/s] at which the swing starts, and the vertical amplitude [m] there.
    until_wind_speed : float or None
        Wind speed [m/s] at which galloping no longer starts the swing, where that is below
        `highest_wind`.
    saturated : Cycle or None
        The motion that galloping and swing settle in at the scene's wind; None where there is none,
        or none was found. Where its multiplier is above 1 it comes and goes, and the amplitudes are
        the largest of a short simulation.
    lopsided_growth : float or None
        By how much what breaks the mirror symmetry of the saturated motion, such as two-loop
        galloping, grows (above 1) in one vertical cycle; None without swing or on a span without
        mirror symmetry.
    other_mode : OtherMode or None
        The mode that gallops at the lowest wind up to `highest_wind`, the first symmetric vertical
        one apart.
    warnings : tuple of str
        Warnings of the scene.
    estimate : TwoMode
        The analytic two-mode estimate of the same, for comparison.
    seconds : float
        CPU time of the process that it took.
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
    lopsided_growth: float | None
    other_mode: OtherMode | None
    warnings: tuple[str, ...]
    estimate: TwoMode = field(repr=False)
    seconds: float

    @property
    def swings(self) -> bool:
        """Whether galloping starts the swing at the scene's wind."""
        return self.risk == "certain"

    @property
    def growth_per_cycle(self) -> float | None:
        """By how much a small swing is multiplied in one vertical cycle at the scene's wind; None without galloping."""
        return None if self.galloping is None else self.galloping.multiplier


def screen(scene: Scene, highest_wind: float | None = None) -> Screening:
    """Whether vertical galloping starts the horizontal swing by 2:1 internal resonance, and from which wind on.

    The span is reduced to its lowest modes with all its nonlinearity
    (`modal.screening.reduced_model`). Its vertical limit cycle without swing is followed over the
    wind speed by harmonic balance (`modal.screening.harmonic_balance`); where a Floquet multiplier
    of the swing passes -1 (`modal.screening.floquet`), the swing starts, and the branch of motions
    with swing is followed from there to the scene's wind.

    Parameters
    ----------
    scene
        The span, with wind, coefficient curve and structural damping. Of a wind history the mean
        counts.
    highest_wind
        Highest wind speed [m/s] looked at; None takes 1.5 times the scene's.

    Raises
    ------
    SceneError
        If the pair cannot be identified, there is no wind, no curve or no structural damping, the
        span has no stable shape in the mean wind (divergence), or its galloping leaves the
        coefficient curve or is not found.
    SimulationError
        If no initial equilibrium exists.

    Notes
    -----
    One span, one wind along it, galloping in the first symmetric vertical mode; ``loads`` and seeds
    of the scene are left out. On a span with mirror symmetry only symmetric motion is followed, and
    `Screening.lopsided_growth` tells whether what saturates keeps its symmetry. The saturated
    motion told is on the branch that starts where the swing does. Another may exist beside it, such
    as a swing that comes and goes, and a strong kick may lead there.

    Examples
    --------
    >>> import gallop_fmu as gf, modal
    >>> found = modal.screen(gf.load_scene("example3"))
    >>> found.risk, round(found.onset_wind_speed, 2)
    ('certain', 5.04)
    """
    began = clock.process_time()
    wind = scene.wind.mean_speed
    highest = REACH * wind if highest_wind is None else highest_wind
    check_wind(scene, wind, highest)
    frequencies = frequency_ratio(scene)
    rest = at_rest(scene)
    model = reduced_model(scene, rest)
    _check_damping(model)
    rough = estimate(scene, wind, highest)
    blank = Screening(
        risk="none",
        reason="",
        wind_speed=wind,
        highest_wind=highest,
        frequencies=frequencies,
        coupling=rough.coupling.modulation,
        galloping_from=None,
        galloping_until=None,
        limit_cycle=(),
        galloping=None,
        onset_wind_speed=None,
        threshold_amplitude=None,
        until_wind_speed=None,
        saturated=None,
        lopsided_growth=None,
        other_mode=first_other_mode(model, highest),
        warnings=scene.warnings,
        estimate=rough,
        seconds=0.0,
    )
    search = Search(model, wind, highest)
    try:
        found = _judged(blank, search)
    except NotConvergedError:
        found = _unresolved(blank, search)
    return replace(_with_other_mode(found), seconds=clock.process_time() - began)


def check_wind(scene: Scene, wind: float, highest: float) -> None:
    """Refuse a scene that cannot be screened for want of curve or wind."""
    if scene.aerodynamics is None:
        raise SceneError(
            "aerodynamics is not given: without a coefficient curve no wind can drive the span"
        )
    if not wind > 0.0:
        raise SceneError(
            "wind.speed = 0 m/s: screening needs the wind speed in question; set wind.speed"
        )
    if not highest >= wind:
        raise SceneError(
            f"highest_wind = {highest} m/s: must be at least the scene's wind, {wind} m/s"
        )


def _check_damping(model: ReducedModel) -> None:
    for name, mode, frequency in zip(
        ("vertical", "horizontal"),
        (model.vertical, model.horizontal),
        model.frequencies,
        strict=True,
    ):
        ratio = model.damping[mode, mode] / (2.0 * frequency)
        if ratio < LEAST_DAMPING:
            raise SceneError(
                f"the structural damping ratio of the first {name} mode is {ratio:.2g}; without"
                " damping galloping has no critical wind and the swing no threshold: give"
                f" damping.translation (at least {LEAST_DAMPING:g})"
            )


def _unresolved(blank: Screening, search: Search) -> Screening:
    """The screening where Newton's iteration fails between two orbits of the branch: no onset can be told."""
    return replace(
        blank,
        risk="undetermined",
        galloping_from=search.galloping_from,
        galloping_until=search.galloping_until,
        limit_cycle=search.table(),
        reason=(
            f"f_v/f_h = {blank.frequencies.ratio:.3f}, but the limit cycle is unresolved: no motion"
            " was found between two that it passes through; see simulate(scene)"
        ),
    )


def _judged(blank: Screening, search: Search) -> Screening:
    """The screening with everything that the search finds out."""
    wind = blank.wind_speed
    side = "above" if blank.frequencies.detuning > 0.0 else "below"
    tuned = (
        f"f_v/f_h = {blank.frequencies.ratio:.3f}, {abs(blank.frequencies.detuning):.1%} {side} 2:1"
    )
    found = replace(
        blank,
        galloping_from=search.galloping_from,
        galloping_until=search.galloping_until,
        limit_cycle=search.table(),
    )
    if search.galloping_from is None:
        reached = f"; {search.limit}" if search.limit else ""
        return replace(
            found,
            reason=(
                f"the first symmetric vertical mode does not gallop up to {found.highest_wind:.4g}"
                f" m/s{reached}"
            ),
        )
    galloping = search.galloping()
    cycle = None if galloping is None else search.cycle(galloping[0], abs(galloping[1].swing))
    ended = search.galloping_until is not None and wind > search.galloping_until
    found = replace(found, galloping=cycle)
    limits = search.limits()
    start = next((orbit for orbit, starts in limits if starts), None)
    if start is not None:
        onset = search.cycle(start, 1.0)
        end = next((orbit.wind_speed for orbit, starts in limits if not starts), None)
        found = replace(
            found,
            onset_wind_speed=onset.wind_speed,
            threshold_amplitude=onset.vertical,
            until_wind_speed=end,
        )
        tuned += (
            f": vertical galloping passes the threshold of {onset.vertical:.3g} m at"
            f" {onset.wind_speed:.4g} m/s"
        )
    if cycle is None and not ended and wind > search.galloping_from:
        lost = (
            f"no periodic motion was found at the scene's {wind:.4g} m/s"
            f" ({search.limit or 'none reaches it'})"
        )
        if search.unresolved:
            lost = f"{search.limit}; that is below the scene's {wind:.4g} m/s"
        return replace(
            found, risk="undetermined", reason=f"{tuned}, but {lost}; see simulate(scene)"
        )
    if start is None:
        return replace(
            found, risk="detuned", reason=f"{tuned}: {_no_swing(found, search.limit, ended)}"
        )
    branch, track = search.swing_branch(start)
    settled = search.at_wind(branch, track)
    if settled is not None:
        slowest = float(np.sqrt(np.max(np.abs(multipliers(search.model, settled, 2).all))))
        saturated = search.cycle(settled, slowest, 2)
        found = replace(found, saturated=saturated if slowest <= 1.0 else search.beating(saturated))
    if cycle is None or cycle.multiplier <= 1.0:
        return replace(found, risk="possible", reason=f"{tuned}{_not_yet(found)}")
    if settled is not None:
        found = replace(found, lopsided_growth=search.lopsided(settled, 2))
    return replace(found, risk="certain", reason=f"{tuned}{_swings(found, cycle)}")


def _with_other_mode(found: Screening) -> Screening:
    """The screening with the other mode that gallops in its reason, and in the risk if there is no other."""
    if found.other_mode is None:
        return found
    if found.risk == "none":
        return replace(
            found,
            risk="other",
            reason=f"the 2:1 pair is not at risk ({found.reason}), but {found.other_mode}",
        )
    return replace(found, reason=f"{found.reason}; also, {found.other_mode}")


def _no_swing(found: Screening, limit: str | None, ended: bool) -> str:
    gallops = f"it begins to gallop at {found.galloping_from:.4g} m/s"
    if ended:
        gallops += (
            f" and has died out at {found.galloping_until:.4g} m/s, below the scene's"
            f" {found.wind_speed:.4g} m/s"
        )
    if found.galloping is not None:
        gallops = f"it gallops at {found.galloping.vertical:.3g} m"
    caveat = f" ({limit})" if limit else ""
    return (
        f"{gallops}, but starts no swing up to {found.limit_cycle[-1].wind_speed:.4g} m/s{caveat}"
    )


def _not_yet(found: Screening) -> str:
    end, beside = "", ""
    if found.until_wind_speed is not None:
        end = f" and starts no swing beyond {found.until_wind_speed:.4g} m/s"
    if found.saturated is not None:
        beside = (
            f", though a swing of {found.saturated.horizontal:.3g} m exists there if something"
            " kicks it"
        )
    return f"{end}, not at the scene's {found.wind_speed:.4g} m/s{beside}"


def _swings(found: Screening, galloping: Cycle) -> str:
    outcome = "no steady motion with swing was found"
    if found.saturated is not None:
        end = (
            "beat about an unstable motion with"
            if found.saturated.multiplier > 1.0
            else "settle at"
        )
        outcome = (
            f"both {end} {found.saturated.vertical:.3g} m vertical and"
            f" {found.saturated.horizontal:.3g} m horizontal"
        )
    if found.lopsided_growth is not None and found.lopsided_growth > NOTICEABLE:
        outcome += (
            f"; what breaks the mirror symmetry grows by {found.lopsided_growth - 1.0:.1%} a cycle"
            " there"
        )
    return (
        f"; at {found.wind_speed:.4g} m/s it would reach {galloping.vertical:.3g} m, a swing grows"
        f" by {galloping.multiplier - 1.0:.1%} a cycle, and {outcome}"
    )
