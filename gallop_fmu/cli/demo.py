"""The demonstration: example 3 of Liu, Yan, Zhang, Zhou (2009) runs as an FMU until galloping wakes the swing."""

from __future__ import annotations

import math
import signal
import threading
import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.foundation.atomic_write import check_target, netcdf_bytes, write_whole
from gallop_fmu.foundation.channels import NODE_CHANNELS, NODE_INDEX
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.version import program
from gallop_fmu.input.scene_files import load_scene
from gallop_fmu.simulation.result import MOVES, Oscillation, oscillation
from gallop_fmu.simulation.run_warnings import fastest_motion, step_warnings
from gallop_fmu.simulation.steadiness import dominant_frequency, judge_span

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

WIND_SPEED = 5.5
"""Wind speed [m/s] of the paper's Example 3."""

ATTACK_ANGLE = math.pi
"""Initial attack angle [rad] of the paper's Example 3."""

STOP_TIME = 900.0
COMMUNICATION_STEP = 0.05
OUTPUTS = {
    "midspan.x2": "u2",
    "midspan.x3": "u3",
    "midspan.theta": "theta",
    "midspan.v2": "v2",
    "midspan.v3": "v3",
    "midspan.tension": "tension",
}
"""Outputs of the FMU that are recorded, and the names of the same channels in `gallop_fmu.simulate`."""

PERIODS_PER_BLOCK = 3.0
BLOCKS_SHOWN = 5
AWAKE, SETTLED = 0.15, 0.05
"""The transfer begins when the swing passes this share of its final amplitude, and ends when both motions stay within
this share of theirs."""

HALF_FREQUENCY_TOLERANCE = 0.02

CAVEAT = (
    "Read with care: the paper's figure of the aerodynamic coefficients is not available to us. The"
    " curve used here is a reconstruction, chosen within that figure's axes to reproduce the"
    " printed course of events, so the amplitudes are no independent check of the paper. That the"
    " swing has half the vertical frequency follows from the mechanics."
)


@dataclass(frozen=True, slots=True)
class Transfer:
    """Passage of energy from the vertical motion to the horizontal swing, found in the histories.

    Attributes
    ----------
    time
        Time [s] at which the swing reaches half of its final amplitude.
    before, during, after
        Start and end [s] of the vertical-only plateau, of the transfer, and of the new steady
        motion.
    """

    time: float
    before: tuple[float, float]
    during: tuple[float, float]
    after: tuple[float, float]

    @property
    def windows(self) -> dict[str, tuple[float, float]]:
        """The three parts of the run by name."""
        return {"before": self.before, "during": self.during, "after": self.after}


def find_transfer(time: Array, u2: Array, u3: Array) -> Transfer:
    """Find when the swing wakes, from the envelopes of the vertical and horizontal motion alone.

    Parameters
    ----------
    time, u2, u3 : ndarray, shape (time,)
        Equally spaced times [s], and vertical and horizontal displacement [m] at mid-span.

    Raises
    ------
    SceneError
        If the run does not end in a swing at half the vertical frequency, or began with it.
    """
    interval = float(time[1] - time[0])
    last = len(time) * 3 // 4
    vertical, swing = (
        dominant_frequency(u2[last:], interval),
        dominant_frequency(u3[last:], interval),
    )
    if (
        not abs(0.5 * vertical / swing - 1.0) <= HALF_FREQUENCY_TOLERANCE
    ):  # nor is NaN, where one of them is still
        raise SceneError(
            f"no transfer found: the run ends with {vertical:.3f} Hz vertical and {swing:.3f} Hz"
            " horizontal, and the swing would have half the vertical frequency; simulate longer,"
            " or raise the wind speed"
        )
    size = round(PERIODS_PER_BLOCK / (swing * interval))
    starts, high, wide = _envelopes(time, u2, u3, size)
    asleep = np.flatnonzero(wide < AWAKE * wide[-1])
    if not BLOCKS_SHOWN < len(asleep) or asleep[-1] + 2 * BLOCKS_SHOWN > len(wide):
        raise SceneError(
            "no transfer found: the run has no part before or after it; simulate longer"
        )
    begin = int(asleep[-1]) + 1
    unsettled = (np.abs(wide / wide[-1] - 1.0) > SETTLED) | (
        np.abs(high / high[-1] - 1.0) > SETTLED
    )
    end = int(np.flatnonzero(unsettled)[-1]) + 1
    half = begin + int(np.argmax(wide[begin:] >= 0.5 * wide[-1]))
    length = size * interval
    return Transfer(
        time=float(starts[half] + 0.5 * length),
        before=(float(starts[begin] - BLOCKS_SHOWN * length), float(starts[begin])),
        during=(float(starts[begin]), float(starts[min(end, len(starts) - 1)])),
        after=(float(time[-1] - BLOCKS_SHOWN * length), float(time[-1])),
    )


