"""A second thread that shares the runs of one large line with the first one."""

from __future__ import annotations

import ctypes as c
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from gallop_fmu.engine.ctypes_structs import CTeam
from gallop_fmu.engine.library import kernel


@contextmanager
def team_of(threads: int) -> Iterator[Any]:
    """Provide the pointer to a team for `gallop_run_in_team`; None for one thread.

    The second thread lives within the context only, so none exists when a program forks between
    two runs. It does not hold the interpreter lock. Without it, as where no thread can be started,
    the first one computes all.

    Parameters
    ----------
    threads
        1 or 2.
    """
    if threads == 1:
        yield None
        return
    pointer = c.byref(CTeam())
    second = threading.Thread(target=kernel.gallop_assist, args=(pointer,), daemon=True)
    try:
        second.start()
    except RuntimeError:
        yield None
        return
    try:
        yield pointer
    finally:
        kernel.gallop_dismiss(pointer)
        second.join()
