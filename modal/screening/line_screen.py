"""Screening of a line: which motions begin in which wind, and where it settles in its wind."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Sequence
from dataclasses import dataclass, field

from gallop_fmu import LineScene, SceneError
from gallop_fmu.foundation.notebook_table import notebook_table
from modal.foundation.alike_phases import one_phase
from modal.motions.line_basis import coarse
from modal.motions.line_model import LineModel
from modal.motions.motion_models import check_scene
from modal.screening.cycles import Transfer
from modal.screening.line_rest import LineOnset, LineRest, Trial, line_rest, onsets, trials
from modal.screening.line_settled import settled_states
from modal.screening.line_states import LineState
from modal.screening.line_transitions import LineTransition, transitions
from modal.screening.verdict import RISK_OF, Risk, divergence_sentence, with_turning

__all__ = ["LineOnset", "LineScreening", "LineState", "LineTransition", "screen_line"]

ELEMENTS = 6
"""Most elements of a span, if spacers and devices allow it."""

MIN_DAMPING_RATIO = 1e-4
"""Smallest structural damping ratio of a mode, as for a span."""

MAX_DEVICE_SHARE = 0.5
"""Part of the kinetic energy in devices up to which a mode must be damped: a mass that hangs on a
damper is damped along the damper alone, and the wind does not act on it."""

MAX_TRANSFERS = 4
"""Growing disturbances of rest in the output for people."""


@dataclass(frozen=True, repr=False)
class LineScreening:
    """Motions of a section or bundle in its wind, and what galloping starts.

    Of phases that nothing connects, all of which move alike, one is screened for all.

    Attributes
    ----------
    risk : {"none", "other", "detuned", "possible", "certain", "turns over", "undetermined"}
        Risk of a swing of strings or spans at half the frequency of galloping or, if none was
        found, of turning over. ``"none"``: no
        motion begins up to `highest_wind`. ``"other"``: no span gallops in one loop, but another
        motion begins. ``"detuned"``: spans gallop, but no swing was found. ``"possible"``: a swing
        starts only at other wind speeds, or after a strong disturbance. ``"certain"``: galloping
        starts the swing at the line's wind. ``"turns over"``: no swing was found, but rest is
        statically unstable in a wind up to `highest_wind`, or it is unstable in the line's wind and
        a stable state is turned over. ``"undetermined"``: rest is unstable in the line's
        wind, but no motion was found that it settles at; `reason` says why.
    reason : str
        Reason for the risk, as a sentence.
    wind_speed, highest_wind : float
        The line's wind speed and the highest one of the search [m/s].
    onsets : tuple of LineOnset
        Motions that begin on rest up to the highest wind, each kind once: one loop, two loops,
        bundle torsion, ... They do not depend on the line's wind.
    transitions : tuple of LineTransition
        What the first motion starts: a string swing, bundle torsion, an exchange between spans.
    divergence_from : float or None
        Wind speed [m/s] from which rest is statically unstable; None: it is not.
    states : tuple of LineState
        Stable states in the line's wind that were found. Which of them the line reaches depends on
        its start.
    transfers : tuple of Transfer
        Growing disturbances of rest in the line's wind, the fastest of each kind.
    unresolved : tuple of str
        What could not be found out, and why.
    unresolved_states : tuple of str
        Those of them that concern the states: there may be others, or larger ones.
    warnings : tuple of str
        Warnings of the scene.
    seconds : float
        CPU time [s].
    """

    risk: Risk
    reason: str
    wind_speed: float
    highest_wind: float
    onsets: tuple[LineOnset, ...]
    transitions: tuple[LineTransition, ...]
    divergence_from: float | None
    states: tuple[LineState, ...]
    transfers: tuple[Transfer, ...]
    unresolved: tuple[str, ...]
    unresolved_states: tuple[str, ...] = field(repr=False)
    warnings: tuple[str, ...]
    seconds: float

    def __repr__(self) -> str:
        lines = [f"Screening at {self.wind_speed:g} m/s: {self.risk}; {self.reason}"]
        lines += [f"unresolved: {sentence}" for sentence in self.unresolved]
        return "\n".join([*lines, *(f"warning: {sentence}" for sentence in self.warnings)])

    def _repr_html_(self) -> str:
        """Table for notebooks."""
        return notebook_table(
            f"{RISK_OF.capitalize()}, {self.wind_speed:g} m/s: {self.risk}",
            STATE_COLUMNS,
            self.state_rows(),
            (self.reason, *self.unresolved, *self.warnings),
        )

    def state_rows(self) -> list[tuple[str, ...]]:
        """Texts of a table with the columns `STATE_COLUMNS`: a row for each state and span.

        Displacements are peak to peak.
        """
        rows = list[tuple[str, ...]]()
        for state in self.states:
            turns = zip(state.peak_to_peak, state.horizontal, state.rotation, strict=True)
            for number, (vertical, horizontal, rotation) in enumerate(turns, start=1):
                first = number == 1
                rows.append(
                    (
                        f"{state.name}, {state.kind}" if first else "",
                        str(number),
                        f"{vertical:.3g}",
                        f"{2.0 * horizontal:.3g}",
                        f"{2.0 * math.degrees(rotation):.3g}",
                        f"{2.0 * max(state.clamp):.3g}" if first and state.clamp else "-",
                    )
                )
        return rows

    @property
    def galloping_from(self) -> float | None:
        """Lowest wind speed [m/s] in which a span gallops in one loop; None: none does."""
        return min((one.wind_speed for one in self.onsets if _is_galloping(one)), default=None)

    @property
    def other_galloping_from(self) -> float | None:
        """Lowest wind speed [m/s] in which another motion begins; None: none does."""
        return min((one.wind_speed for one in self.onsets if not _is_galloping(one)), default=None)

    @property
    def onset_wind_speed(self) -> float | None:
        """Lowest wind speed [m/s] in which galloping starts a swing; None: none was found."""
        return min((one.wind_speed for one in self.transitions if one.is_swing), default=None)

    @property
    def swings(self) -> bool:
        """True if galloping starts the swing at the line's wind."""
        return self.risk == "certain"


