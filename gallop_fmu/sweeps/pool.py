"""Where many runs are computed: threads or processes of this machine, or a Dask cluster, all behind one interface."""

from __future__ import annotations

import os
import time as clock
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ThreadPoolExecutor,
    wait,
)
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from multiprocessing import current_process
from typing import Any, Literal, TypeVar

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.version import program

Kind = Literal["threads", "processes"]
"""Threads for work that releases the interpreter lock, processes for work that holds it."""

AHEAD = 2
"""Groups handed over for each worker: one that it computes, and the next."""
CONNECTION_TIME = 20.0
"""Time [s] after which a cluster that does not answer is given up."""
LOST_TIME = 60.0
"""Time [s] after which a cluster without workers is given up."""
PROTOCOLS = ("tcp", "tls", "ws", "wss")
"""Protocols over which a Dask scheduler of another process can be reached."""
ONE_THREAD = {name: "1" for name in ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")}
"""Environment of a worker process: the processes share the cores, each needs no more than one."""

Item = TypeVar("Item")
Answer = TypeVar("Answer")


class WorkersLostError(RuntimeError):
    """The worker processes or the cluster are gone; what they had answered is kept."""


@dataclass(frozen=True)
class Workers:
    """Some workers, ready.

    Attributes
    ----------
    executor : concurrent.futures.Executor
        Takes the work.
    count : int
        How many there are.
    here : bool
        Whether they share this program's memory, and so can be told to stop.
    lost : callable
        Asked while no answer comes: the reason why none can come any more, or an empty text.
    """

    executor: Executor
    count: int
    here: bool
    lost: Callable[[], str] = str

    def answers(
        self, function: Callable[[Item], Answer], items: Iterable[Item]
    ) -> Iterator[tuple[Item, Answer | Exception]]:
        """Each item with its answer, or with what the function raised, as they come.

        Raises
        ------
        WorkersLostError
            If the workers are gone.
        """
        waiting: dict[Future[Answer], Item] = {}
        to_come = iter(items)
        try:
            while True:
                for item in to_come:
                    waiting[self.executor.submit(function, item)] = item
                    if len(waiting) >= AHEAD * self.count:
                        break
                if not waiting:
                    return
                # Waiting without a limit does not hear Ctrl-C on Windows.
                done = wait(waiting, timeout=0.5, return_when=FIRST_COMPLETED).done
                for future in done:
                    answer = _answer(future)
                    yield waiting.pop(future), answer
                if not done and (reason := self.lost()):
                    raise WorkersLostError(reason)
        except (BrokenExecutor, CancelledError) as problem:
            yield from _answered(waiting)
            raise WorkersLostError(_why_lost(problem)) from None
        finally:
            for future in waiting:
                future.cancel()


def _answer(future: Future[Any]) -> Any:
    """What the function returned or raised; what befell the workers themselves is raised here."""
    try:
        return future.result()
    except (BrokenExecutor, CancelledError):
        raise
    except Exception as problem:
        return problem


def _answered(waiting: dict[Future[Answer], Item]) -> Iterator[tuple[Item, Answer | Exception]]:
    """What was answered before the workers were lost; the loss may be seen first."""
    for future in filter(Future.done, list(waiting)):
        with suppress(BrokenExecutor, CancelledError):
            answer = _answer(future)
            yield waiting.pop(future), answer


def _why_lost(problem: BrokenExecutor | CancelledError) -> str:
    from loky.process_executor import TerminatedWorkerError

    if isinstance(problem, CancelledError):
        return "the connection to the cluster was lost"
    if isinstance(problem, TerminatedWorkerError):
        return "a worker process ended by itself; is there enough memory?"
    cause = (
        str(problem.__cause__ or "").strip('"\n').rpartition("\n")[2]
    )  # of the worker's traceback
    return f"the worker processes cannot go on: {problem}" + (f" ({cause})" if cause else "")


@contextmanager
def workers(kind: Kind, count: int | None = None, cluster: str | None = None) -> Iterator[Workers]:
    """Start workers, or connect to a cluster; they end, or are left, with the context.

    Parameters
    ----------
    kind
        What to start on this machine. Processes are replaced by one thread of this process for a
        `count` of 1, and where none can be started: in a daemonic process, such as a worker of
        Celery or of ``multiprocessing.Pool``, and on a system without the means for it.
    count
        How many; None takes one for each core.
    cluster
        Address of a Dask scheduler such as ``tcp://host:8786``, in place of workers here.

    Raises
    ------
    SceneError
        `count` below 1, or given together with `cluster`; a cluster that does not answer, has no
        workers, or runs another version of this package.
    """
    if count is not None and (isinstance(count, bool) or count < 1):
        raise SceneError(f"workers = {count}: must be a whole number, 1 or more")
    if cluster is not None:
        if count is not None:
            raise SceneError(
                f"workers = {count} and cluster = {cluster!r}: a cluster has its own workers;"
                " give one"
            )
        with _cluster(cluster) as found:
            yield found
        return
    count = count or cores()
    pool = _started(count) if kind == "processes" and count > 1 else None
    if pool is not None:
        with _ended(pool) as executor:
            yield Workers(executor, count, here=False)
        return
    count = count if kind == "threads" else 1
    with ThreadPoolExecutor(count, "sweep") as executor:
        yield Workers(executor, count, here=True)


def cores() -> int:
    """Number of cores that this program may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _started(count: int) -> Executor | None:
    """Processes, or None where they cannot be started."""
    # loky's processes, unlike the standard library's, do not run the user's script a second time.
    from loky import ProcessPoolExecutor

    if current_process().daemon:
        return None
    try:
        executor: Executor = ProcessPoolExecutor(
            count, env=ONE_THREAD, initializer=_ignore_interrupt
        )
        executor.submit(int)
    except (OSError, NotImplementedError):  # no semaphores, no shared memory, no more processes
        return None
    return executor


@contextmanager
def _ended(executor: Any) -> Iterator[Executor]:
    """Processes, which end with the context."""
    try:
        yield executor
    except BaseException:
        executor.shutdown(kill_workers=True)
        raise
    executor.shutdown()


def _ignore_interrupt() -> None:
    """Ctrl-C reaches every process of a terminal; the one that started the others deals with it."""
    import signal

    signal.signal(signal.SIGINT, signal.SIG_IGN)


@contextmanager
def _cluster(address: str) -> Iterator[Workers]:
    try:
        from distributed import Client
    except ImportError:
        raise SceneError(
            f'cluster = {address!r}: needs Dask; pip install "gallop-fmu[cluster]" here and on the'
            " workers"
        ) from None
    _check_address(address)
    try:
        client = Client(address, timeout=CONNECTION_TIME, set_as_default=False)
    except (OSError, ValueError) as problem:
        raise SceneError(
            f"cluster = {address!r}: no Dask scheduler answers there ({problem})"
        ) from None
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECTION_TIME)
        except TimeoutError:
            raise SceneError(
                f"cluster = {address!r}: the scheduler has no workers; start dask worker {address}"
            ) from None
        here = program()
        for worker, there in client.run(program, on_error="return").items():
            if there != here:
                raise SceneError(
                    f"cluster = {address!r}: {here} here, but {there} on the worker {worker}"
                )
        count = sum(client.nthreads().values())
        executor = client.get_executor(pure=False)
        try:
            yield Workers(executor, count, here=False, lost=_without_workers(client, address))
        finally:
            executor.shutdown(wait=False)  # cancels what has not begun


def _check_address(address: str) -> None:
    """Refuse an address on which Dask itself would wait, or end in an error that says nothing.

    Raises
    ------
    SceneError
        No port, another protocol, or a protocol that needs certificates which Dask does not know.
    """
    from distributed.security import Security

    protocol, _, place = address.rpartition("://")
    host, _, port = place.rpartition(":")
    if not (host and port.isdecimal() and 0 < int(port) < 65536 and protocol in ("", *PROTOCOLS)):
        raise SceneError(
            f"cluster = {address!r}: must be the address of a Dask scheduler with its port, such as"
            f" tcp://localhost:8786; protocols: {', '.join(PROTOCOLS)}"
        )
    if (
        protocol in ("tls", "wss")
        and Security().get_connection_args("client").get("ssl_context") is None
    ):
        raise SceneError(
            f"cluster = {address!r}: {protocol} needs certificates; name them in Dask's"
            " configuration (distributed.comm.tls), or use tcp"
        )


def _without_workers(client: Any, address: str) -> Callable[[], str]:
    """Whether a cluster has been without workers for too long."""
    last = clock.monotonic()

    def lost() -> str:
        nonlocal last
        now = clock.monotonic()
        # A client without its scheduler gives up by itself, which cancels what was handed over.
        if client.status != "running" or client.nthreads():
            last = now
        if now - last < LOST_TIME:
            return ""
        return f"the cluster has had no workers for {LOST_TIME:g} s; start dask worker {address}"

    return lost
