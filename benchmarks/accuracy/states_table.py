"""Compare the states of `modal.screen` with long simulations; print a Markdown table.

Usage: python benchmarks/accuracy/states_table.py SET [--cache FILE]

SET is a seed of the 26 scenes of screening_table.py (2009, 20261122, 20261123, 771); "new": 60
scenes of another seed, of which 24 have a curve over the full circle, 12 this and inclined
supports, and 24 inclined supports; or "circle": full_circle_350m.toml in seven winds. About ten
minutes on one core; with a cache, simulations are not repeated.

The nonlinear model starts with three different disturbances, each with a push that is not symmetric
about mid-span, and runs for 2500 s; if none of the runs has settled, for 30,000 s. The last third
of a run must end in one of the stable states of the screening. Amplitudes are those of u2 and u3 at
mid-span and of the antisymmetric u2 at the quarter points; the error is the largest difference,
relative to the largest amplitude.
"""

from __future__ import annotations

import json
import math
import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

from screening_table import fixed_scenes

import gallop_fmu as gf
import modal
from support.simulated_swing import VERTICAL_SEED, End, drawn_scene, ended

NEW_SEED = 20261129
FULL_CIRCLE, BOTH, INCLINED = 24, 12, 24
"""Scenes of each kind in the set "new"."""

CIRCLE_WINDS = (4.0, 5.0, 6.0, 7.0, 8.0, 10.0, 12.0)
"""Wind speeds [m/s] of the set "circle", whose screenings must find the same onset."""

DRAWN = 22
DURATION, LONG = 2500.0, 30_000.0
"""Simulated time [s] of a run, and of one of a span of which no run has settled."""

STARTS = ((1.0, 0.05), (0.2, 0.0), (2.0, 0.3))
MORE_STARTS = ((0.5, 0.1), (4.0, 0.0))
"""Vertical seed in units of `VERTICAL_SEED`, and horizontal seed [m]; the set "circle" has both."""

CIRCLE = Path(__file__).parents[2] / "tests" / "literature" / "data" / "full_circle_350m.toml"

ALIKE = 0.25
"""Largest error of a state that is right."""

SETTLED, SETTLED_LONG, CALM = 0.05, 0.2, 0.01
"""Change of the amplitude above which a run is no reference; that of a long run, which may be
irregular; amplitude [m] of a span at rest."""

TWIST = 0.2
"""Difference of the twist [rad] below which two equilibria are the same."""


def full_circle_scene(draw: np.random.Generator, inclined: bool) -> gf.Scene:
    """Draw a span with a table over the full circle, a variation of full_circle_350m.toml."""
    like = gf.load_scene(CIRCLE)
    curve = like.aerodynamics
    length = draw.uniform(90.0, 360.0)
    mass = like.conductor.mass_per_length
    sag = draw.uniform(0.012, 0.03) * length
    angle = 180.0 * int(draw.integers(2)) + draw.uniform(-25.0, 25.0)
    turn = math.radians(angle - like.ice.attack_angle_deg)
    m2, m3 = like.ice.first_moments()
    lift, moment = draw.uniform(0.8, 1.6), draw.uniform(-1.0, 1.0)
    ratio = draw.uniform(0.003, 0.012)
    frequency = math.sqrt(9.81 / (8.0 * sag)) / 2.0
    values = {
        "span.length": length,
        "span.horizontal_tension": mass * 9.81 * length**2 / (8.0 * sag),
        "aerodynamics.lift": [lift * value for value in curve.lift],
        "aerodynamics.moment": [moment * value for value in curve.moment],
        "ice.attack_angle_deg": angle % 360.0,
        "ice.first_moment_x2": m2 * math.cos(turn) - m3 * math.sin(turn),
        "ice.first_moment_x3": m2 * math.sin(turn) + m3 * math.cos(turn),
        "damping.translation": {
            "low_ratio": ratio,
            "low_frequency": frequency,
            "high_ratio": ratio,
            "high_frequency": 2.0 * frequency,
        },
        "supports": {"left": {"kind": "rigid"}, "right": {"kind": "rigid"}},
        "wind.speed": draw.uniform(2.0, 12.0),
    }
    if inclined:
        values["span.height_difference"] = draw.uniform(0.05, 0.35) * length
    return like.with_values(values)


def inclined_scene(draw: np.random.Generator) -> gf.Scene:
    """Draw a scene of screening_table.py with supports at different heights."""
    scene = drawn_scene(draw)
    return scene.with_values(
        {"span.height_difference": draw.uniform(0.05, 0.35) * scene.span.length}
    )


def scenes_of(which: str) -> list[tuple[str, gf.Scene]]:
    """Scenes of a set, with their names."""
    if which == "circle":
        span = gf.load_scene(CIRCLE)
        return [(f"{wind:g} m/s", span.with_values({"wind.speed": wind})) for wind in CIRCLE_WINDS]
    if which != "new":
        draw = np.random.default_rng(int(which))
        return fixed_scenes() + [(f"drawn {k}", drawn_scene(draw)) for k in range(1, DRAWN + 1)]
    draw = np.random.default_rng(NEW_SEED)
    kinds = ["circle"] * FULL_CIRCLE + ["circle, inclined"] * BOTH + ["inclined"] * INCLINED
    return [
        (
            f"{kind} {number}",
            inclined_scene(draw)
            if kind == "inclined"
            else full_circle_scene(draw, "inclined" in kind),
        )
        for number, kind in enumerate(kinds, start=1)
    ]


