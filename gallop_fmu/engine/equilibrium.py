"""The initial equilibrium of a span or line."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Equilibrium:
    """The initial equilibrium and the numbers derived from the scene.

    Attributes
    ----------
    x : ndarray, shape (node, 3)
        Positions [m] of the nodes.
    sag, horizontal_tension, length : float
        Sag [m] below the chord, horizontal tension [N], length [m] of the conductor; of a line, of
        its first chain.
    support_force : ndarray, shape (2, 3)
        Static force [N] of the cable on the left and right tower.
    support_stiffness : ndarray, shape (2, 2)
        Spring stiffness [N/m] along x1 and x3; 0 where the support is rigid.
    translation_damping, twist_damping : tuple of float
        Rayleigh b1 [1/s] and b2 [s].
    imbalance : float
        Largest nodal force [N] that holds an initial state of which both sag and tension were
        given.
    """

    x: Array
    sag: float
    horizontal_tension: float
    length: float
    support_force: Array
    support_stiffness: Array
    translation_damping: tuple[float, float]
    twist_damping: tuple[float, float]
    imbalance: float


@dataclass(frozen=True, slots=True)
class ChainEquilibrium:
    """The initial equilibrium of one chain.

    Attributes
    ----------
    sag, horizontal_tension, length : float
        Sag [m] at mid-span below the chord, horizontal tension [N] at the left end, length [m] of
        the conductor.
    end_force : ndarray, shape (2, 3)
        Force [N] of the chain on its left and right end, its weight included.
    """

    sag: float
    horizontal_tension: float
    length: float
    end_force: Array
