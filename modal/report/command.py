"""The command ``gallop-modal report``."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from gallop_fmu.cli.terminal import (
    Changes,
    Exit,
    SceneName,
    StopTime,
    check_output,
    chosen_spec,
    complain,
    complain_of,
    new_console,
    progress_bar,
)

if TYPE_CHECKING:
    from modal.report.findings import Progress

REPORT_EXAMPLE = "gallop-modal report example3 -o report.html"


def report(
    scene: SceneName,
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="FILE", help="File to write (.html).")
    ],
    stop_time: StopTime = None,
    changes: Changes = None,
) -> None:
    """Write an HTML report on a span or line: modes, risk, critical winds, simulation, clearance.

    Of a line it has a verdict, pictures, tables of spans, strings, towers, clearances, modes and
    resonant pairs, and the scene.

    Items that could not be computed are listed with the reason. If the simulation ends early, or
    cannot start, the report is still written, and the exit code is 1.
    """
    from gallop_fmu.scene.line_scene import LineScene
    from modal.report.findings import Findings, Missing, examine
    from modal.report.line_findings import LineFindings, examine_line
    from modal.report.page import SUFFIXES, write_page

    chosen = chosen_spec(scene, changes).scene()
    complain_of(chosen, "gallop-modal")
    check_output(out, SUFFIXES)
    with shown_parts(chosen.title) as shown:
        findings: Findings | LineFindings
        if isinstance(chosen, LineScene):
            findings = examine_line(chosen, stop_time, shown)
        else:
            findings = examine(chosen, stop_time, shown)
        if shown:
            shown("page", 0.0)
        write_page(findings, out)
    new_console().print(f"wrote {out} ({out.stat().st_size / 1e6:.2f} MB)", soft_wrap=True)
    if not findings.completed:
        result = findings.result
        ended = result.reason if isinstance(result, Missing) else str(result.report)
        complain(f"{ended} The report shows the results up to then.", "gallop-modal")
        raise typer.Exit(Exit.ENDED_EARLY)


@contextmanager
def shown_parts(title: str) -> Iterator[Progress | None]:
    """Show the current part, and the share of it that is done, on a progress bar."""
    with progress_bar(title) as bar:
        if bar is None:
            yield None
            return
        task, current = bar.add_task("starting", total=None), ""

        def show(name: str, share: float) -> None:
            nonlocal current
            if name != current:
                bar.reset(task, total=None, description=name)
                current = name
            bar.update(task, completed=share, total=1.0 if share > 0.0 else None)

        yield show
