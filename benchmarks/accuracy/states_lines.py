"""Compare the states of `modal.screen` of lines with long simulations; print a Markdown table.

Usage: python benchmarks/accuracy/states_lines.py SEED [--cache FILE]
       python benchmarks/accuracy/states_lines.py times

SEED draws 20 sections of three spans with single conductors, 6 spans with twin bundles and 4
sections of two spans with twin bundles. Conductor, ice, curve, damping and wind are those of
`tests/support/simulated_swing.py`; the spans of a section have different lengths and heights. About
six minutes on one core; with a cache, simulations are not repeated.

The nonlinear model starts with four different disturbances, which are not the same in all spans,
and runs for 2000 s, with a finer mesh and other time steps than the simulations of the screening.
The last third of a run must end in one of the stable states of the screening. The error is the
largest difference of an amplitude in any span (u2 and u3 at mid-span, antisymmetric u2 at the
quarter points), of a clamp or of the rotation of a bundle, as a displacement of its conductors,
relative to the largest amplitude.
"""

from __future__ import annotations

import json
import math
import sys
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

import gallop_fmu as gf
import modal
from gallop_fmu.scene.line_scene import LineScene
from support.simulated_swing import drawn_scene

SECTIONS, TWIN_SPANS, TWIN_SECTIONS = 20, 6, 4
"""Scenes of each kind."""

FIVE_SPANS, QUADS, TIMES_SEED = 6, 4, 5
"""Scenes whose times "times" prints: sections of five spans, quad bundles; their seed."""

ELEMENTS, TIME_STEP, DURATION = 10, 0.02, 2000.0
"""Elements of a span without spacers, time step [s] and simulated time [s] of a run."""

ALIKE, SETTLED, CALM = 0.25, 0.1, 0.01
"""Largest error of a state that is right; change of the largest amplitude above which a run is no
reference; amplitude [m] of a line at rest."""

PARTS = ("vertical", "horizontal", "quarter", "clamp", "turned")


@dataclass(frozen=True)
class LineEnd:
    """End of a long run: amplitudes [m] in each span and of each clamp, in the last third.

    ``turned`` is the rotation of a bundle times its radius, half the distance of its conductors.

    ``change`` is the relative change of the largest amplitude from the middle third to the last,
    ``beat`` the largest variation of amplitudes within the last third, relative to the largest.
    """

    vertical: list[float]
    horizontal: list[float]
    quarter: list[float]
    clamp: list[float]
    turned: list[float]
    change: float
    beat: float


def drawn_line(draw: np.random.Generator, spans: int, subconductors: int) -> LineScene:
    """Draw a section, or a span, of single conductors or bundles."""
    like = drawn_scene(draw)
    values = like.model_dump(mode="json", exclude_none=True)
    length = like.span.length
    parts: dict[str, object] = {
        name: values[name] for name in ("conductor", "ice", "wind", "aerodynamics", "damping")
    }
    lengths = [length * draw.uniform(0.85, 1.15) for _ in range(spans)]
    rises = [length * draw.uniform(-0.05, 0.05) for _ in range(spans)]
    string = {
        "kind": "string",
        "length": draw.uniform(1.5, 3.0),
        "weight": draw.uniform(300.0, 900.0),
    }
    parts["section"] = {
        "horizontal_tension": like.span.horizontal_tension,
        "strung_with_ice": True,
        "spans": [
            {"length": one, "height_difference": rise}
            for one, rise in zip(lengths, rises, strict=True)
        ],
        "suspensions": [string] * (spans - 1),
    }
    if subconductors > 1:
        parts["bundle"] = {
            "subconductors": subconductors,
            "spacing": draw.uniform(0.3, 0.5),
            "spacers": 3,
            "clamp_torsional_stiffness": draw.uniform(200.0, 800.0),
        }
    parts["numerics"] = {"elements": ELEMENTS, "time_step": TIME_STEP}
    return LineScene.from_dict(parts | {"title": f"{spans} spans"})


def scenes_of(seed: int) -> list[tuple[str, LineScene]]:
    """Lines of a seed, with their names."""
    draw = np.random.default_rng(seed)
    kinds = [("section", 3, 1)] * SECTIONS + [("twin span", 1, 2)] * TWIN_SPANS
    kinds += [("twin section", 2, 2)] * TWIN_SECTIONS
    return [
        (f"{name} {number}", drawn_line(draw, spans, subconductors))
        for number, (name, spans, subconductors) in enumerate(kinds, start=1)
    ]


def push(span: int, newtons: float, start: float = 5.0) -> dict[str, object]:
    """Force at 0.3 of a span for half a second, up and with the wind."""
    law = {"kind": "pulse", "peak": 1.0, "start": start, "rise": 0.25,
           "fall_start": start + 0.25, "fall": 0.25}  # fmt: skip
    return {"force": [0.0, newtons, newtons], "position": 0.3, "span": span, "law": law}


