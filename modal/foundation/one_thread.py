"""One thread of BLAS during the long functions of this package, whose matrices are small."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from functools import cache, wraps
from typing import Any, ParamSpec, TypeVar

Parameters = ParamSpec("Parameters")
Returned = TypeVar("Returned")


def one_thread(function: Callable[Parameters, Returned]) -> Callable[Parameters, Returned]:
    """Decorate a function in which BLAS and LAPACK use one thread.

    For matrices of this size, several threads wait for each other longer than they compute
    (`benchmarks/speed/blas_threads.py`).
    """

    @wraps(function)
    def call(*args: Parameters.args, **kwargs: Parameters.kwargs) -> Returned:
        with limit_to_one_thread():
            return function(*args, **kwargs)

    return call


def limit_to_one_thread() -> AbstractContextManager[object]:
    """Limit BLAS to one thread for the time of a context, which takes about 10 us.

    The limit belongs to the process. Contexts may be nested; of those that overlap in several
    Python threads, the first one decides.
    """
    context: AbstractContextManager[object] = _libraries().limit(limits=1, user_api="blas")
    return context


@cache
def _libraries() -> Any:
    """Return the loaded libraries with threads: NumPy and SciPy have one each."""
    import scipy.linalg  # noqa: F401  (loads its library)
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
