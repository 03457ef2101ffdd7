"""BLAS has one thread in public functions of `modal`, and as many as before after them."""

import subprocess
import sys

import pytest
import threadpoolctl

import gallop_fmu as gf
import modal
from modal.linear import modes
from modal.screening import screen


def threads():
    """Number of threads of each library."""
    info = threadpoolctl.threadpool_info()
    return [library["num_threads"] for library in info if library["user_api"] == "blas"]


@pytest.fixture
def three_threads():
    """Three threads in place of the one that the tests have."""
    with threadpoolctl.threadpool_limits(3, "blas"):
        assert set(threads()) == {3}
        yield


@pytest.mark.parametrize(
    ("module", "inner", "call"),
    [
        (modes, "modes_of", lambda: modal.natural_modes("example3")),
        (screen, "check_wind", lambda: modal.screen("example3")),
    ],
)
def test_public_functions_use_one_thread(three_threads, monkeypatch, module, inner, call):
    seen = []

    def stop(*_):
        seen.append(threads())
        raise gf.SceneError("stop")

    monkeypatch.setattr(module, inner, stop)
    with pytest.raises(gf.SceneError, match="stop"):
        call()
    assert set(seen[0]) == {1}
    assert set(threads()) == {3}


def test_libraries_that_are_loaded_later_are_limited():
    """SciPy has its own library, which a new program has not loaded before the first call."""
    code = (
        "import threadpoolctl\n"
        "from modal.foundation.one_thread import one_thread\n"
        "import numpy\n"
        "@one_thread\n"
        "def seen():\n"
        "    import scipy.linalg\n"
        "    return [one['num_threads'] for one in threadpoolctl.threadpool_info()]\n"
        "assert set(seen()) == {1}, seen()\n"
    )
    subprocess.run([sys.executable, "-P", "-c", code], check=True, timeout=60)
