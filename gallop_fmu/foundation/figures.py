"""Figures that objects draw of themselves by `plot()`; layers above register the functions."""

from __future__ import annotations

from importlib import import_module
from typing import Any

FIGURES: dict[str, str] = {}
"""Class and method, such as ``Result.plot``, to the function that draws, as ``module:name``."""


def drawn(name: str, *arguments: Any, **options: Any) -> Any:
    """Draw a registered figure; its module, and so matplotlib, is loaded now.

    Returns
    -------
    matplotlib.figure.Figure
    """
    module, _, function = FIGURES[name].partition(":")
    return getattr(import_module(module), function)(*arguments, **options)