def simulated_ends(
    scene: gf.Scene, starts: tuple[tuple[float, float], ...], duration: float
) -> list[End | str]:
    """Ends of the runs from all starts; a text where a run ends early."""
    wind = scene.wind.mean_speed
    speed = VERTICAL_SEED * wind / (2.0 * math.pi * modal.frequency_ratio(scene).vertical_hz)
    ends: list[End | str] = []
    for vertical, horizontal in starts:
        try:
            ends.append(ended(scene, -vertical * speed, horizontal, duration))
        except gf.SimulationError as error:
            ends.append(str(error).split(": ")[-1][:80])
    return ends


def largest(end: End | modal.StableState) -> float:
    """Largest amplitude [m]."""
    return max(end.vertical, end.horizontal, end.quarter)


def error_of(end: End, state: modal.StableState) -> float:
    """Relative difference of an end from a state; infinite between rest and motion."""
    if largest(end) < CALM or state.kind == "rest":
        is_same = largest(end) < CALM and state.kind == "rest"
        return 0.0 if is_same and abs(end.twist - state.mean_twist) < TWIST else math.inf
    names = ("vertical", "horizontal", "quarter")
    away = max(abs(getattr(end, name) - getattr(state, name)) for name in names)
    return away / max(largest(end), state.largest)


def sizes(of: End | modal.StableState) -> str:
    if largest(of) < CALM:
        twist = of.twist if isinstance(of, End) else of.mean_twist
        return f"rest {math.degrees(twist):.0f} deg"
    return f"{of.vertical:.3f}/{of.horizontal:.3f}/{of.quarter:.3f}"


def usable_ends(ends: list[End | str], largest_change: float) -> list[End]:
    """Ends of the runs that have settled."""
    return [
        end
        for end in ends
        if isinstance(end, End) and (end.change <= largest_change or largest(end) < CALM)
    ]


def known_ends(key: str, scene: gf.Scene, known: dict[str, Any]) -> list[End | str]:
    """Ends of the runs of a scene, from those known, or simulated."""
    starts = STARTS + MORE_STARTS if key.startswith("circle ") else STARTS
    ends: list[End | str] = []
    for name, duration, change in ((key, DURATION, SETTLED), (f"{key} long", LONG, SETTLED_LONG)):
        if name not in known:
            known[name] = [
                end if isinstance(end, str) else asdict(end)
                for end in simulated_ends(scene, starts, duration)
            ]
        ends = [end if isinstance(end, str) else End(**end) for end in known[name]]
        if usable_ends(ends, change):
            break
    return ends


def compared(name: str, scene: gf.Scene, ends: list[End | str]) -> tuple[str, str, list[float]]:
    """Row of the table, verdict, and errors of the moving ends."""
    wind = f"{scene.wind.mean_speed:.2f}"
    try:
        found = modal.screen(scene)
    except gf.SceneError as error:
        return f"| {name} | {wind} | | | | | refused: {error} |", "refused", []
    known = [state for state in found.states if state.kind != "not settled"]
    usable = usable_ends(ends, SETTLED) or usable_ends(ends, SETTLED_LONG)
    errors = [min((error_of(end, state) for state in known), default=math.inf) for end in usable]
    if found.risk == "undetermined" or not known:
        verdict = "unresolved"
    elif not usable:
        verdict = "no reference"
    else:
        verdict = "right" if max(errors) <= ALIKE else "miss"
    moving = [
        error
        for end, error in zip(usable, errors, strict=True)
        if largest(end) >= CALM and math.isfinite(error)
    ]
    shown = sorted({sizes(end) if isinstance(end, End) else end for end in ends})
    states = [sizes(state) + (" s" if state.is_simulated else "") for state in known]
    unreached = [
        state for state in known if usable and min(error_of(e, state) for e in usable) > ALIKE
    ]
    note = f", {len(unreached)} not reached" if unreached else ""
    worst = f" ({max(moving):.1%})" if moving else ""
    row = (
        f"| {name} | {wind} | {found.risk} | {'; '.join(states)} | {'; '.join(shown)} |"
        f" {found.seconds:.2f} | {verdict}{worst}{note} |"
    )
    return row, verdict, moving


def main() -> None:
    which = sys.argv[1]
    cache = Path(sys.argv[3]) if len(sys.argv) > 3 else None
    known = json.loads(cache.read_text()) if cache and cache.exists() else {}
    modal.screen(gf.load_scene("example3").with_values({"wind.speed": 1.0}))  # import now
    rows, verdicts, errors, times = [], [], [], []
    for name, scene in scenes_of(which):
        ends = known_ends(f"{which} {name}", scene, known)
        if cache:
            cache.write_text(json.dumps(known))
        row, verdict, moving = compared(name, scene, ends)
        print(row, file=sys.stderr, flush=True)
        rows.append(row)
        verdicts.append(verdict)
        errors += moving
        times += [float(row.split("|")[6])] if verdict != "refused" else []
    print(f"## {which}\n")
    print("| Scene | Wind, m/s | Risk | States | Simulated | CPU, s | Verdict |")
    print("|" + " --- |" * 7)
    print("\n".join(rows) + "\n")
    for verdict in ("right", "miss", "unresolved", "refused", "no reference"):
        print(f"- {verdict}: {verdicts.count(verdict)} of {len(verdicts)}")
    if errors:
        print(f"- error of moving states: median {np.median(errors):.1%}, worst {max(errors):.1%}")
    if which == "circle":
        begins = [modal.screen(scene).galloping_from for _, scene in scenes_of(which)]
        print(f"- galloping from {', '.join(f'{one:.4f}' for one in begins)} m/s")
    print(f"- CPU time: median {np.median(times):.2f} s, worst {max(times):.2f} s")


if __name__ == "__main__":
    main()
