"""The warnings of a run: everything that limits the trust in its numbers, in one list that every printer uses."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gallop_fmu.outcome import Report
from gallop_fmu.scene import Scene

if TYPE_CHECKING:
    import xarray as xr


def run_warnings(dataset: xr.Dataset, scene: Scene, report: Report) -> tuple[str, ...]:
    """Sentences, each with a fact and its remedy; empty if there is nothing to warn of.

    To add a kind of warning, write a function that returns a tuple of sentences and call it here.

    Parameters
    ----------
    dataset
        Recorded histories.
    scene
        What was computed.
    report
        How the run ended.
    """
    return (*scene.warnings, *report.warnings)
