"""Processors of this machine that a program may use."""

from __future__ import annotations

import os
import sys


def cores() -> int:
    """Number of cores that this program may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def is_worker_process() -> bool:
    """Return True in a process that `multiprocessing` has started: others share its cores."""
    process = sys.modules.get("multiprocessing.process")  # loaded in such a process
    return process is not None and process.parent_process() is not None
