"""Output of ``gallop-modal modes``, ``ratio`` and ``linear`` for a line."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from gallop_fmu.cli.terminal import new_table
from modal.cli.output import show

if TYPE_CHECKING:
    from gallop_fmu.scene.line_scene import LineScene
    from modal.linear.line_modes import LineMode
    from modal.stability.critical_wind import CriticalWind
    from modal.stability.line_criteria import SpanCriteria
    from modal.stability.mode_pairs import ModePair

MAX_PAIRS = 20
"""Most pairs of modes in the output for people; JSON has all."""

NEAREST_PAIRS = 5
"""Pairs in the output for people if none matters."""

LOCUS_POINTS = 31
"""Wind speeds of a root locus."""

LISTED_SHARE = 0.1
"""Share of the kinetic energy above which a span, phase or part of the motion is listed."""


def show_modes(
    scene: LineScene,
    count: int,
    wind: Literal["still", "mean"],
    plot: Path | None,
    as_json: bool,
) -> None:
    """Print the lowest modes of a line."""
    from modal.linear.modes import natural_modes

    found = natural_modes(scene, count, wind)

    def figure() -> Any:
        from gallop_fmu import Model
        from modal.plots.line_figures import line_mode_shapes

        return line_mode_shapes(Model(scene), found, scene.title)

    content = {
        "title": scene.title,
        "warnings": list(scene.warnings),
        "wind": wind,
        "modes": [mode_numbers(mode) for mode in found],
    }
    show(content, [scene.title, _mode_table(found)], figure, plot, as_json)


def mode_numbers(mode: LineMode) -> dict[str, Any]:
    """A mode as JSON."""
    return {
        "frequency_hz": mode.frequency_hz,
        "damping_ratio": mode.damping_ratio,
        "family": mode.family,
        "loops": list(mode.loops),
        "shares": mode.shares,
        "span_shares": mode.span_shares.tolist(),
        "phase_shares": mode.phase_shares.tolist(),
        "subconductor_shares": mode.subconductor_shares.tolist(),
        "device_share": mode.device_share,
        "tension_share": mode.tension_share,
    }


def _mode_table(found: list[LineMode]) -> Any:
    """Table of modes for people."""
    phases = len(found[0].phase_shares) > 1 if found else False
    titles = ["mode", "frequency [Hz]", "damping ratio", "family", "loops", "spans"]
    table = new_table(*titles, *(["phases"] if phases else []), "tension")
    for number, mode in enumerate(found, start=1):
        table.add_row(
            str(number),
            f"{mode.frequency_hz:.4f}",
            f"{mode.damping_ratio:.3%}",
            _families(mode),
            " ".join(str(loops) if loops else "-" for loops in mode.loops),
            _numbered(mode.span_shares.tolist()),
            *([_numbered(mode.phase_shares.tolist())] if phases else []),
            f"{mode.tension_share:.0%}",
        )
    return table


def _families(mode: LineMode) -> str:
    """Family of a mode, with the other parts of a mixture."""
    parts = sorted(mode.shares, key=lambda part: -mode.shares[part])
    others = [f"{part} {mode.shares[part]:.0%}" for part in parts[1:]]
    others = [text for text, part in zip(others, parts[1:], strict=True) if _listed(mode, part)]
    return f"{mode.family} ({', '.join(others)})" if others else mode.family


def _listed(mode: LineMode, part: Any) -> bool:
    return mode.shares[part] >= LISTED_SHARE


def _numbered(shares: list[float]) -> str:
    """Numbers and shares of those that take part, such as ``1 50%, 3 50%``."""
    return ", ".join(
        f"{number} {share:.0%}"
        for number, share in enumerate(shares, start=1)
        if share >= LISTED_SHARE
    )


def show_pairs(scene: LineScene, plot: Path | None, as_json: bool) -> None:
    """Print the pairs of modes of a line near 2:1 and 1:1."""
    from modal.stability.mode_pairs import mode_pairs

    found = mode_pairs(scene)

    def figure() -> Any:
        from modal.plots.line_figures import pair_figure

        return pair_figure(found, scene.title)

    content = {
        "title": scene.title,
        "warnings": list(scene.warnings),
        "pairs": [_pair_numbers(pair) for pair in found],
    }
    shown = _pair_lines(found)
    show(content, [scene.title, *shown], figure, plot, as_json)


def _pair_lines(found: list[ModePair]) -> list[Any]:
    """Pairs that matter, or the nearest ones if none does, and what is left out."""
    if not found:
        return ["no two coupled modes are near 2:1 or 1:1"]
    matter = [pair for pair in found if pair.matters]
    listed = matter[:MAX_PAIRS] or found[:NEAREST_PAIRS]
    lines = [
        found[0].sentence if matter else "no pair matters; the nearest are:",
        _pair_table(listed),
        "starts at: amplitude of the first mode above which it starts the second; may reach:"
        " amplitude that galloping in the first mode may reach. A pair matters if it starts below"
        " that.",
    ]
    if len(found) > len(listed):
        more = len(matter) - len(listed) if matter else 0
        lines.append(f"{len(found) - len(listed)} more pairs, of which {more} matter: see --json")
    return lines


def _pair_table(pairs: list[ModePair]) -> Any:
    table = new_table(
        "pair", "first mode [Hz]", "second mode [Hz]", "off by", "starts at", "may reach"
    )
    for pair in pairs:
        unit = "rad" if pair.driving_mode.family == "torsional" else "m"
        table.add_row(
            pair.kind,
            _short(pair.driving, pair.driving_mode),
            _short(pair.driven, pair.driven_mode),
            f"{pair.detuning:+.1%}",
            "never" if pair.threshold is None else f"{pair.threshold:.3g} {unit}",
            f"{pair.largest_galloping:.3g} {unit}" if pair.largest_galloping else "does not gallop",
        )
    return table


def _short(number: int, mode: LineMode) -> str:
    return f"{number} {mode.family} {mode.frequency_hz:.4f}"


def _pair_numbers(pair: ModePair) -> dict[str, Any]:
    return {
        "kind": pair.kind,
        "driving": pair.driving,
        "driven": pair.driven,
        "driving_hz": pair.driving_mode.frequency_hz,
        "driven_hz": pair.driven_mode.frequency_hz,
        "driving_family": pair.driving_mode.family,
        "driven_family": pair.driven_mode.family,
        "detuning": pair.detuning,
        "coupling": pair.coupling,
        "modulation": pair.modulation,
        "threshold": pair.threshold,
        "largest_galloping": pair.largest_galloping,
        "matters": pair.matters,
        "sentence": pair.sentence,
    }


def show_linear(
    scene: LineScene, count: int, highest: float, plot: Path | None, as_json: bool
) -> None:
    """Print the criteria of each span of a line, and the critical wind of each mode."""
    import numpy as np

    from gallop_fmu.foundation.errors import SceneError
    from modal.stability.critical_wind import critical_wind_speed
    from modal.stability.line_criteria import line_criteria

    criteria, onsets = line_criteria(scene), critical_wind_speed(scene, count, highest)

    def figure() -> Any:
        from modal.linear.state_space import root_locus
        from modal.plots.span_figures import locus_figure

        if onsets[0].searched_to == 0.0:
            raise SceneError(f"no root locus: {onsets[0].remark}")
        return locus_figure(
            root_locus(scene, list(np.linspace(0.0, onsets[0].searched_to, 31)), count)
        )

    content = {
        "title": scene.title,
        "warnings": list(scene.warnings),
        "spans": [_span_numbers(span) for span in criteria],
        "critical_winds": [_onset_numbers(onset) for onset in onsets],
    }
    lines = [
        f"span {span.span}, {math.degrees(span.attack_angle):.1f} deg:"
        f" {('unstable by ' + '; '.join(span.unstable)) if span.unstable else 'stable'}"
        for span in criteria
    ]
    remarks = {span.remark for span in criteria if span.remark}
    remarks |= {onset.remark for onset in onsets if onset.remark}
    show(content, [scene.title, *lines, _onset_table(onsets), *remarks], figure, plot, as_json)


def _span_numbers(span: SpanCriteria) -> dict[str, Any]:
    return {
        "span": span.span,
        "attack_angle_deg": math.degrees(span.attack_angle),
        "unstable": span.unstable,
        "unstable_attack_angles_deg": {
            criterion.name: criterion.unstable_deg for criterion in span.criteria
        },
        "causes": {
            criterion.name: criterion.causes for criterion in span.criteria if criterion.causes
        },
        "remark": span.remark,
    }


def _onset_numbers(onset: CriticalWind) -> dict[str, Any]:
    return {
        "family": onset.mode.family,
        "loops": onset.mode.loops,
        "still_air_hz": onset.mode.frequency_hz,
        "wind_speed": onset.wind_speed,
        "frequency_hz": onset.frequency_hz,
        "den_hartog": onset.den_hartog,
        "searched_to": onset.searched_to,
        "remark": onset.remark,
    }


def _onset_table(onsets: list[CriticalWind]) -> Any:
    table = new_table("mode", "still air [Hz]", "critical wind [m/s]", "Den Hartog [m/s]")
    for number, onset in enumerate(onsets, start=1):
        table.add_row(
            f"{number} {onset.mode.family}",
            f"{onset.mode.frequency_hz:.4f}",
            (
                f"none up to {onset.searched_to:g}"
                if onset.wind_speed is None
                else f"{onset.wind_speed:.3f}"
            ),
            "-" if onset.den_hartog is None else f"{onset.den_hartog:.3f}",
        )
    return table


def show_line_screening(scene: LineScene, highest: float | None, as_json: bool) -> None:
    """Print the screening of a line."""
    from dataclasses import asdict

    from modal.screening.line_screen import STATE_COLUMNS
    from modal.screening.screen import screen
    from modal.screening.verdict import RISK_OF

    found = screen(scene, highest)
    content = {
        "title": scene.title,
        **asdict(found),
        "galloping_from": found.galloping_from,
        "onset_wind_speed": found.onset_wind_speed,
    }
    lines: list[Any] = [scene.title, f"{RISK_OF}: {found.risk}", found.reason]
    lines += [
        f"from rest: {one.disturbance} grows by {one.growth_rate:.3g} 1/s, from 1 mm to 0.1 m in"
        f" {one.time():.3g} s"
        for one in found.transfers
    ]
    if found.risk != "undetermined":  # there the reason has them
        lines += [f"unresolved: {sentence}" for sentence in found.unresolved]
    if found.states:
        lines.append("peak to peak at mid-span (vertical: the largest of mid-span and quarters):")
        table = new_table(*STATE_COLUMNS)
        for row in found.state_rows():
            table.add_row(*row)
        lines.append(table)

    def no_figure() -> Any:
        raise AssertionError

    show(content, lines, no_figure, None, as_json)