def starts(scene: LineScene) -> list[dict[str, object]]:
    """Disturbances of the runs: small, large, in one span, spans against each other."""
    spans = len(scene.section.spans)
    modes = modal.natural_modes(scene, 12)
    hertz = next(mode.frequency_hz for mode in modes if mode.family == "vertical")
    speed = 0.15 * scene.wind.mean_speed / (2.0 * math.pi * hertz)
    alternating = [push(k, 300.0 * (-1.0) ** k) for k in range(1, spans + 1)]
    return [
        {"initial.seed_vertical": -speed, "initial.seed_horizontal": 0.05,
         "loads": [push(1, 20.0)]},
        {"initial.seed_vertical": -0.1 * speed, "loads": [push(spans, 20.0)]},
        {"initial.seed_vertical": -2.0 * speed, "initial.seed_horizontal": 0.3,
         "loads": [push((spans + 1) // 2, 100.0)]},
        {"loads": alternating},
    ]  # fmt: skip


def simulated_ends(scene: LineScene) -> list[LineEnd | str]:
    """Ends of the runs from all starts; a text where a run ends early."""
    ends: list[LineEnd | str] = []
    for start in starts(scene):
        try:
            ends.append(ended(scene.with_values(start)))
        except gf.SimulationError as error:
            ends.append(shortened(str(error)))
    return ends


def shortened(reason: str) -> str:
    """Reason for which a run ended early, in few words."""
    if "attack angle" in reason:
        return "attack angle leaves the curve"
    if "slack" in reason:
        return "the cable goes slack"
    return reason.split(" What to do")[0][-80:]


def ended(scene: LineScene) -> LineEnd:
    """Simulate a line."""
    from gallop_fmu.engine.pack import map_of

    line = map_of(scene)
    nodes = [c.nearest_node(s) for c in line.chains for s in (0.25, 0.5, 0.75)]
    result = gf.simulate(scene, stop_time=DURATION, record_every=8, record_nodes=nodes)
    data, bundles = result.dataset, line.spans * line.phases
    shape = (len(data.time), bundles, line.subconductors, 3)
    u2, u3 = (data[name].values.reshape(shape).mean(axis=2) for name in ("u2", "u3"))
    clamps = np.zeros((len(data.time), 0))
    if "string_lean_across" in data:
        length = scene.section.suspensions[0].length
        leans = data.string_lean_across.isel(tower=slice(1, line.spans)).values
        clamps = length * np.sin(leans.reshape(len(data.time), -1))
    turned = np.zeros((len(data.time), 0))
    if line.subconductors == 2:  # one beside the other, with constant distance
        heights = data.u2.values.reshape(shape)[:, :, :, 1]
        turned = 0.5 * (heights[:, :, 0] - heights[:, :, 1])
    parts = (u2[:, :, 1], u3[:, :, 1], 0.5 * (u2[:, :, 0] - u2[:, :, 2]), clamps, turned)
    t = data.time.values
    late = t > DURATION * 2.0 / 3.0
    before = (t > DURATION / 3.0) & ~late
    sizes, earlier = ([half(one[part]) for one in parts] for part in (late, before))
    largest, past = (
        max(float(np.max(one, initial=0.0)) for one in found) for found in (sizes, earlier)
    )
    beats = [
        np.ptp([half(piece) for piece in np.array_split(one[late], 20)], axis=0).max(initial=0.0)
        for one in parts
    ]
    scale = max(largest, 1e-3)
    return LineEnd(
        *(one.tolist() for one in sizes), abs(largest - past) / scale, max(beats) / scale
    )


def half(values: np.ndarray) -> np.ndarray:
    """Half peak-to-peak of each column."""
    return 0.5 * np.ptp(values, axis=0)


def largest(end: LineEnd | modal.LineState) -> float:
    """Largest amplitude [m]."""
    return max(max(amplitudes(end, name), default=0.0) for name in PARTS)


def amplitudes(of: LineEnd | modal.LineState, part: str) -> list[float]:
    """Amplitudes [m] of a part of the motion."""
    if part == "turned" and isinstance(of, modal.LineState):
        return [of.radius * math.sin(one) for one in of.rotation] if of.radius else []
    return list(getattr(of, part))


def error_of(end: LineEnd, state: modal.LineState) -> float:
    """Relative difference of an end from a state; infinite between rest and motion."""
    if largest(end) < CALM or state.kind == "rest":
        return 0.0 if largest(end) < CALM and state.kind == "rest" else math.inf
    away = max(
        abs(a - b)
        for name in PARTS
        for a, b in zip(amplitudes(end, name), amplitudes(state, name), strict=True)
    )
    return away / max(largest(end), largest(state))


def sizes(of: LineEnd | modal.LineState) -> str:
    """Amplitudes of all spans as a text: u2 / u3 / antisymmetric u2, clamps, rotation."""
    if largest(of) < CALM:
        return "rest"
    spans = zip(of.vertical, of.horizontal, of.quarter, strict=True)
    text = " ".join("/".join(f"{value:.2f}" for value in one) for one in spans)
    more = [*of.clamp, *amplitudes(of, "turned")]
    return f"{text}{', ' if more else ''}{' '.join(f'{value:.2f}' for value in more)}"


def compared(
    name: str, scene: LineScene, ends: list[LineEnd | str]
) -> tuple[str, str, list[tuple[float, bool]], float]:
    """Row of the table, verdict, errors of the moving ends with True if periodic, and time."""
    wind = f"{scene.wind.mean_speed:.2f}"
    try:
        found = modal.screen(scene)
    except gf.SceneError as error:
        return f"| {name} | {wind} | | | | | refused: {error} |", "refused", [], math.nan
    known = [state for state in found.states if state.kind != "not settled"]
    usable = [
        end
        for end in ends
        if isinstance(end, LineEnd) and (end.change <= SETTLED or largest(end) < CALM)
    ]
    errors = [min((error_of(end, state) for state in known), default=math.inf) for end in usable]
    says_so = any("ended early" in one for one in found.unresolved)
    if all(isinstance(end, str) for end in ends) and says_so:
        verdict = "both end early"
    elif found.risk == "undetermined" or not known:
        verdict = "unresolved"
    elif not usable:
        verdict = "no reference"
    elif max(errors) <= ALIKE:
        verdict = "right"
    elif all(largest(end) < CALM for end in usable):
        verdict = "false alarm"
    else:
        verdict = "missed"
    moving = [
        (error, end.beat <= 0.05)
        for end, error in zip(usable, errors, strict=True)
        if largest(end) >= CALM and math.isfinite(error)
    ]
    shown = list(dict.fromkeys(sizes(end) if isinstance(end, LineEnd) else end for end in ends))
    states = [sizes(state) + (" b" if state.kind == "beating" else "") for state in known]
    far = [s for s in known if usable and min(error_of(e, s) for e in usable) > ALIKE]
    note = f", {len(far)} not reached" if far else ""
    worst = f" ({max(moving)[0]:.1%})" if moving else ""
    row = (
        f"| {name} | {wind} | {found.risk} | {'; '.join(states)} | {'; '.join(shown)} |"
        f" {found.seconds:.2f} | {verdict}{worst}{note} |"
    )
    return row, verdict, moving, found.seconds


def print_times() -> None:
    """Print the CPU times of screenings of larger lines."""
    draw = np.random.default_rng(TIMES_SEED)
    modal.screen(drawn_line(draw, 1, 1))  # import now
    for name, spans, subconductors, count in (
        ("five spans", 5, 1, FIVE_SPANS),
        ("quad", 1, 4, QUADS),
    ):
        lines = [drawn_line(draw, spans, subconductors) for _ in range(count)]
        times = sorted(modal.screen(line).seconds for line in lines)
        shown = ", ".join(f"{one:.2f}" for one in times)
        print(f"{name}: median {np.median(times):.2f} s of {shown}")


def main() -> None:
    which = sys.argv[1]
    if which == "times":
        print_times()
        return
    cache = Path(sys.argv[3]) if len(sys.argv) > 3 else None
    known = json.loads(cache.read_text()) if cache and cache.exists() else {}
    rows, verdicts, errors, times = [], [], [], []
    for name, scene in scenes_of(int(which)):
        key = f"{which} {name}"
        if key not in known:
            known[key] = [
                end if isinstance(end, str) else asdict(end) for end in simulated_ends(scene)
            ]
            if cache:
                cache.write_text(json.dumps(known))
        ends = [end if isinstance(end, str) else LineEnd(**end) for end in known[key]]
        row, verdict, moving, seconds = compared(name, scene, ends)
        print(row, file=sys.stderr, flush=True)
        rows.append(row)
        verdicts.append(verdict)
        errors += moving if verdict == "right" else []
        times.append(seconds)
    print(f"## Lines, {which}\n")
    print("| Scene | Wind, m/s | Risk | States | Simulated | CPU, s | Verdict |")
    print("|" + " --- |" * 7)
    print("\n".join(rows) + "\n")
    for verdict in (
        *("right", "both end early", "missed", "false alarm"),
        *("unresolved", "refused", "no reference"),
    ):
        print(f"- {verdict}: {verdicts.count(verdict)} of {len(verdicts)}")
    for word, periodic in (("periodic", True), ("beating", False)):
        those = [error for error, is_periodic in errors if is_periodic == periodic]
        if those:
            size = f"median {np.median(those):.1%}, worst {max(those):.1%}"
            print(f"- error of {word} ends of right lines: {size}")
    print(f"- CPU time: median {np.nanmedian(times):.2f} s, worst {np.nanmax(times):.2f} s")


if __name__ == "__main__":
    main()
