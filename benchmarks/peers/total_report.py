"""Tables, claims and picture of `total.py`, from its stored results."""

from __future__ import annotations

import json
import math
import textwrap
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
from analysis import Row, best_total, codes, cost_table, front
from cases import OURS
from picture import COLOURS

SCENES = {
    "example1": "Example 1, load step",
    "galloping": "Galloping span",
    "section": "Three spans on strings",
    "twin": "Twin bundle",
    "temporal": "Example 1: error in time, 41 nodes",
}
SETS = ("AVX2", "AVX-512")

ERRORS = {
    "total": (1e-2, 3e-3, 1e-3, 3e-4),
    "temporal": (1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7),
}
LEAST = {"total": 5.0, "temporal": 2.0}
"""How many times cheaper than every peer gallop-fmu claims to be."""

CANNOT = {
    "galloping": "MoorDyn has no lift.",
    "section": "OpenSees and MoorDyn have no twist and no lift; Radau is left out.",
    "twin": "OpenSees and MoorDyn have no twist and no lift; Radau is left out.",
}
LIMITS = {"total": (1e-4, 0.2), "temporal": (1e-9, 0.2)}


def report(folder: Path) -> None:
    """Print and write tables and claims, and draw the picture."""
    results = {
        instructions: {
            scene: json.loads(path.read_text(encoding="utf-8"))
            for scene in SCENES
            if (path := folder / f"total_{scene}_{instructions}.json").exists()
        }
        for instructions in SETS
    }
    results = {instructions: scenes for instructions, scenes in results.items() if scenes}
    parts = [f"# Cost over total error\n\n{caption(results)}"]
    for instructions, scenes in results.items():
        for name, found in scenes.items():
            kind = kind_of(name)
            parts.append(f"## {found['title']}, {instructions}")
            parts.append(table(found["rows"], kind))
            parts.append(claims(found["rows"], kind))
            parts += [CANNOT[name]] if name in CANNOT else []
    text = "\n\n".join(parts) + "\n"
    print(text)
    folder.joinpath("total.md").write_text(text, encoding="utf-8")
    draw(results, folder / "total_error")


def kind_of(scene: str) -> str:
    """Kind of the error of a scene."""
    return "temporal" if scene == "temporal" else "total"


def table(rows: list[Row], kind: str) -> str:
    """Markdown: cost of each code's best at each error."""
    return cost_table(
        rows,
        ERRORS[kind],
        f"{kind} error",
        lambda code, error: best_total(rows, code, error, kind),
    )


def claims(rows: list[Row], kind: str) -> str:
    """One line for each error: the ratio to the best peer, and if the claim holds."""
    lines = []
    for error in ERRORS[kind]:
        ours = best_total(rows, OURS, error, kind)
        peers = {code: best_total(rows, code, error, kind) for code in codes(rows) if code != OURS}
        code = min(peers, key=peers.__getitem__)
        ratio = peers[code] / ours if math.isfinite(ours) else math.nan
        holds = "holds" if ratio >= LEAST[kind] else "FAILS"
        lines.append(
            f"- {holds}: at {error:.0e} at least {LEAST[kind]:g} times cheaper than every peer"
            + (f" ({code}: {ratio:.2f} times)" if math.isfinite(ratio) else " (none reaches it)")
        )
    return "\n".join(lines)


def caption(results: dict[str, Any]) -> str:
    """Machine, instruction sets and versions."""
    about = next(iter(next(iter(results.values())).values()))["machine"]
    versions = ", ".join(f"{name} {number}" for name, number in about["versions"].items())
    return (
        "Least processor time of the time loop over meshes, steps and tolerances of each code, one"
        " core, least of interleaved repeats; start, compilation and building of the model"
        " excluded. Error: relative root mean square of mid-span u2 and u3 (the larger) against a"
        " chain of another program extrapolated to zero mesh size; on the right against the same"
        f" mesh converged in time. {about['date']}, {about['processor']}, {' and '.join(results)}"
        " (for AVX2 gallop-fmu has portable arithmetic, and numba compiles for AVX2 with fused"
        f" multiply-add), kernel {about['kernel']}; {versions}."
    )


def draw(results: dict[str, Any], path: Path) -> None:
    """Write `path`.svg and `path`.png: a row of diagrams for each instruction set."""
    figure, grid = plt.subplots(
        len(results), len(SCENES), figsize=(15.0, 4.1 * len(results)), sharey=True, squeeze=False
    )
    handles: dict[str, Any] = {}
    for row_of_axes, (instructions, scenes) in zip(grid, results.items(), strict=True):
        for axis, (name, title) in zip(row_of_axes, SCENES.items(), strict=True):
            if name in scenes:
                handles |= _fronts(axis, scenes[name]["rows"], kind_of(name))
            axis.set_title(f"{title}, {instructions}", loc="left", fontsize=9)
            axis.set_xlim(*LIMITS[kind_of(name)])
            axis.grid(True, which="major", color="0.85", linewidth=0.6)
        row_of_axes[0].set_ylabel("CPU seconds per simulated second")
    for axis, name in zip(grid[-1], SCENES, strict=True):
        axis.set_xlabel(f"{kind_of(name)} error [-]")
    bottom = 0.9 / (4.1 * len(results))
    figure.subplots_adjust(left=0.05, right=0.99, top=0.95, bottom=bottom * 1.75, wspace=0.06)
    figure.legend(
        handles.values(), handles.keys(), loc="lower left", ncols=len(handles), frameon=False,
        bbox_to_anchor=(0.04, bottom * 0.78),
    )  # fmt: skip
    text = "\n".join(textwrap.wrap(caption(results), 235))
    figure.text(0.05, 0.01, text, fontsize=7.5, va="bottom")
    figure.savefig(path.with_suffix(".png"), dpi=110)
    figure.savefig(path.with_suffix(".svg"), metadata={"Date": None})
    plt.close(figure)


def _fronts(axis: Any, rows: list[Row], kind: str) -> dict[str, Any]:
    """Draw all cases faintly, and the front of each code."""
    handles: dict[str, Any] = {}
    for code in codes(rows):
        points = [
            (max(row[kind]), row["cost"])
            for row in rows
            if row["code"] == code and row[kind] and row["cost"] is not None
        ]
        if not points:
            continue
        look = {"color": COLOURS[code]}
        axis.loglog(*zip(*points, strict=True), linestyle="", marker=".", alpha=0.25, **look)
        width = 2.2 if code == OURS else 1.2
        edge = front(points)
        (handles[code],) = axis.loglog(
            *zip(*edge, strict=True), marker="o", markersize=3.5, linewidth=width, **look
        )
    return handles
