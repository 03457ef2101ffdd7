"""The report of the long runs: Markdown, and two pictures."""

from __future__ import annotations

from collections import Counter
from itertools import pairwise, product
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
import stability
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm
from stability import CYCLES, MESHES, STEPS, WINDS, Cycle, error, largest_step

from gallop_fmu.foundation.integrators import SPECTRAL_RADIUS
from gallop_fmu.foundation.outcome import MAX_STEP_ROTATION
from support.checks import AGREEMENT, CLOSED
from support.conservation import VERTICAL_HZ
from support.random_spans import FEWEST, MOST, STEEPEST

Data = dict[str, Any]

MAP, CURVES = "stability_map.png", "stability_cycles.png"
AXIAL = (0.0, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, np.inf)
"""Bounds of steps over axial periods by which the energy imbalance is sorted."""


def write(data: Data, folder: Path) -> None:
    """Write stability.md and the pictures of what there is into a folder."""
    folder.mkdir(exist_ok=True)
    parts = [INTRODUCTION]
    if "cycles" in data:
        cycles = [Cycle(**value) for value in data["cycles"]["values"]]
        parts.append(_cycles(cycles, folder))
    if "map" in data:
        parts.append(_map(data["map"]["values"], folder))
    if "scenes" in data:
        parts.append(_scenes(data["scenes"]))
    if "conservation" in data:
        parts.append(_conservation(data["conservation"]["values"], data["bits"]))
    lost = [
        text
        for part in ("cycles", "map", "conservation")
        for text in data.get(part, {}).get("lost", [])
    ]
    parts.append("\n".join(f"- lost: {text}" for text in lost))
    parts.append(f"Computed on {data['machine']}.")
    (folder / "stability.md").write_text(
        "\n\n".join(filter(None, parts)) + "\n", encoding="utf-8", newline="\n"
    )


INTRODUCTION = f"""# Stability

`python benchmarks/stress/run.py` writes this page. It shows which time steps are accurate, what
happens if the step is too long, and the results of a stress test on random spans.

Summary:

- Take 50 steps or more in a period of the galloping motion. Amplitudes are then within 1 % in all
  cases of the first table. Resonance of two modes needs the shortest steps.
- If the steps are too long, the run has a warning (`result.warnings`): more than one in a hundred
  had to be halved, or a section rotated by more than {MAX_STEP_ROTATION:g} rad within one. The run
  was completed, but its energy may be wrong. Reduce `numerics.time_step` until the warning
  disappears.
- `gallop_fmu.energy_balance(result)` compares the work of wind and supports with damping and
  stored energy. An imbalance above {CLOSED:.0%} of the energy turned over is too much. This check
  is more reliable than the warning, and costs more.
- What cannot be computed is refused with a reason: a cable that goes slack, an attack angle outside
  the coefficient curve, an equilibrium that does not exist. The results up to then are kept."""


