"""Workers: threads or processes of this machine, or a Dask cluster, behind one interface."""

from __future__ import annotations

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
from gallop_fmu.foundation.processors import cores
from gallop_fmu.foundation.version import program

Kind = Literal["threads", "processes"]
"""Threads for work that releases the interpreter lock, processes for work that holds it."""

ITEMS_PER_WORKER = 2
"""Items submitted for each worker: one that it computes, and the next."""
CONNECTION_TIMEOUT = 20.0
"""Time [s] to wait for the answer of a cluster."""
LOST_TIMEOUT = 60.0
"""Time [s] to wait for a worker of a cluster that has lost all."""
PROTOCOLS = ("tcp", "tls", "ws", "wss")
"""Protocols over which a Dask scheduler of another process can be reached."""

Item = TypeVar("Item")
Answer = TypeVar("Answer")


class WorkersLostError(RuntimeError):
    """The worker processes or the cluster are gone; their earlier answers are kept."""


@dataclass(frozen=True)
class Workers:
    """Workers that are ready.

    Attributes
    ----------
    executor : concurrent.futures.Executor
        Executor of the work.
    count : int
        Number of workers.
    has_shared_memory : bool
        True if they share the memory of this program, so that an event can stop them.
    lost : callable
        Called while no answer comes; it returns the reason why none can come, or an empty text.
    """

    executor: Executor
    count: int
    has_shared_memory: bool
    lost: Callable[[], str] = str

    def answers(
        self, function: Callable[[Item], Answer], items: Iterable[Item]
    ) -> Iterator[tuple[Item, Answer | Exception]]:
        """Yield each item with its answer, or with the error of the function, when it is finished.

        Raises
        ------
        WorkersLostError
            The workers are gone.
        """
        waiting: dict[Future[Answer], Item] = {}
        remaining = iter(items)
        try:
            while True:
                for item in remaining:
                    waiting[self.executor.submit(function, item)] = item
                    if len(waiting) >= ITEMS_PER_WORKER * self.count:
                        break
                if not waiting:
                    return
                # On Windows a wait without timeout cannot be interrupted by Ctrl-C.
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
    """Return the result or the function's exception; re-raise failures of the pool."""
    try:
        return future.result()
    except (BrokenExecutor, CancelledError):
        raise
    except Exception as problem:
        return problem


def _answered(waiting: dict[Future[Answer], Item]) -> Iterator[tuple[Item, Answer | Exception]]:
    """Yield answers that came before the workers were lost; the loss may be noticed first."""
    for future in filter(Future.done, list(waiting)):
        with suppress(BrokenExecutor, CancelledError):
            answer = _answer(future)
            yield waiting.pop(future), answer


def _why_lost(problem: BrokenExecutor | CancelledError) -> str:
    from loky.process_executor import TerminatedWorkerError

    if isinstance(problem, CancelledError):
        return "the connection to the cluster was lost"
    if isinstance(problem, TerminatedWorkerError):
        return "a worker process was killed; check that there is enough memory"
    traceback = str(problem.__cause__ or "").strip('"\n')
    cause = traceback.rpartition("\n")[2]
    return f"the worker processes failed: {problem}" + (f" ({cause})" if cause else "")


@contextmanager
def workers(kind: Kind, count: int | None = None, cluster: str | None = None) -> Iterator[Workers]:
    """Start workers, or connect to a cluster, for the time of a context.

    Parameters
    ----------
    kind
        Type of workers on this machine. One thread takes the place of processes if `count` is 1,
        and if processes cannot be started: in a daemonic process, such as a worker of Celery or of
        ``multiprocessing.Pool``, and on a system without semaphores or shared memory.
    count
        Number of workers; None takes one for each core.
    cluster
        Address of a Dask scheduler such as ``tcp://host:8786``, in place of local workers.

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
                " give only one of them"
            )
        with _cluster(cluster) as found:
            yield found
        return
    count = count or cores()
    pool = _start_processes(count) if kind == "processes" and count > 1 else None
    if pool is not None:
        with _shut_down(pool) as executor:
            yield Workers(executor, count, has_shared_memory=False)
        return
    count = count if kind == "threads" else 1
    with ThreadPoolExecutor(count, "sweep") as executor:
        yield Workers(executor, count, has_shared_memory=True)


def _start_processes(count: int) -> Executor | None:
    """Start processes; return None if that is not possible."""
    # Unlike those of the standard library, processes of loky do not run the user's script again.
    from loky import ProcessPoolExecutor

    if current_process().daemon:
        return None
    try:
        executor: Executor = ProcessPoolExecutor(count, initializer=_ignore_interrupt)
        executor.submit(int)
    except (OSError, NotImplementedError):  # no semaphores, no shared memory, no more processes
        return None
    return executor


@contextmanager
def _shut_down(executor: Any) -> Iterator[Executor]:
    """End the processes with the context."""
    try:
        yield executor
    except BaseException:
        executor.shutdown(kill_workers=True)
        raise
    executor.shutdown()


def _ignore_interrupt() -> None:
    """Ignore Ctrl-C, which reaches every process of a terminal; the first process handles it."""
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
        client = Client(address, timeout=CONNECTION_TIMEOUT, set_as_default=False)
    except (OSError, ValueError) as problem:
        raise SceneError(
            f"cluster = {address!r}: no Dask scheduler answers ({problem}); check the address"
        ) from None
    with client:
        try:
            client.wait_for_workers(1, timeout=CONNECTION_TIMEOUT)
        except TimeoutError:
            raise SceneError(
                f"cluster = {address!r}: the scheduler has no workers; start dask worker {address}"
            ) from None
        here = program()
        for worker, there in client.run(program, on_error="return").items():
            if there != here:
                raise SceneError(
                    f"cluster = {address!r}: {here} here, but {there} on the worker {worker};"
                    " install the same version"
                )
        count = sum(client.nthreads().values())
        executor = client.get_executor(pure=False)
        try:
            yield Workers(
                executor, count, has_shared_memory=False, lost=_no_workers_reason(client, address)
            )
        finally:
            executor.shutdown(wait=False)  # cancels work that has not begun


def _check_address(address: str) -> None:
    """Refuse an address that Dask would wait for, or refuse without a reason.

    Raises
    ------
    SceneError
        No port, an unknown protocol, or a protocol for which Dask has no certificates.
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


def _no_workers_reason(client: Any, address: str) -> Callable[[], str]:
    """Return a function that reports a cluster without workers for `LOST_TIMEOUT`."""
    last = clock.monotonic()

    def lost() -> str:
        nonlocal last
        now = clock.monotonic()
        # A client that has lost its scheduler cancels its work itself.
        if client.status != "running" or client.nthreads():
            last = now
        if now - last < LOST_TIMEOUT:
            return ""
        return f"the cluster has had no workers for {LOST_TIMEOUT:g} s; start dask worker {address}"

    return lost
