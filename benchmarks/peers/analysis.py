"""From measured points to curves, costs at a given error, and the claims."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
from cases import OURS

Row = dict[str, Any]
"""One case of the results: code, family, setting, cost, temporal and total error of u2 and u3."""

ERRORS = tuple(10.0**exponent for exponent in range(-2, -8, -1))


def error_of(row: Row, kind: str) -> float | None:
    """The larger of the errors of u2 and u3; None where not asked for or not reached."""
    return max(row[kind]) if row.get(kind) else None


def curves(rows: list[Row], kind: str) -> dict[str, list[tuple[float, float]]]:
    """Family to its points (error, cost), from the largest error to the least."""
    found: dict[str, list[tuple[float, float]]] = defaultdict(list)
    for row in rows:
        error = error_of(row, kind)
        if error is not None and math.isfinite(error) and row["cost"] is not None:
            found[row["family"]].append((error, row["cost"]))
    return {family: sorted(points, reverse=True) for family, points in found.items()}


def cost_at(points: list[tuple[float, float]], error: float) -> float:
    """Lowest cost [CPU s per simulated s] of a curve within an error, or infinity.

    Between two points log cost is linear in log error; nothing is extrapolated.
    """
    costs = [cost for found, cost in points if found <= error]
    for (coarse, cheap), (fine, expensive) in pairwise(points):
        if fine < error < coarse:
            share = math.log(error / coarse) / math.log(fine / coarse)
            costs.append(math.exp(math.log(cheap) + share * math.log(expensive / cheap)))
    return min(costs, default=math.inf)


def best(rows: list[Row], code: str, error: float) -> float:
    """Least cost of any curve of a code at a temporal error."""
    found = curves([row for row in rows if row["code"] == code], "temporal")
    return min((cost_at(points, error) for points in found.values()), default=math.inf)


def best_total(rows: list[Row], code: str, error: float, kind: str = "total") -> float:
    """Least cost [CPU s per simulated s] of a code within an error, on any mesh, or infinity.

    Between neighbours of the front of all its cases log cost is linear in log error.
    """
    points = [
        (max(row[kind]), row["cost"])
        for row in rows
        if row["code"] == code and row[kind] and row["cost"] is not None
    ]
    return cost_at(front(points), error)


def front(points: list[tuple[float, float]]) -> list[tuple[float, float]]:
    """Points (error, cost) that no other beats in both, from the largest error to the least."""
    found: list[tuple[float, float]] = []
    for error, cost in sorted(points):
        if not found or cost < found[-1][1]:
            found.append((error, cost))
    return found[::-1]


def codes(rows: list[Row]) -> list[str]:
    return list(dict.fromkeys(row["code"] for row in rows))


def cost_table(
    rows: list[Row], errors: Sequence[float], what: str, best_at: Callable[[str, float], float]
) -> str:
    """Markdown: cost [CPU ms per simulated s] of each code's best at each error, over ours."""
    names = codes(rows)
    lines = [f"| {what} | " + " | ".join(names) + " |", "| ---: |" + " ---: |" * len(names)]
    for error in errors:
        ours = best_at(OURS, error)
        cells = []
        for code in names:
            cost = best_at(code, error)
            if not math.isfinite(cost):
                cells.append("not reached")
            elif code == OURS or not math.isfinite(ours):
                cells.append(f"{1e3 * cost:.3g}")
            else:
                cells.append(f"{1e3 * cost:.3g} ({cost / ours:.2g} x)")
        lines.append(f"| {error:.0e} | " + " | ".join(cells) + " |")
    return "\n".join(lines)


def temporal_table(rows: list[Row]) -> str:
    """Markdown: cost of each code's best at each error in time."""
    return cost_table(rows, ERRORS, "temporal error", lambda code, error: best(rows, code, error))


def case_table(rows: list[Row]) -> str:
    """Markdown: every case."""
    lines = [
        (
            "| curve | setting | CPU ms per simulated s | greatest / least "
            "| temporal error u2 | u3 | total error u2 | u3 |"
        ),
        "| --- | --- | ---: | ---: | ---: | ---: | ---: | ---: |",
    ]
    for row in rows:
        errors = [*(row["temporal"] or ("", "")), *(row["total"] or ("", ""))]
        cells = [f"{error:.1e}" if error != "" else "" for error in errors]
        cost = (
            ""
            if row["cost"] is None
            else f"{1e3 * row['cost']:.3g} | {max(row['all']) / min(row['all']):.2f}"
        )
        lines.append(
            f"| {row['family']} | {row['setting']} | {cost or row['failure'] + ' | '} |"
            f" {' | '.join(cells)} |"
        )
    return "\n".join(lines)


def claims(rows: list[Row]) -> str:
    """Each claim about example 1 at 41 nodes, with the ratio that decides it.

    Where a peer does not reach an error, its cost is at least that of its finest setting, so the
    claim holds there.
    """
    lines = []
    for error in ERRORS:
        ours = best(rows, OURS, error)
        peers = {code: best(rows, code, error) for code in codes(rows) if code != OURS}
        code = min(peers, key=peers.__getitem__)
        ratio = peers[code] / ours if math.isfinite(ours) else math.nan
        text = (
            f"at {error:.0e} cheaper than every peer (next is {code}: {ratio:.2f} times our cost)"
        )
        lines.append((ratio > 1.0, text))
    for code, least in (("OpenSees", 30.0), ("CVODE", 3.0), ("Radau", 3.0)):
        ratio = best(rows, code, 1e-3) / best(rows, OURS, 1e-3)
        lines.append(
            (
                ratio >= least,
                f"at 1e-03 at least {least:g} times cheaper than {code}: {ratio:.2f} times",
            )
        )
    return "\n".join(f"- {'holds' if holds else 'FAILS'}: {text}" for holds, text in lines)


def relative_rms(found: Any, expected: Any) -> list[float]:
    """Relative root mean square of u2 and u3 over the run."""
    difference = np.mean((np.asarray(found) - expected) ** 2, axis=0)
    return np.sqrt(difference / np.mean(np.asarray(expected) ** 2, axis=0)).tolist()
