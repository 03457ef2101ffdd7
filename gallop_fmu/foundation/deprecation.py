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
        f"{old} is now called {new}; use the new name, as the next release removes the old one",
        DeprecationWarning,
        stacklevel=stacklevel,
    )
