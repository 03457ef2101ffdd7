"""Recording options: stop time, interval, nodes, channels."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.state import MAX_THREADS
from gallop_fmu.foundation.argument_checks import finite, indices, whole
from gallop_fmu.foundation.channels import NODE_INDEX, SPAN_INDEX
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.processors import cores, is_worker_process
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene

MAX_STEPS = 1e8
"""Maximum number of time steps of a run: 11 days in steps of 0.01 s."""
MAX_STRIDE = 1_000_000
"""Maximum number of time steps from one record to the next."""

SHARED_ELEMENTS = 400
"""Elements of a line from which a second thread pays (benchmarks/speed/line_threads.py)."""


@dataclass(frozen=True)
class RecordingPlan:
    """Times of the records of a run.

    Attributes
    ----------
    stop_time : float
        Simulated time [s]; the run ends at the first record at or after it.
    stride : int
        Number of time steps from one record to the next.
    interval : float
        Time [s] from one record to the next.
    count : int
        Number of records after the one at time 0.
    """

    stop_time: float
    stride: int
    interval: float
    count: int

    @classmethod
    def from_scene(
        cls, scene: Scene | LineScene, stop_time: float | None, stride: int | None
    ) -> RecordingPlan:
        """Return the plan for given options; None takes the value of the scene.

        Raises
        ------
        SceneError
            A number is not allowed.
        """
        stop_time = scene.run.stop_time if stop_time is None else stop_time
        stride = scene.run.record_every if stride is None else stride
        stop_time, stride = check_stop_time(stop_time), check_record_every(stride)
        step = scene.numerics.time_step
        interval = stride * step
        if interval > stop_time * (1.0 + 1e-9) and stride > 1:
            fits = int(stop_time / step + 1e-9)
            remedy = (
                f"at most {fits} steps of {step:g} s fit: give a smaller record_every"
                " (--record-every)"
            )
            if fits < 1:
                remedy = f"not one step of {step:g} s fits: give a longer stop time (--stop-time)"
            raise SceneError(
                f"record_every = {stride}: the first record would be at {interval:g} s, after the"
                f" end of the run at {stop_time:g} s; {remedy}"
            )
        if stop_time / step > MAX_STEPS:
            raise SceneError(
                f"stop_time = {stop_time:g} s is {stop_time / step:.3g} time steps of {step:g} s; a"
                f" run has at most {MAX_STEPS:.0e}: give a shorter time, or a longer"
                " numerics.time_step"
            )
        return cls(stop_time, stride, interval, max(1, math.ceil(stop_time / interval - 1e-9)))


def check_record_every(every: Any) -> int:
    """Return the number of steps between records; raise SceneError if it is not allowed."""
    try:
        return whole("record_every", None if isinstance(every, bool) else every, 1, MAX_STRIDE)
    except (TypeError, ValueError):
        raise SceneError(
            f"record_every = {every!r:.60}: must be a whole number of time steps, from 1 to"
            f" {MAX_STRIDE}"
        ) from None


def check_stop_time(stop_time: Any) -> float:
    """Return the stop time [s]; raise SceneError if it is not a positive number."""
    with suppress(TypeError, ValueError):
        seconds = finite("stop_time", stop_time)
        if seconds > 0.0:
            return seconds
    raise SceneError(f"stop_time = {stop_time!r:.60}: must be a positive number of seconds")


def check_channels(
    node: Sequence[str], others: Iterable[str], allowed: Mapping[str, int] = SPAN_INDEX
) -> None:
    """Raise SceneError if a channel does not exist, or no node channel is given.

    Parameters
    ----------
    node, others
        Names of node channels, and of others.
    allowed
        The other channels that exist: those of a span, or of a line.
    """
    unknown = [name for name in node if name not in NODE_INDEX]
    if unknown or not len(node):
        raise SceneError(f"channels {unknown} do not exist; choose from {', '.join(NODE_INDEX)}")
    unknown = [name for name in others if name not in allowed]
    if unknown:
        raise SceneError(f"span_channels {unknown} do not exist; choose from {', '.join(allowed)}")


def check_on_failure(on_failure: str) -> None:
    """Raise SceneError if the value is not one of the two allowed."""
    if on_failure not in ("raise", "return"):
        raise SceneError(f'on_failure = {on_failure!r}: must be "raise" or "return"')


def check_model(model: str) -> None:
    """Raise SceneError for a model other than the only one; release 0.1.0 had two."""
    if model == "condensed":
        raise SceneError(
            'model = "condensed": the condensed model was removed in 0.2.0, because its amplitudes'
            " were wrong without a warning on random spans; remove the option. For quick estimates"
            " of many spans use modal.screen_spans (gallop-modal screen --table ..."
            " --estimate-only)"
        )
    if model != "element":
        raise SceneError(f'model = {model!r}: must be "element"')


def chosen_threads(threads: Any, elements: int) -> int:
    """Return the number of threads of a run.

    Parameters
    ----------
    threads
        1 or 2; None takes 2 for `SHARED_ELEMENTS` or more, if this program may use two cores.
        Processes that `multiprocessing` has started share the cores with others, and get 1.
    elements
        Number of elements of the line.

    Raises
    ------
    SceneError
        The number is not allowed.
    """
    if threads is None:
        pays = elements >= SHARED_ELEMENTS and not is_worker_process()
        return min(MAX_THREADS, cores()) if pays else 1
    with suppress(TypeError, ValueError):
        return whole("threads", None if isinstance(threads, bool) else threads, 1, MAX_THREADS)
    raise SceneError(f"threads = {threads!r:.60}: must be 1 or {MAX_THREADS}")


def chosen_nodes(
    wanted: Literal["midspan", "all"] | Sequence[int], usual: NDArray[np.int32], count: int
) -> NDArray[np.int32]:
    """Return the numbers of the nodes to record.

    Parameters
    ----------
    wanted
        ``"midspan"``, ``"all"`` or node numbers.
    usual
        The nodes for ``"midspan"``.
    count
        Number of nodes of the model.

    Raises
    ------
    SceneError
        A node does not exist.
    """
    if isinstance(wanted, str):
        if wanted not in ("midspan", "all"):
            raise SceneError(f'record_nodes = {wanted!r}: must be "midspan", "all" or node numbers')
        return usual if wanted == "midspan" else np.arange(count, dtype=np.int32)
    with suppress(TypeError, ValueError, IndexError):
        nodes = indices("record_nodes", wanted, count)
        if len(nodes):
            return nodes
    raise SceneError(f"record_nodes = {wanted!r:.60}: must be node numbers from 0 to {count - 1}")