STATE_COLUMNS = (
    "state",
    "span",
    "vertical [m]",
    "horizontal [m]",
    "rotation [deg]",
    "clamps across [m]",
)
"""Columns of `LineScreening.state_rows`."""


def screen_line(scene: LineScene, highest_wind: float) -> LineScreening:
    """Screen a line; see `modal.screening.screen.screen`.

    Parameters
    ----------
    scene
        The line.
    highest_wind
        Highest wind speed [m/s] of the search.

    Raises
    ------
    SceneError
        The scene has no wind, no curve or almost no damping, or its wind is not uniform.
    """
    began = clock.process_time()
    wind = scene.wind.mean_speed
    check_scene(scene, wind)
    model = LineModel(coarse(one_phase(scene), ELEMENTS))
    _check_damping(model)
    rest = line_rest(model, wind, highest_wind)
    equilibria = rest.equilibria()
    modes = trials(rest, equilibria[0][0]) if equilibria else []
    begin = onsets(rest, modes)
    settled = settled_states(rest, equilibria, modes)
    found, doubts = transitions(rest)
    is_stable = bool(equilibria) and equilibria[0][1]
    ended = (rest.end_reason,) if rest.end_reason else ()
    swing = _risk(begin, found, settled.states, is_stable, wind)
    turned = [state.is_turned_over for state in settled.states]
    risk = with_turning(swing, rest.divergence, turned, not is_stable)
    unresolved = (*settled.doubts, *doubts, *ended)
    return LineScreening(
        risk=risk,
        reason=_reason(rest, begin, found, settled.states, risk, unresolved),
        wind_speed=wind,
        highest_wind=highest_wind,
        onsets=begin,
        transitions=found,
        divergence_from=rest.divergence,
        states=settled.states,
        transfers=_transfers(modes, begin),
        unresolved=unresolved,
        unresolved_states=settled.doubts,
        warnings=scene.warnings,
        seconds=clock.process_time() - began,
    )


def _check_damping(model: LineModel) -> None:
    """Raise SceneError if a mode of the conductors has almost no structural damping."""
    for k, mode in enumerate(model.basis.modes):
        if mode.device_share > MAX_DEVICE_SHARE:
            continue
        ratio = model.damping[k, k] / (4.0 * math.pi * mode.frequency_hz)
        if ratio < MIN_DAMPING_RATIO:
            raise SceneError(
                f"the structural damping ratio of mode {k + 1} ({mode.family},"
                f" {mode.frequency_hz:.3g} Hz) is {ratio:.2g}: without damping galloping has no"
                f" critical wind; give damping.translation (at least {MIN_DAMPING_RATIO:g})"
            )


def _is_galloping(one: LineOnset) -> bool:
    return (one.kind, one.loops) == ("vertical", 1)


def _transfers(modes: Sequence[Trial], begin: Sequence[LineOnset]) -> tuple[Transfer, ...]:
    """Fastest growing disturbance of rest of each kind in the scene's wind."""
    names = {(one.kind, one.loops): one.name for one in begin}
    found: dict[tuple[str, int], Transfer] = {}
    for one in modes:
        if one.rate > 0.0:
            key = (one.kind, one.loops)
            name = names.get(key, one.name)
            found.setdefault(key, Transfer("rest", name, one.rate, one.omega / (2.0 * math.pi)))
    return tuple(found.values())


def _risk(
    begin: Sequence[LineOnset],
    found: Sequence[LineTransition],
    states: Sequence[LineState],
    rest_is_stable: bool,
    wind: float,
) -> Risk:
    """Risk of a swing that follows from what was found."""
    resolved = [state for state in states if state.kind != "not settled"]
    if not resolved and not rest_is_stable:
        return "undetermined"
    if not any(_is_galloping(one) for one in begin):
        return "other" if begin else "none"
    starts = [one.wind_speed for one in found if one.is_swing]
    return _risk_of_swing(resolved, starts, rest_is_stable, wind)


def _risk_of_swing(
    states: Sequence[LineState], starts: Sequence[float], rest_is_stable: bool, wind: float
) -> Risk:
    """Risk of a swing of a line that gallops, from its states and the winds that start one."""
    swinging = [state for state in states if state.has_swing]
    if not swinging:
        return "possible" if starts else "detuned"
    is_started = min(starts, default=math.inf) <= wind or len(swinging) == len(states)
    return "certain" if is_started and not rest_is_stable else "possible"


def _reason(
    rest: LineRest,
    begin: Sequence[LineOnset],
    found: Sequence[LineTransition],
    states: Sequence[LineState],
    risk: Risk,
    unresolved: Sequence[str],
) -> str:
    """Word the verdict as a sentence."""
    if begin:
        parts = ["motions that begin: " + ", ".join(map(str, begin))]
    else:
        parts = [f"no motion begins up to {rest.highest:.4g} m/s"]
    parts += [str(one) for one in found]
    if rest.divergence is not None:
        parts.append(divergence_sentence(rest.divergence))
    settled = [state for state in states if state.kind != "not settled"]
    if settled:
        listed = " or ".join(map(str, settled))
        parts.append(f"stable at {rest.wind:.4g} m/s: {listed}")
    if risk == "undetermined":
        why = "; ".join(unresolved) or "no stable motion was found"
        parts.append(f"unresolved at {rest.wind:.4g} m/s: {why}; run a simulation")
    return "; ".join(parts)
