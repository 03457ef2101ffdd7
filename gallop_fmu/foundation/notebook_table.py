"""Tables in HTML, by which objects show themselves in notebooks."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from html import escape

_NUMBER = re.compile(r"-|[-+]?[\d.].*")
"""A cell that is aligned right: a number, perhaps with more behind it, or a dash."""


def notebook_table(
    title: str, columns: Sequence[str], rows: Iterable[Sequence[str]], notes: Iterable[str] = ()
) -> str:
    """Return a table with a title above it and a paragraph for each note below; texts are escaped.

    Parameters
    ----------
    columns
        Heads. A column is aligned right if all its cells are numbers.
    rows
        Cells of each row.
    """
    body = [list(row) for row in rows]
    sides = [
        "right" if k and all(_NUMBER.fullmatch(row[k]) for row in body) else "left"
        for k in range(len(columns))
    ]
    lines = "".join(_row("td", sides, row) for row in body)
    below = "".join(f"<p>{escape(note)}</p>" for note in notes)
    return (
        f"<b>{escape(title)}</b><table><thead>{_row('th', sides, columns)}</thead>"
        f"<tbody>{lines}</tbody></table>{below}"
    )


def _row(tag: str, sides: Sequence[str], cells: Sequence[str]) -> str:
    aligned = (
        f"<{tag} style='text-align:{side}'>{escape(cell)}</{tag}>"
        for side, cell in zip(sides, cells, strict=True)
    )
    return f"<tr>{''.join(aligned)}</tr>"