def table(head: list[str], rows: list[list[str]]) -> str:
    """A Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _step(seconds: float) -> str:
    return f"{seconds:g} s"


def _cycles(cycles: list[Cycle], folder: Path) -> str:
    rows, kinds = [], list(dict.fromkeys(found.integrator for found in cycles))
    figure, axes = plt.subplots(
        1, len(kinds), figsize=(4.6 * len(kinds), 4.6), squeeze=False, layout="constrained"
    )
    for axis, kind in zip(axes[0], kinds, strict=True):
        for name in CYCLES:
            own = sorted(
                (c for c in cycles if (c.integrator, c.name) == (kind, name)), key=lambda c: c.step
            )
            reference = own[0]
            ended = [c for c in own if c.outcome != "completed"]
            halved = [c for c in own if c.halvings]
            steps = [largest_step(own, bound) for bound in (0.01, 0.05)]
            rows.append([
                kind, name, f"{reference.vertical:.3f} / {reference.horizontal:.3f} m",
                f"{reference.frequency:.3f} Hz",
                *(f"{_step(step)} ({1.0 / (reference.frequency * step):.0f} per period)"
                  for step in steps),
                _step(halved[0].step) if halved else "none",
                f"{_step(ended[0].step)}: {ended[0].outcome.replace('_', ' ')}" if ended
                else "none",
            ])  # fmt: skip
            errors = [100.0 * error(c, reference) for c in own[1:]]
            axis.loglog([c.step for c in own[1:]], errors, "o-", ms=4, label=name)
        for bound in (1.0, 5.0):
            axis.axhline(bound, color="0.6", lw=0.8, ls="--")
        axis.set(
            title=kind,
            xlabel="time step [s]",
            ylabel="error of the steady amplitude [%]",
            ylim=(1e-3, 200.0),
        )
        axis.grid(alpha=0.3, which="both")
        axis.legend(fontsize=8)
    figure.savefig(folder / CURVES, dpi=110)
    plt.close(figure)
    head = [
        "Integrator", "Limit cycle", "Vertical / horizontal amplitude", "Frequency",
        "Largest step within 1 %",
        "within 5 %", "First step halved at", "First early end at",
    ]  # fmt: skip
    return f"""## Time step and limit cycle

Steady amplitude over the last {stability.WINDOW:g} s of galloping with {stability.CYCLE_ELEMENTS}
elements, compared with steps of {1e3 * stability.CYCLE_STEPS[0]:g} ms. The horizontal amplitude
counts where it exceeds {stability.PARTNER:.0%} of the vertical one. "Within" means at this step and
at every shorter one tried; the longest was {stability.CYCLE_STEPS[-1]:g} s.

{table(head, rows)}

![Error of the steady amplitude over the time step]({CURVES})"""


def _map(cells: list[Data], folder: Path) -> str:
    kinds = list(dict.fromkeys(cell["integrator"] for cell in cells))
    figure, axes = plt.subplots(
        len(kinds), len(MESHES), figsize=(3.6 * len(MESHES), 0.6 + 3.4 * len(kinds)),
        squeeze=False, sharey=True,
        layout="constrained",
    )  # fmt: skip
    for row, kind in zip(axes, kinds, strict=True):
        for axis, mesh in zip(row, MESHES, strict=True):
            here = [
                cell for cell in cells if (cell["integrator"], cell["elements"]) == (kind, mesh)
            ]
            image = _panel(axis, here)
            axis.set(title=f"{kind}, {mesh} elements", xlabel="time step [s]")
        row[0].set_ylabel("wind speed [m/s]")
    figure.colorbar(image, ax=axes, label="energy imbalance over turnover", shrink=0.8)
    figure.savefig(folder / MAP, dpi=110)
    plt.close(figure)
    rows = []
    for kind in kinds:
        for mesh in MESHES:
            here = [
                cell for cell in cells if (cell["integrator"], cell["elements"]) == (kind, mesh)
            ]
            whole = _longest(
                here, lambda cell: cell["outcome"] == "completed" and cell["halved"] == 0.0
            )
            closed = _longest(
                here, lambda cell: cell["outcome"] == "completed" and cell["imbalance"] < CLOSED
            )
            ended = _longest(here, lambda cell: cell["outcome"] == "completed")
            early = Counter(
                cell["outcome"].replace("_", " ") for cell in here if cell["outcome"] != "completed"
            )
            said = ", ".join(f"{count} {name}" for name, count in early.items()) or "none"
            rows.append([kind, str(mesh), whole, closed, ended, said])
    start, longest, most = list(stability.START.values()), stability.LONGEST, stability.MOST
    head = [
        "Integrator", "Elements", "No step halved up to", f"Energy within {CLOSED:.0%} up to",
        "All runs end up to",
        f"Early ends of {len(STEPS) * len(WINDS)}",
    ]  # fmt: skip
    return f"""## Time step, wind and mesh

