"""Conversion and checks of arguments of the compiled kernel: type, shape and range."""

from __future__ import annotations

import operator
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def number(name: str, value: Any) -> float:
    """Return `value` as a float.

    Raises
    ------
    TypeError
        It is not one real number.
    """
    if type(value) is float:
        return value
    array = _real(name, value)
    if array.ndim:
        raise TypeError(f"{name} must be one number, not an array of shape {array.shape}")
    return float(array)


def finite(name: str, value: Any) -> float:
    """Return `value` as a finite float.

    Raises
    ------
    TypeError, ValueError
        It is not one real number, or not finite.
    """
    result = number(name, value)
    if not np.isfinite(result):
        raise ValueError(f"{name} = {result} must be finite")
    return result


def whole(name: str, value: Any, low: int, high: int) -> int:
    """Return `value` as an int from `low` to `high`.

    Raises
    ------
    TypeError, ValueError
        It is not a whole number, or out of range.
    """
    try:
        result = operator.index(value)
    except TypeError:
        raise TypeError(f"{name} must be a whole number, not {value!r}") from None
    if not low <= result <= high:
        raise ValueError(f"{name} = {result} must be at least {low} and at most {high}")
    return result


def numbers(name: str, values: Any, shape: tuple[int, ...]) -> Array:
    """Return finite numbers as a contiguous array of doubles; a flat array is reshaped.

    Raises
    ------
    TypeError, ValueError
        They are not real numbers, have another shape, or are not finite.
    """
    array = _real(name, values)
    if array.shape not in (shape, (int(np.prod(shape)),)):
        raise ValueError(f"{name} has the shape {array.shape}; it must have {shape}")
    with np.errstate(over="ignore"):  # infinity is refused below
        array = np.ascontiguousarray(array.reshape(shape), dtype=np.float64)
    if not np.isfinite(array).all():
        place = tuple(int(i) for i in np.argwhere(~np.isfinite(array))[0])
        raise ValueError(f"{name} must be finite; {name}{list(place)} is {array[place]}")
    return array


def indices(name: str, values: Any, count: int) -> NDArray[np.int32]:
    """Return indices below `count` as a contiguous array of 32-bit integers.

    Raises
    ------
    TypeError, ValueError, IndexError
        They are not whole numbers, not one-dimensional, or out of range.
    """
    array = _array(name, values)
    if array.ndim != 1:
        raise ValueError(f"{name} has the shape {array.shape}; it must have one dimension")
    if array.size and array.dtype.kind not in "iu":
        raise TypeError(f"{name} must be whole numbers, not {array.dtype}")
    wrong = np.flatnonzero((array < 0) | (array >= count)) if array.size else array
    if wrong.size:
        place = int(wrong[0])
        raise IndexError(
            f"{name}[{place}] = {array[place]} does not exist; there are 0 to {count - 1}"
        )
    return np.ascontiguousarray(array, dtype=np.int32)


def _array(name: str, values: Any) -> NDArray[Any]:
    try:
        return np.asarray(values)
    except ValueError:
        raise ValueError(f"{name} is not an array: its rows have different lengths") from None


def _real(name: str, values: Any) -> NDArray[Any]:
    array = _array(name, values)
    if array.dtype.kind not in "iuf":
        raise TypeError(f"{name} must be real numbers, not {values!r:.60}")
    return array
