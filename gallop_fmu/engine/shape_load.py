"""Load of ice and wind on a span or line that moves in a few shapes, from the compiled kernel."""

from __future__ import annotations

import ctypes as c
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.library import address, kernel
from gallop_fmu.engine.model import Model
from gallop_fmu.foundation.argument_checks import numbers

Array = NDArray[np.float64]

ATTACK, MOMENTS, GRAVITY, WIND, ROWS = 0, slice(1, 3), 3, slice(4, 6), 6
"""Rows of the numbers of sections; see `gallop_shape_load` in ``kernel/gallop_analysis.h``."""


class ShapeLoad:
    """Load on the sections of a model, collected by the shapes in which it moves.

    It is the force of rotated ice that is not linear about rest, less the aerodynamic load (Liu et
    al. 2009, equations 8, 17, 20 and 21).

    Parameters
    ----------
    model
        The span or line.
    shape : ndarray, shape (3, mode, section)
        Motion of the sections per unit coordinate: along n2, along x3 [m], twist [rad].
    weighted : ndarray, shape (3, section, mode)
        The same times the length of conductor [m] that belongs to each section.
    table : ndarray, shape (6, section)
        Attack angle [rad], first moments m2 and m3 of the ice [kg], gravity against n2 [m/s2], and
        wind along n2 and x3 per m/s of speed.
    element : ndarray of int, shape (section,)
        Element whose conductor and coefficient curve apply.
    """

    def __init__(
        self,
        model: Model,
        shape: Array,
        weighted: Array,
        table: Array,
        element: NDArray[np.integer[Any]],
    ) -> None:
        _, self._modes, self._sections = shape.shape
        self._model = model
        self._shape, self._table = (np.ascontiguousarray(one) for one in (shape, table))
        self._weight = np.ascontiguousarray(weighted.swapaxes(1, 2))
        self._element = np.ascontiguousarray(element, dtype=np.int32)
        if self._table.shape != (ROWS, self._sections):
            raise ValueError(f"table has the shape {self._table.shape}")
        if self._weight.shape != self._shape.shape or self._element.shape != (self._sections,):
            raise ValueError("weighted or element has another number of sections than shape")
        self._given = (
            self._model.handle,
            self._sections,
            self._element.ctypes.data_as(c.POINTER(c.c_int32)),
            address(self._table),
            self._modes,
            address(self._shape),
            address(self._weight),
        )

    def __reduce__(self) -> tuple[Any, ...]:
        weighted = self._weight.swapaxes(1, 2)
        return ShapeLoad, (self._model, self._shape, weighted, self._table, self._element)

    def __call__(self, q: Array, v: Array, a: Array, wind: float | Array) -> Array:
        """Force on each coordinate.

        Parameters
        ----------
        q, v, a : ndarray, shape (instant, mode)
            Coordinates, velocities and accelerations.
        wind : float or ndarray, shape (instant, 1)
            Wind speed [m/s].

        Returns
        -------
        ndarray, shape (instant, mode)

        Raises
        ------
        ValueError
            If a number is not finite.
        """
        n, count = self._modes, len(q)
        motion = np.empty((3 * n + 1, count))
        motion[:n], motion[n : 2 * n], motion[2 * n : -1] = q.T, v.T, a.T
        motion[-1] = np.ravel(wind)
        force = np.empty((n, count))
        refused = kernel.gallop_shape_load(*self._given, count, address(motion), address(force))
        if refused:
            numbers("motion", motion, motion.shape)
            raise RuntimeError(f"the kernel refused a call with outcome {refused}")
        return force.T