def _envelopes(time: Array, u2: Array, u3: Array, size: int) -> tuple[Array, Array, Array]:
    """Start times of blocks of `size` samples, the last of which ends with the run, and half peak-to-peak in each."""
    first = len(time) % size
    blocks = [np.ptp(values[first:].reshape(-1, size), axis=1) / 2.0 for values in (u2, u3)]
    return time[first::size], blocks[0], blocks[1]


@dataclass(frozen=True)
class Demonstration:
    """What the demonstration computed.

    Attributes
    ----------
    dataset : xarray.Dataset
        Mid-span histories u2, u3 [m], theta [rad], v2, v3 [m/s] and tension [N] over time [s], with
        provenance.
    transfer : Transfer
        When the energy passed to the swing.
    seconds : float
        Wall-clock time [s] of the FMU's run.
    files : dict
        What was written: ``fmu``, ``histories`` and ``picture``.
    """

    dataset: xr.Dataset
    transfer: Transfer
    seconds: float
    files: dict[str, Path]

    @property
    def real_time_factor(self) -> float:
        """Simulated time per wall-clock time."""
        return float(self.dataset.time[-1]) / self.seconds

    def oscillation(self, channel: str, part: Literal["before", "during", "after"]) -> Oscillation:
        """Amplitude, mean and frequency of a channel before, during or after the transfer."""
        start, stop = self.transfer.windows[part]
        cut = self.dataset[channel].sel(time=slice(start - 1e-9, stop + 1e-9))
        return oscillation(cut.values, COMMUNICATION_STEP, cut.attrs["units"])

    def text(self) -> str:
        """What happened, in a few lines."""
        return "\n".join(
            [
                self.dataset.attrs["title"],
                (
                    f"an FMU in fmpy: {float(self.dataset.time[-1]):.0f} s in {self.seconds:.1f} s,"
                    f" {self.real_time_factor:.0f} times real time"
                ),
                "",
                self._line("before"),
                (
                    f"at {self.transfer.time:.0f} s the swing wakes and takes energy from the"
                    " vertical motion"
                ),
                self._line("after"),
                (
                    "frequency ratio, vertical to horizontal, after the transfer:"
                    f" {self.frequency_ratio:.3f}"
                ),
                f"motion at the end: {self.dataset.attrs['motion']}",
                *(f"warning: {sentence}" for sentence in self.warnings),
                "amplitudes are half peak-to-peak at mid-span",
                "",
                CAVEAT,
                "",
                *(f"wrote {path}" for path in self.files.values()),
            ]
        )

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences on what limits the trust in the numbers."""
        moves = [
            [self.dataset[name].values for name in names] for names in (("u2", "u3"), ("v2", "v3"))
        ]
        fastest = fastest_motion(COMMUNICATION_STEP, *moves)
        return step_warnings(load_scene("example3"), fastest, COMMUNICATION_STEP)

    @property
    def frequency_ratio(self) -> float:
        """Vertical frequency per horizontal frequency after the transfer."""
        return (
            self.oscillation("u2", "after").frequency_hz
            / self.oscillation("u3", "after").frequency_hz
        )

    def _line(self, part: Literal["before", "after"]) -> str:
        start, stop = self.transfer.windows[part]
        motions = [
            f"{name} {found.text('m')} at {found.frequency_hz:.4f} Hz"
            for name, channel in (("vertical", "u2"), ("horizontal", "u3"))
            for found in [self.oscillation(channel, part)]
        ]
        return f"{part} ({start:.0f} to {stop:.0f} s): {', '.join(motions)}"


def run_demo(
    folder: Path | str,
    *,
    runtime: Literal["native", "python"] = "native",
    stop_time: float = STOP_TIME,
    progress: Callable[[float, float], object] | None = None,
) -> Demonstration:
    """Export example 3, run the FMU with fmpy, find the transfer, and write FMU, histories and picture.

    Parameters
    ----------
    folder
        Existing folder to write into.
    runtime
        Passed to `gallop_fmu.export_fmu`.
    stop_time
        Simulated time [s].
    progress
        Called with the time reached and the stop time [s].

    Raises
    ------
    SceneError
        If no transfer of energy is found in the run.
    """
    from gallop_fmu.fmu import export_fmu
    from gallop_fmu.plots import save_figure, story

    folder = Path(folder)
    for suffix in (".nc", ".png"):
        check_target(folder / f"example3{suffix}")
    scene = load_scene("example3")
    fmu = export_fmu(scene, folder / "example3.fmu", runtime=runtime)
    started = clock.perf_counter()
    records = _run_fmu(fmu, stop_time, progress)
    seconds = clock.perf_counter() - started
    dataset = _dataset(records, fmu, seconds)
    transfer = find_transfer(dataset.time.values, dataset.u2.values, dataset.u3.values)
    write_whole(folder / "example3.nc", netcdf_bytes(dataset))
    figure = story(
        dataset,
        transfer.windows,
        "Galloping wakes a swing at half its frequency (coefficient curve reconstructed)",
    )
    files = {
        "fmu": fmu,
        "histories": folder / "example3.nc",
        "picture": save_figure(figure, folder / "example3.png"),
    }
    return Demonstration(dataset, transfer, seconds, files)


def _run_fmu(fmu: Path, stop_time: float, progress: Callable[[float, float], object] | None) -> Any:
    """Run the FMU with fmpy; the structured array that fmpy records."""
    import fmpy

    with _interrupt_held_back() as interrupted:

        def step_finished(time: float, _recorder: object) -> bool:
            return not interrupted and (progress is None or progress(time, stop_time) is not False)

        try:
            records = fmpy.simulate_fmu(
                str(fmu),
                stop_time=stop_time,
                output_interval=COMMUNICATION_STEP,
                start_values={"wind_speed": WIND_SPEED, "attack_angle": ATTACK_ANGLE},
                output=list(OUTPUTS),
                step_finished=step_finished,
            )
        except (
            Exception
        ) as problem:  # fmpy raises plain exceptions for all that can go wrong with an FMU
            raise SceneError(
                f"{fmu}: fmpy could not run it ({problem}); see what `gallop-fmu check` finds"
            ) from problem
    if interrupted:
        raise KeyboardInterrupt
    return records


@contextmanager
def _interrupt_held_back() -> Iterator[list[int]]:
    """Collect Ctrl-C for the end of a step: inside the FMU's Python it would look like a fatal error of the FMU."""
    received: list[int] = []
    if threading.current_thread() is not threading.main_thread():
        yield received  # only the main thread is interrupted
        return
    usual = signal.signal(signal.SIGINT, lambda number, _frame: received.append(number))
    try:
        yield received
    finally:
        signal.signal(signal.SIGINT, usual)


