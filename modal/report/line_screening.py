"""The screening of a line in sentences, and its agreement with the simulation of the report."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from gallop_fmu import Outcome
from gallop_fmu.simulation.line_result import LineResult
from modal.report.findings import Missing
from modal.report.tables import Table
from modal.screening.line_screen import STATE_COLUMNS, LineScreening, LineState
from modal.screening.line_settled import ALIKE
from modal.screening.line_states import CALM
from modal.screening.verdict import RISK_OF

ALIKE_BEATING = 0.3
"""As `ALIKE` for a state that beats: the largest amplitude of a short window varies (chosen)."""

LASTING = ("steady", "at rest", "beating")
"""Motions of a run that are compared with the states of the screening."""


def screening_sentences(
    found: LineScreening | Missing, result: LineResult | Missing
) -> Iterator[str]:
    """Yield the verdict of the screening, what it did not resolve, and how the run agrees."""
    if isinstance(found, Missing):
        yield f"The screening is missing: {found.reason}"
        return
    yield f"{RISK_OF.capitalize()} by the screening: {found.risk}; {found.reason}."
    if sentence := unresolved(found):
        yield sentence
    if sentence := agreement(found, result):
        yield sentence


def unresolved(found: LineScreening) -> str:
    """What the screening did not resolve, as a sentence; empty if nothing or if `reason` has it."""
    if not found.unresolved or found.risk == "undetermined":
        return ""
    return f"Unresolved by the screening: {'; '.join(found.unresolved)}."


def settled(found: LineScreening) -> list[LineState]:
    """States of a screening whose amplitudes no longer changed."""
    return [state for state in found.states if state.kind != "not settled"]


def agreement(found: LineScreening, result: LineResult | Missing) -> str:
    """Agreement of a run with one of the states of the screening, as a sentence."""
    if isinstance(result, Missing) or "u2_amplitude" not in result.spans:
        return ""
    states = settled(found)
    if not states:
        return ""
    if result.outcome is not Outcome.COMPLETED or result.motion.kind not in LASTING:
        return "The run had not settled, so it is not compared with the states of the screening."
    rows = result.spans.sort_values(["span", "phase"])["u2_amplitude"]
    amplitude = np.nan_to_num(rows.to_numpy(dtype=np.float64))
    # One phase may have been screened for all.
    alike = len(amplitude) // len(states[0].vertical)
    away = [difference(amplitude, np.repeat(state.vertical, alike)) for state in states]
    nearest = int(np.argmin(away))
    state = states[nearest]
    if away[nearest] <= (ALIKE_BEATING if state.kind == "beating" else ALIKE):
        return f"The run ends in a state that the screening found: {state.name}."
    return (
        f"The run and the screening disagree: the run ends with up to {2.0 * amplitude.max():.2f} m"
        " vertical motion at mid-span, peak to peak, but the nearest state of the screening"
        f" ({state.name}) has {2.0 * max(state.vertical):.2f} m. A longer run, or one from another"
        " start, decides."
    )


def difference(run: np.ndarray, state: np.ndarray) -> float:
    """Largest difference of amplitudes [m] by span, relative to the largest; 0 for two at rest."""
    largest = max(float(run.max()), float(state.max()))
    return 0.0 if largest < CALM else float(np.max(np.abs(run - state))) / largest


def states_table(found: LineScreening) -> Table | None:
    """States in the line's wind, a row for each span; None without states."""
    if not found.states:
        return None
    caption = f"States at {found.wind_speed:.4g} m/s by the screening, peak to peak at mid-span"
    return Table(caption, STATE_COLUMNS, found.state_rows())
