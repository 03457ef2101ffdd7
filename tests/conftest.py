"""Settings that every test shares, and processes that do not outlive theirs."""

import os
import signal
import subprocess
from contextlib import ExitStack

import pytest
from hypothesis import settings

from modal.foundation.one_thread import limit_to_one_thread

# In CI the same examples every time; elsewhere fresh ones. No deadline: a slow machine is not a
# failure.
settings.register_profile("gallop", derandomize="CI" in os.environ, deadline=None, print_blob=True)
settings.load_profile("gallop")

# Started in the background, a process ignores Ctrl-C and so do its children; tests that send it
# need it heard.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session", autouse=True)
def one_thread_of_blas():
    """Tests also call what the public functions call, in as many processes as there are cores."""
    with limit_to_one_thread():
        yield


@pytest.fixture
def begin():
    """`subprocess.Popen` of processes that are killed at the end of the test."""
    with ExitStack() as begun:

        def popen(*arguments, **options):
            process = begun.enter_context(subprocess.Popen(*arguments, **options))
            begun.callback(process.kill)
            return process

        yield popen
