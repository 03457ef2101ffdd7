"""The command ``gallop-fmu demo``: example 3 of Liu, Yan, Zhang, Zhou (2009) as an FMU in fmpy."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gallop_fmu.foundation.atomic_write import check_target, netcdf_bytes, write_whole
from gallop_fmu.foundation.channels import DESCRIBED
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.version import program
from gallop_fmu.input.scene_files import load_scene
from gallop_fmu.scene.line_scene import one_span
from gallop_fmu.simulation.result import MOVES, Oscillation, oscillation
from gallop_fmu.simulation.steadiness import judge_span

if TYPE_CHECKING:
    import xarray as xr

START_VALUES = {"wind_speed": 5.5, "attack_angle": math.pi}
"""Wind speed [m/s] and initial attack angle [rad] of the paper's example 3."""

STOP_TIME = 900.0
COMMUNICATION_STEP = 0.05

WINDOWS = {"before": (490.0, 535.0), "during": (535.0, 615.0), "after": (855.0, 900.0)}
"""Parts of this run [s]: vertical galloping alone, transfer of energy, galloping with the swing."""

OUTPUTS = {
    "midspan.x2": "u2",
    "midspan.x3": "u3",
    "midspan.theta": "theta",
    "midspan.tension": "tension",
}
"""Recorded outputs of the FMU, and the names of the same channels in `gallop_fmu.simulate`."""

CAVEAT = (
    "The amplitudes are not an independent check of the paper: its figure of the aerodynamic"
    " coefficients is not available, and the curve used here was reconstructed to reproduce the"
    " printed course of events. The ratio of the frequencies follows from the mechanics."
)


def run_demo(
    folder: Path | str, progress: Callable[[float, float], object] | None = None
) -> list[str]:
    """Export example 3, run the FMU, write histories and a picture, and describe the motion.

    Parameters
    ----------
    folder
        Existing folder for ``example3.fmu``, ``example3.nc`` and ``example3.png``.
    progress
        Called with the time reached and the stop time [s]; returning False stops the run.

    Returns
    -------
    list of str
        Lines of text.

    Raises
    ------
    SceneError
        A file cannot be written, or fmpy cannot run the FMU.
    """
    from gallop_fmu.fmu import export_fmu
    from gallop_fmu.plots import save_figure, story

    histories, picture = (Path(folder) / f"example3{suffix}" for suffix in (".nc", ".png"))
    check_target(histories)
    check_target(picture)
    fmu = export_fmu(one_span(load_scene("example3"), "the demo"), Path(folder) / "example3.fmu")
    started = clock.perf_counter()
    records = _run_fmu(fmu, progress)
    seconds = clock.perf_counter() - started
    dataset = _dataset(records, seconds)
    write_whole(histories, netcdf_bytes(dataset))
    title = "Galloping excites a swing at half its frequency (coefficient curve reconstructed)"
    save_figure(story(dataset, WINDOWS, title), picture)
    return [*_description(dataset), "", *(f"wrote {path}" for path in (fmu, histories, picture))]


def _run_fmu(fmu: Path, progress: Callable[[float, float], object] | None) -> Any:
    """Run the FMU in fmpy and return its structured array of records."""
    import fmpy

    def step_finished(time: float, _recorder: object) -> bool:
        return progress is None or progress(time, STOP_TIME) is not False

    try:
        return fmpy.simulate_fmu(
            str(fmu),
            stop_time=STOP_TIME,
            output_interval=COMMUNICATION_STEP,
            start_values=START_VALUES,
            output=list(OUTPUTS),
            step_finished=step_finished,
        )
    except Exception as problem:  # fmpy raises plain exceptions
        raise SceneError(
            f"{fmu}: fmpy could not run it ({problem}); run gallop-fmu check {fmu}"
        ) from problem


def _dataset(records: Any, seconds: float) -> xr.Dataset:
    import fmpy
    import xarray as xr

    scene = load_scene("example3")
    variables = {
        name: (
            "time",
            np.array(records[output]),
            {
                "units": DESCRIBED[name].unit,
                "long_name": f"{DESCRIBED[name].meaning}; at mid-span",
                "fmu_variable": output,
            },
        )
        for output, name in OUTPUTS.items()
    }
    time = ("time", np.array(records["time"]), {"units": "s", "long_name": "time"})
    dataset = xr.Dataset(variables, {"time": time})
    histories = {title: dataset[name].values for name, title in MOVES.items()}
    return dataset.assign_attrs(
        title=scene.title,
        motion=str(judge_span(dataset.time.values, histories)),
        source=f"{program()} as an FMU in fmpy {fmpy.__version__}",
        communication_step=COMMUNICATION_STEP,
        **START_VALUES,
        seconds=seconds,
        scene=scene.to_toml(),
        comment=CAVEAT,
    )


def _description(dataset: xr.Dataset) -> list[str]:
    """Lines on the run before and after the transfer of energy to the swing."""
    seconds = dataset.attrs["seconds"]
    lines = [
        dataset.attrs["title"],
        f"an FMU in fmpy: {STOP_TIME:.0f} s in {seconds:.1f} s,"
        f" {STOP_TIME / seconds:.0f} times real time",
        "",
    ]
    for part in ("before", "after"):
        start, stop = WINDOWS[part]
        vertical, swing = (_oscillation(dataset, name, start, stop) for name in ("u2", "u3"))
        lines.append(
            f"{part} the transfer of energy ({start:.0f} to {stop:.0f} s):"
            f" vertical {vertical.text('m')} at {vertical.frequency_hz:.4f} Hz,"
            f" horizontal {swing.text('m')} at {swing.frequency_hz:.4f} Hz"
        )
    return [
        *lines,
        "frequency ratio, vertical to horizontal, after the transfer:"
        f" {vertical.frequency_hz / swing.frequency_hz:.3f}",
        f"motion at the end: {dataset.attrs['motion']}",
        "amplitudes are half peak-to-peak at mid-span",
        "",
        CAVEAT,
    ]


def _oscillation(dataset: xr.Dataset, name: str, start: float, stop: float) -> Oscillation:
    part = dataset[name].sel(time=slice(start - 1e-9, stop + 1e-9))
    return oscillation(part.values, COMMUNICATION_STEP, part.attrs["units"])
