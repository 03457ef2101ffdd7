"""Figures that objects draw of themselves by `plot()`; layers above register the functions."""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from typing import Any

FIGURES: dict[str, str] = {}
"""Class and method, such as ``Result.plot``, to the function that draws, as ``module:name``."""

NOTEBOOK = "notebook"
"""Name of the registered function that gives a figure a picture for notebooks."""


def drawn(name: str, *arguments: Any, **options: Any) -> Any:
    """Draw a registered figure; its module, and so matplotlib, is loaded now.

    Returns
    -------
    matplotlib.figure.Figure
        A figure that notebooks show.
    """
    return _registered(NOTEBOOK)(_registered(name)(*arguments, **options))


def _registered(name: str) -> Callable[..., Any]:
    module, _, function = FIGURES[name].partition(":")
    found: Callable[..., Any] = getattr(import_module(module), function)
    return found
