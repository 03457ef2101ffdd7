"""The page documentation/index.html of an FMU: what it is, and its variables."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

from gallop_fmu.fmu.variable import Variable
from gallop_fmu.foundation.version import program

PAGE = "documentation/index.html"
"""Its name in the FMU, where FMI 2.0 has it."""

STYLE = (
    "body{font-family:sans-serif;max-width:70em;margin:2em auto}"
    "td,th{text-align:left;padding:.1em .8em .1em 0;vertical-align:top}"
    "code{white-space:nowrap}"
)
GROUPS = {"input": "Inputs", "output": "Outputs", "parameter": "Parameters"}


def documentation(title: str, description: str, variables: Iterable[Variable]) -> bytes:
    """Return the page.

    Parameters
    ----------
    title, description
        Texts of the model description.
    variables
        The table of variables.
    """
    rows = list(variables)
    parts = [
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8">',
        f"<title>{escape(title)}</title><style>{STYLE}</style></head><body>",
        f"<h1>{escape(title)}</h1><p>{escape(description)}</p><p>{escape(program())}</p>",
    ]
    for causality, heading in GROUPS.items():
        parts.append(f"<h2>{heading}</h2>\n<table>")
        parts.append("<tr><th>name<th>unit<th>start<th>bounds<th>meaning</tr>")
        parts += [_row(one) for one in rows if one.causality == causality]
        parts.append("</table>")
    parts.append("</body></html>\n")
    return "\n".join(parts).encode()


def _row(variable: Variable) -> str:
    start = "" if variable.start is None else f"{variable.start:.6g}"
    cells = (variable.unit, start, variable.allowed, variable.description)
    text = "".join(f"<td>{escape(cell)}" for cell in cells)
    return f"<tr><td><code>{escape(variable.name)}</code>{text}</tr>"