A rough start: example 3 (125.88 m, 15 kN) is released at rest from {start[0]} m up, {start[1]} m
across and {start[2]} rad, with the full wind at once, for {longest:g} s or {most:,}
steps. A start out of equilibrium releases axial waves, which long steps cannot resolve. In the
picture, a dot means that some steps were halved, a circled dot that more than a tenth were, and a
cross that the run ended early. The colour is the energy imbalance. "Up to" is the longest step
tried for which the statement is true at every wind speed.

{table(head, rows)}

![Outcome over time step and wind speed]({MAP})"""


def _longest(cells: list[Data], holds: Any) -> str:
    kept = None
    for step in STEPS:
        if not all(holds(cell) for cell in cells if cell["step"] == step):
            break
        kept = step
    return f"below {_step(STEPS[0])}" if kept is None else _step(kept)


def _panel(axis: Axes, cells: list[Data]) -> Any:
    value = np.full((len(WINDS), len(STEPS)), np.nan)
    for cell in cells:
        row, column = WINDS.index(cell["wind"]), STEPS.index(cell["step"])
        value[row, column] = max(cell["imbalance"], 1e-9)
        if cell["outcome"] != "completed":
            axis.plot(column, row, "x", color="black", ms=8)
        elif cell["halved"] > 0.0:
            axis.plot(column, row, ".", color="black", ms=4)
            if cell["halved"] > 0.1:
                axis.plot(column, row, "o", color="black", ms=8, fillstyle="none")
    image = axis.imshow(
        value, origin="lower", aspect="auto", norm=LogNorm(1e-6, 1.0), cmap="YlOrRd"
    )
    axis.set_xticks(range(len(STEPS)), [f"{step:g}" for step in STEPS], rotation=90, fontsize=8)
    axis.set_yticks(range(len(WINDS)), [f"{wind:g}" for wind in WINDS])
    return image


def _scenes(data: Data) -> str:
    runs, lost = data["values"], data["lost"]
    kinds = list(dict.fromkeys(run["integrator"] for run in runs))
    counts = Counter((run["outcome"].replace("_", " "), run["integrator"]) for run in runs)
    names = [
        name for name, _ in Counter(run["outcome"].replace("_", " ") for run in runs).most_common()
    ]
    outcomes = [[name, *(str(counts[name, kind]) for kind in kinds)] for name in names]
    outcomes += [["lost (crash or hang)", str(len(lost)), *[""] * (len(kinds) - 1)]] if lost else []
    completed = [run for run in runs if run["outcome"] == "completed"]
    moved = [run for run in runs if run["steps"] > 0]
    faults = [
        f"- {run['name']}, {run['integrator']}: {text}" for run in runs for text in run["faults"]
    ]
    faults += [f"- {text}" for text in lost]
    rows = []
    for kind, (low, high) in product(kinds, pairwise(AXIAL)):
        row = [kind, f"{low:g} to {high:g}"]
        own = [run for run in completed if run["integrator"] == kind and low <= run["axial"] < high]
        for step_too_long in (False, True):
            values = [run["imbalance"] for run in own if run["step_too_long"] == step_too_long]
            found = np.quantile(values, [0.5, 0.9, 1.0]) if values else []
            row += [str(len(values)), " / ".join(f"{value:.1e}" for value in found) or "-"]
        rows.append(row)
    head = [
        "Integrator",
        "Step over axial period",
        "Runs without warning",
        "Imbalance: median / 90 % / largest",
    ]
    head += ["Runs with warning", "Imbalance"]
    worst = max(moved, key=lambda run: run["tension_error"])
    memory = data["memory"]
    tenths = [np.median(part) for part in np.array_split(np.array(memory), 10)]
    spoken = "\n\n" + "\n".join(faults[:40]) if faults else " none"
    seconds = [run["seconds"] for run in runs]
    return f"""## Random spans

{len(runs) + len(lost):,} runs: {len({run["name"] for run in runs}):,} random spans with each
integrator. The spans are drawn by Latin hypercube sampling (seed {data["seed"]}):

