"""The warnings of a run: everything that limits the trust in its numbers, in one list that every printer uses."""

from __future__ import annotations

from typing import TYPE_CHECKING

from gallop_fmu.laws import TimeTable
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
    return (*scene.warnings, *report.warnings, *_not_covered(scene, float(dataset.time[-1])))


def _not_covered(scene: Scene, stop_time: float) -> tuple[str, ...]:
    """Histories of the scene that end before the run, or begin after its start."""
    laws = {"wind.history": scene.wind.history}
    laws |= {f"loads.{number}.law": load.law for number, load in enumerate(scene.loads)}
    for end in ("left", "right"):
        motion = getattr(scene.supports, end).motion
        if motion is not None:
            laws |= {f"supports.{end}.motion.{axis}": getattr(motion, axis) for axis in ("x1", "x2", "x3")}
    found = []
    for name, law in laws.items():
        if not isinstance(law, TimeTable):
            continue
        covered = max(0.0, min(law.time[-1], stop_time) - max(law.time[0], 0.0))
        if covered < stop_time * (1.0 - 1e-9):
            found.append(
                f"{name} covers {covered:.6g} s of the {stop_time:.6g} s, from {law.time[0]:.6g} to "
                f"{law.time[-1]:.6g} s; its first and last values are held outside. Give a history of the whole run, "
                "with times in seconds from its start."
            )
    return tuple(found)
