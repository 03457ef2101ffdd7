"""The page documentation/index.html of an FMU: how to use it, its limits, and its variables."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import PurePosixPath

from gallop_fmu.fmu.enumerations import ENUMERATIONS
from gallop_fmu.fmu.reference import REFERENCE_FILE, Reference
from gallop_fmu.fmu.variable import TargetKind, Variable
from gallop_fmu.foundation.version import program

PAGE = "documentation/index.html"
"""Its name in the FMU, where FMI has it."""

STYLE = (
    "body{font-family:sans-serif;max-width:70em;margin:2em auto}"
    "td,th{text-align:left;padding:.1em .8em .1em 0;vertical-align:top}"
    "code{white-space:nowrap}pre{background:#eee;padding:.6em}"
)
GROUPS = {"input": "Inputs", "output": "Outputs", "parameter": "Parameters"}

EXAMPLE = """\
from fmpy import simulate_fmu

result = simulate_fmu(
    "name_of_this_file.fmu",
    stop_time=60.0,
    output_interval=0.05,
    start_values={{"{wind}": {speed:g}}},
)
print(max(result["{output}"]))
"""

LIMITS = (
    "The wind is quasi-steady: its forces follow from the coefficient curve and the relative wind"
    " of each instant.",
    "The cable has no bending stiffness.",
    "An input that a host gives at a communication point is reached one communication step later"
    " (towers), or holds over the step (wind, attack angle). With a harmonic tower motion of"
    " frequency f and a communication step h, this lag is {lag} of the amplitude at f = 0.3 Hz and"
    " h = 0.01 s: 2 sin(pi f h). Derivatives of inputs (FMI 2.0 only), or the inputs of the towers'"
    " velocities, remove most of it.",
    "A communication step that is shorter than the one before does not make a tower move faster:"
    " in the time of the longer step after its end, its point goes on at its last velocity, or the"
    " given one, and what is missing to its new place takes the rest of that time. Steps of equal"
    " or growing size end at the given place.",
    "Error of the force on a tower with modes of 2.5 and 8 Hz, of its peak, in communication steps"
    " of random size up to 20 ms: below 1 % for masters that iterate or use Gauss-Seidel order, and"
    " for Jacobi masters that give velocities; 2.5 % for Jacobi masters without. Up to 50 ms: 0.9 %"
    " (iterated), 3.4 % (Gauss-Seidel), 4.4 % and 6.3 % (Jacobi with velocities and without).",
    "Thickness, shape and density of the ice and the name of the conductor are no parameters: mass,"
    " moments, stiffness and coefficients follow from them when a scene is made. Set"
    " ice.mass_per_length, ice.torsional_inertia, ice.first_moment_x2 and x3 (and the curve, if it"
    " is the assumed one, by a new export), or make a scene with gallop-fmu new and export it.",
    "{temperature}",
    "Outputs do not react to inputs before the next step, except while initialising.",
    "A step that cannot be computed returns an error, and the state is that before the step; the"
    " log has the cause and a remedy, and status its number.",
)
TEMPERATURES = {
    "span": "The temperature of a single span is no parameter: its sag or tension is that with ice,"
    " at the temperature of the scene. Set span.sag or span.horizontal_tension, or export again.",
    "line": "The temperature of a line is the parameter section.temperature_deg_c if the scene has"
    " conductor.thermal_expansion. Tension and sag follow from it and from the mass of the ice.",
}
LAG = f"{2.0 * math.sin(math.pi * 0.3 * 0.01):.1%}"

WIDTH, HEIGHT, MARGIN = 720.0, 240.0, 44.0
"""Size of the plot and of its margin [px]."""

COLOURS = ("#D55E00", "#0072B2")


def documentation(
    title: str,
    description: str,
    variables: Iterable[Variable],
    reference: Reference | None = None,
) -> bytes:
    """Return the page.

    Parameters
    ----------
    title, description
        Texts of the model description.
    variables
        The table of variables.
    reference
        The reference result, of which the page has a plot; None: none.
    """
    rows = list(variables)
    is_line = any(one.name.startswith("section.") for one in rows)
    temperature = TEMPERATURES["line" if is_line else "span"]
    parts = [
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">',
        f"<title>{escape(title)}</title><style>{STYLE}</style></head><body>",
        f"<h1>{escape(title)}</h1><p>{escape(description)}</p><p>{escape(program())}</p>",
        *_ports(rows),
        *_example(rows),
        *(_reference(reference) if reference is not None else ()),
        "<h2>Limits</h2>\n<ul>",
        *(f"<li>{escape(limit.format(lag=LAG, temperature=temperature))}" for limit in LIMITS),
        "</ul>",
    ]
    for causality, heading in GROUPS.items():
        parts.append(f"<h2>{heading}</h2>\n<table>")
        parts.append("<tr><th>name<th>unit<th>start<th>bounds<th>meaning</tr>")
        parts += [_row(one) for one in rows if one.causality == causality]
        parts.append("</table>")
    for name in dict.fromkeys(one.enumeration for one in rows if one.enumeration):
        parts.append(f"<h2>Values of {escape(name)}</h2>\n<table>")
        parts += [
            f"<tr><td>{item.value}<td>{escape(item.name)}<td>{escape(item.description)}</tr>"
            for item in ENUMERATIONS[name]
        ]
        parts.append("</table>")
    parts.append("</body></html>\n")
    return "\n".join(parts).encode()


def tower_ports(variables: Sequence[Variable]) -> dict[str, list[Variable]]:
    """Return the inputs and outputs of each tower by its name, in the order of the table.

    They are the motion that the host gives, and the force on the tower.
    """
    towers = dict.fromkeys(
        variable.name.rpartition(".")[0]
        for variable in variables
        if variable.targets and variable.targets[0].kind is TargetKind.MOTION
    )
    return {
        tower: [
            variable
            for variable in variables
            if variable.name.rpartition(".")[0] == tower and variable.causality != "parameter"
        ]
        for tower in towers
    }


def _ports(variables: Sequence[Variable]) -> list[str]:
    """Table of what is connected at each tower."""
    parts = ["<h2>Ports</h2>\n<table><tr><th>tower<th>from the tower model<th>to it</tr>"]
    for tower, members in tower_ports(variables).items():
        cells = (
            ", ".join(one.name.rpartition(".")[2] for one in members if one.causality == causality)
            for causality in ("input", "output")
        )
        parts.append(f"<tr><td><code>{tower}</code>" + "".join(f"<td>{c}" for c in cells) + "</tr>")
    parts.append("</table><p>A tower that nothing is connected to does not move.</p>")
    return parts


def _example(variables: Sequence[Variable]) -> list[str]:
    wind = variables[0]
    output = next(one.name for one in variables if one.name.endswith("midspan.x2"))
    code = EXAMPLE.format(wind=wind.name, speed=wind.start, output=output)
    return [f"<h2>Example</h2>\n<pre>{escape(code)}</pre>"]


def _reference(reference: Reference) -> list[str]:
    """Plot of the vertical and horizontal motion of the first mid-span."""
    file = PurePosixPath(REFERENCE_FILE).name
    text = (
        f'<a href="{file}">{file}</a> has all Real outputs with the inputs at their start values,'
        f" in communication steps of {reference.step:g} s."
    )
    parts = [f"<h2>Reference result</h2>\n<p>{text}</p>"]
    if reference.problem:
        parts.append(f"<p>The run ended early: {escape(reference.problem)}</p>")
    first = next((n for n in reference.names if n.endswith("midspan.x2")), None)
    if first is None or len(reference.rows) < 2:
        return parts
    names = (first, first[:-1] + "3")
    columns = [reference.column(name) for name in names]
    low, high = min(map(min, columns)), max(map(max, columns))
    across = (WIDTH - 2.0 * MARGIN) / (len(reference.rows) - 1)
    up = (HEIGHT - 2.0 * MARGIN) / ((high - low) or 1.0)
    parts.append(f'<svg width="{WIDTH:g}" height="{HEIGHT:g}" font-size="12" role="img">')
    parts.append(
        f'<rect x="{MARGIN:g}" y="{MARGIN:g}" width="{WIDTH - 2.0 * MARGIN:g}"'
        f' height="{HEIGHT - 2.0 * MARGIN:g}" fill="none" stroke="#999"/>'
    )
    for name, column, colour, place in zip(names, columns, COLOURS, (0.0, 1.0), strict=True):
        points = " ".join(
            f"{MARGIN + k * across:.1f},{HEIGHT - MARGIN - (value - low) * up:.1f}"
            for k, value in enumerate(column)
        )
        parts.append(f'<polyline points="{points}" fill="none" stroke="{colour}"/>')
        at = MARGIN + place * 0.5 * WIDTH
        parts.append(f'<text x="{at:g}" y="{MARGIN - 10:g}" fill="{colour}">{name} (m)</text>')
    last = (len(reference.rows) - 1) * reference.step
    for x, y, label in (
        (2.0, MARGIN + 10.0, f"{high:.2g}"),
        (2.0, HEIGHT - MARGIN, f"{low:.2g}"),
        (MARGIN, HEIGHT - MARGIN + 16.0, "0 s"),
        (WIDTH - MARGIN - 20.0, HEIGHT - MARGIN + 16.0, f"{last:g} s"),
    ):
        parts.append(f'<text x="{x:g}" y="{y:g}">{label}</text>')
    return [*parts, "</svg>"]


def _row(variable: Variable) -> str:
    start = "" if variable.start is None else f"{variable.start:.6g}"
    cells = (variable.unit, start, variable.allowed, variable.description)
    text = "".join(f"<td>{escape(cell)}" for cell in cells)
    return f"<tr><td><code>{escape(variable.name)}</code>{text}</tr>"
