"""MkDocs hook: run the notebooks of `examples/notebooks/` and make pages of them.

A notebook is a Python script with ``# %%`` cells. All are run in this process, each in a folder of
its own; an error in a cell ends the build. Each becomes a page with its outputs, and a file .ipynb.
"""

from __future__ import annotations

import ast
import base64
import contextlib
import io
import os
import re
import tempfile
import time as clock
from pathlib import Path
from typing import Any, NamedTuple

import nbformat
from mkdocs.structure.files import File, Files

FOLDER = Path(__file__).parents[1] / "examples" / "notebooks"
PLACE = "notebooks"
"""Folder of the pages in the site."""

CELL = re.compile(r"^# %%( \[markdown\])?[^\n]*\n", re.MULTILINE)


class Cell(NamedTuple):
    """A cell: text of its source, and whether it is Markdown."""

    source: str
    is_text: bool


def cells(script: str) -> list[Cell]:
    """Split a script at its ``# %%`` lines; comments of Markdown cells lose their marks."""
    parts = CELL.split(script)
    found = []
    for mark, source in zip(parts[1::2], parts[2::2], strict=True):
        text = source.strip("\n")
        if mark:
            text = re.sub(r"^# ?", "", text, flags=re.MULTILINE)
        found.append(Cell(text, bool(mark)))
    return found


def run(source: str, names: dict[str, Any], file: str) -> list[dict[str, str]]:
    """Run a code cell; return what it shows, each by its MIME type."""
    tree = ast.parse(source, file)
    last = tree.body.pop() if tree.body and isinstance(tree.body[-1], ast.Expr) else None
    printed, value = io.StringIO(), None
    with contextlib.redirect_stdout(printed):
        exec(compile(tree, file, "exec"), names)
        if isinstance(last, ast.Expr):
            value = eval(compile(ast.Expression(last.value), file, "eval"), names)
    shown = [{"text/plain": printed.getvalue().rstrip()}] if printed.getvalue() else []
    if value is not None:
        shown.append(bundle(value))
    return shown


def bundle(value: Any) -> dict[str, str]:
    """Return the richest view of an object that it offers: picture, HTML or text.

    Of xarray the text: its HTML brings its own style sheet, which a page does not keep.
    """
    if hasattr(value, "_repr_png_"):
        return {"image/png": base64.b64encode(value._repr_png_()).decode()}
    if hasattr(value, "_repr_html_") and not type(value).__module__.startswith("xarray"):
        return {"text/html": value._repr_html_()}
    return {"text/plain": repr(value)}


def page_of(name: str, script: str) -> tuple[str, dict[str, bytes], bytes]:
    """Run a notebook; return the page in Markdown, its pictures, and the notebook file."""
    lines: list[str] = []
    pictures: dict[str, bytes] = {}
    notebook = nbformat.v4.new_notebook()
    names: dict[str, Any] = {"__name__": "__main__"}
    for cell in cells(script):
        if cell.is_text:
            lines += [cell.source, ""]
            notebook.cells.append(nbformat.v4.new_markdown_cell(cell.source))
            continue
        outputs = run(cell.source, names, name)
        notebook.cells.append(
            nbformat.v4.new_code_cell(
                cell.source,
                outputs=[nbformat.v4.new_output("display_data", data=data) for data in outputs],
            )
        )
        if cell.source.startswith("assert "):
            continue  # a check for this build; the file has it
        lines += ["```python", cell.source, "```", ""]
        for data in outputs:
            if "image/png" in data:
                picture = f"{name}-{len(pictures) + 1}.png"
                pictures[picture] = base64.b64decode(data["image/png"])
                lines += [f"![Picture drawn by the cell above]({picture}){{ .figure }}", ""]
            elif "text/html" in data:
                html = re.sub(r"\n\s*\n", "\n", data["text/html"])
                lines += [f'<div class="output">{html}</div>', ""]
            else:
                lines += ["```text", data["text/plain"], "```", ""]
    lines.insert(1, f"\n[Download this notebook]({name}.ipynb)\n")
    return "\n".join(lines), pictures, nbformat.writes(notebook).encode()


def on_files(files: Files, config: Any, **_: Any) -> Files:
    """Add the pages, pictures and notebook files to the site."""
    home = Path.cwd()
    for path in sorted(FOLDER.glob("*.py")):
        began = clock.process_time()
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            try:
                page, pictures, notebook = page_of(path.stem, path.read_text(encoding="utf-8"))
            finally:
                os.chdir(home)
        contents = {f"{path.stem}.md": page.encode(), f"{path.stem}.ipynb": notebook, **pictures}
        for name, content in contents.items():
            files.append(File.generated(config, f"{PLACE}/{name}", content=content))
        if os.environ.get("NOTEBOOK_TIMES"):
            print(f"{path.stem}: {clock.process_time() - began:.1f} s of CPU time")
    return files
