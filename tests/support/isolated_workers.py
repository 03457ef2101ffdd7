"""Run tasks in worker processes: a crash or a hang is counted, and the rest continues."""

from __future__ import annotations

import multiprocessing as mp
import resource
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any

_CONTEXT = mp.get_context("spawn")


@dataclass
class Answer:
    """Outcome of a task: its value or how the worker was lost, and the worker's memory [MiB]."""

    task: Any
    value: Any = None
    lost: str = ""
    memory: float = 0.0


@dataclass
class _Worker:
    process: BaseProcess
    pipe: Connection
    task: Any
    until: float


def resident() -> float:
    """Memory of this process [MiB] that is in use now."""
    try:
        with open("/proc/self/statm", encoding="ascii") as text:
            return int(text.read().split()[1]) * resource.getpagesize() / 2**20
    except OSError:  # not Linux: the highest so far
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**10


def _serve(pipe: Connection, work: Callable[[Any], Any]) -> None:
    with suppress(EOFError, BrokenPipeError):  # the master is gone
        pipe.send("ready")
        while (task := pipe.recv()) is not None:
            try:
                value, lost = work(task), ""
            except Exception as error:  # what is not a typed outcome
                value, lost = None, f"exception {type(error).__name__}: {error}"
            pipe.send((value, lost, resident()))


def answers(
    work: Callable[[Any], Any], tasks: Iterable[Any], processes: int, limit: float
) -> Iterator[Answer]:
    """Yield answers in order of completion; a task above `limit` [s] counts as hanging."""
    waiting = iter(tasks)
    workers: list[_Worker] = []

    def give(process: BaseProcess, pipe: Connection) -> None:
        task = next(waiting, None)
        pipe.send(task)
        if task is None:
            process.join()
        else:
            workers.append(_Worker(process, pipe, task, time.monotonic() + limit))

    def hire() -> None:
        ours, theirs = _CONTEXT.Pipe()
        process = _CONTEXT.Process(target=_serve, args=(theirs, work), daemon=True)
        process.start()
        theirs.close()
        ours.recv()  # the time limit does not count what Python takes to start
        give(process, ours)

    for _ in range(processes):
        hire()
    while workers:
        ready = wait([worker.pipe for worker in workers], timeout=1.0)
        for worker in list(workers):
            if worker.pipe in ready:
                workers.remove(worker)
                try:
                    value, lost, memory = worker.pipe.recv()
                except EOFError:
                    worker.process.join()
                    yield Answer(worker.task, lost=f"crash, exit code {worker.process.exitcode}")
                    hire()
                    continue
                yield Answer(worker.task, value, lost, memory)
                give(worker.process, worker.pipe)
            elif time.monotonic() > worker.until:
                workers.remove(worker)
                worker.process.kill()
                worker.process.join()
                yield Answer(worker.task, lost=f"hang, not finished after {limit:g} s")
                hire()