- length 20-1,500 m, sag 0.2-12 %, level or with a height difference of up to {STEEPEST:g} of the
  length;
- wind 0-60 m/s: constant, jumps, gusts, waves, tables, ramps from and to calm, histories that begin
  and end at zero, and reversal through calm;
- ice up to three times the mass of the metal, at any side and any attack angle, with tables and
  cubics of coefficients;
- damping 0-10 %; ends rigid, sprung from 1 kN/m to 1 GN/m, or adjacent spans; moving towers; loads;
- 2-200 elements, steps 0.1-200 ms, starts at rest out of equilibrium.

Each run has {FEWEST} to {MOST} steps, fewer where many steps are halved, in a process of its
own, so that a crash or an endless loop does not affect the others.

{table(["Outcome", *kinds], outcomes)}

Checks of each run:

- all values are finite, and no recorded tension is below zero;
- no amplitude exceeds the span (largest: {max(run["amplitude"] for run in moved):.2f} spans);
- tensions agree with Hooke's law on the recorded elongations within {AGREEMENT:g} (worst:
  {worst["tension_error"]:.1e});
- the energy balance closes within {CLOSED:.0%} of the energy turned over, unless the run warns of
  too long steps. It compares the work of wind, loads and towers with dissipation and change of
  stored energy, over the steps as computed (halved steps in parts).

If the balance did not close, the run was repeated with steps of an eighth, then of a sixty-fourth.
If these balances close and the stored energy is the same, the balance of the long steps had missed
what wind and damping did within the steps. The generalised-alpha method dissipates unresolved
motion itself; no balance contains this part. Violations:{spoken}

{table(head, rows)}

Memory of a worker process, median in the first, second, fifth and last tenth of the runs:
{tenths[0]:.0f}, {tenths[1]:.0f}, {tenths[4]:.0f}, {tenths[-1]:.0f} MiB. The longest run
took {max(seconds):.1f} s, all runs {sum(seconds) / 60.0:.1f}
minutes of processor time."""


def _conservation(runs: list[Data], bits: Data) -> str:
    rows = [
        [
            run["integrator"], run["start"], f"{run['steps']:,}", f"{run['halvings']:,}",
            f"{run['first_tenth']:.1e}",
            f"{run['last_tenth']:.1e}", f"{run['loss']:+.1e}", f"{run['scatter']:.1e}",
            f"{run['way_back']:.1e}",
            f"{run['seconds']:.1f} s",
        ]
        for run in sorted(runs, key=lambda run: (run["start"] == "rough", run["integrator"]))
    ]  # fmt: skip
    head = [
        "Integrator", "Start", "Steps", "Halvings", "Energy error, first tenth", "last tenth",
        "Loss per period",
        "Scatter", "Way back", "Processor time",
    ]  # fmt: skip
    said = ", ".join(
        f"{name}: {'the same bits' if same else 'OTHER BITS'}" for name, same in bits.items()
    )
    return f"""## Energy conservation

Example 3 without wind and damping, with steps of 10 ms and a Newton tolerance of 1e-9 m.

- Energy error: largest relative error in the first and in the last tenth of the run.
- Loss per period: share of the energy lost per vertical period of {1.0 / VERTICAL_HZ:.2f} s
  (negative: gained). Scatter: deviation from this trend.
- "Smooth": loads are removed within half a second. "Rough": released at rest out of equilibrium, so
  that axial waves run.
- Way back: 20,000 steps of the smooth motion, then as many with reversed velocities; distance
  from the start over the distance travelled.

The generalised-alpha method is designed to dissipate unless its spectral radius is 1 (default:
{SPECTRAL_RADIUS}): motion that a step does not resolve decays, resolved motion hardly does.

{table(head, rows)}

Random spans computed again: {said}. A test
checks that FMU and Python give the same bits (`tests/native`)."""