def _dataset(records: Any, fmu: Path, seconds: float) -> xr.Dataset:
    import fmpy
    import xarray as xr

    described = fmpy.read_model_description(str(fmu))
    scene = load_scene("example3")
    variables = {}
    for output, name in OUTPUTS.items():
        channel = NODE_CHANNELS[NODE_INDEX[name]]
        attrs = {
            "units": channel.unit,
            "long_name": f"{channel.meaning}; at mid-span",
            "fmu_variable": output,
        }
        variables[name] = ("time", np.array(records[output]), attrs)
    dataset = xr.Dataset(
        variables,
        {"time": ("time", np.array(records["time"]), {"units": "s", "long_name": "time"})},
    )
    histories = {title: dataset[name].values for name, title in MOVES.items()}
    dataset.attrs.update(
        title=scene.title,
        motion=str(judge_span(dataset.time.values, histories)),
        source=f"{program()} as an FMU in fmpy {fmpy.__version__}",
        fmu=fmu.name,
        fmu_guid=described.guid,
        generation_tool=described.generationTool or "",
        communication_step=COMMUNICATION_STEP,
        wind_speed=WIND_SPEED,
        attack_angle=ATTACK_ANGLE,
        seconds=seconds,
        scene=scene.to_toml(),
        comment=CAVEAT,
    )
    return dataset
