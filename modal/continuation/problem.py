"""What the engine must know of a system of ordinary differential equations y' = f(y, p)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Rates(NamedTuple):
    """The right-hand side f and its derivatives at several states.

    Attributes
    ----------
    value : ndarray, shape (state, n)
        f(y, p).
    by_state : ndarray, shape (state, n, n)
        Derivatives by y; rows are components of f.
    by_parameter : ndarray, shape (state, n)
        Derivatives by p.
    """

    value: Array
    by_state: Array
    by_parameter: Array


class Problem(Protocol):
    """A smooth autonomous system y' = f(y, p) of n equations with one parameter."""

    @property
    def size(self) -> int:
        """Number n of equations."""

    @property
    def scale(self) -> Array:
        """Typical size of each component of y, shape (n,); it defines distances on a branch."""

    @property
    def symmetry(self) -> Array | None:
        """Matrix S with S S = 1 and f(S y, p) = S f(y, p), shape (n, n); None: no symmetry."""

    @property
    def is_second_order(self) -> bool:
        """True if y = (q, v) with q' = v: half of the equations are solved in advance."""

    def rates(self, states: Array, parameter: float) -> Rates:
        """Evaluate f and its derivatives at many states, shape (state, n), at once."""

    def defect(self, states: Array, slopes: Array, parameter: float) -> Array | None:
        """Approximate f(y, p) - y' at states y with slopes y', both of shape (state, n).

        It is zero where f(y, p) = y'. None: it takes as long as `rates`.
        """


@dataclass(frozen=True)
class System:
    """A problem made of a function.

    Attributes
    ----------
    function : callable
        ``function(states, parameter)`` returns `Rates` for states of shape (state, n).
    scale : ndarray, shape (n,)
        Typical size of each component.
    symmetry, is_second_order
        As in `Problem`.
    """

    function: Callable[[Array, float], Rates]
    scale: Array
    symmetry: Array | None = None
    is_second_order: bool = False

    @property
    def size(self) -> int:
        """Number of equations."""
        return len(self.scale)

    def rates(self, states: Array, parameter: float) -> Rates:
        """Evaluate f and its derivatives."""
        return self.function(states, parameter)

    def defect(self, states: Array, slopes: Array, parameter: float) -> Array | None:
        """Return None."""
        return None


class ContinuationError(ArithmeticError):
    """No further solution was found; the message states why and what to do."""
