"""The compiled chain with explicit methods: velocity Verlet and Runge-Kutta 4, lumped mass."""

from __future__ import annotations

from collections.abc import Callable

from cases import Case
from chain import chain, runge_kutta, velocity_verlet
from scenes import INTERVAL, LOADED_POINTS, Array, Problem

SCHEMES = {  # steps [s] from just below the stability limit down
    "velocity Verlet": (velocity_verlet, (4.5e-4, 2.5e-4, 1.25e-4, 6.25e-5)),
    "Runge-Kutta 4": (runge_kutta, (6e-4, 4e-4, 2.5e-4)),
}


def cases(problem: Problem) -> list[Case]:
    return [
        Case(
            "numba",
            f"numba, {name}",
            f"step {1e3 * step:.3g} ms",
            ("chain", False),
            prepare(problem, scheme, step),
        )
        for name, (scheme, steps) in SCHEMES.items()
        for step in steps
    ]


def prepare(
    problem: Problem,
    scheme: Callable[..., Array],
    step: float,
    elements: int = LOADED_POINTS + 1,
) -> Callable[[], Callable[[], Array]]:
    def prepared() -> Callable[[], Array]:
        span = chain(problem, elements)
        every = round(INTERVAL / step)
        scheme(
            span, INTERVAL / every, every, 1
        )  # compiled, or read from the cache, before the clock runs
        return lambda: scheme(span, INTERVAL / every, every, len(problem.times))

    return prepared


def converged(problem: Problem, consistent: bool) -> Array:
    """Runge-Kutta of order 4 at a step of 0.2 ms; 0.25 ms differs by less than 3e-12."""
    return runge_kutta(chain(problem, consistent=consistent), 2e-4, 250, len(problem.times))
