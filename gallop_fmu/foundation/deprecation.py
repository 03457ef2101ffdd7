"""Warnings for names that remain for one release after they were renamed."""

from __future__ import annotations

import warnings


def warn_renamed(old: str, new: str, stacklevel: int = 3) -> None:
    """Warn that a public name was renamed.

    Parameters
    ----------
    old, new
        The names.
    stacklevel
        As for `warnings.warn`; 3 points at the caller of the function that calls this one.
    """
    warnings.warn(
        f"{old} is now called {new}; the old name will be removed in the next release",
        DeprecationWarning,
        stacklevel=stacklevel,
    )
