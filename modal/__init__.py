"""Modes, frequency ratios and stability of an iced span, seen from outside the simulation.

Examples
--------
>>> import gallop_fmu as gf, modal
>>> scene = gf.load_scene("example3")
>>> [(mode.family, mode.loops) for mode in modal.natural_modes(scene, count=2)]
[('horizontal', 1), ('vertical', 1)]
>>> round(modal.frequency_ratio(scene).ratio, 2)
1.84
"""

from __future__ import annotations

import lazy_loader

# `__init__.pyi` is the one list of public names. A module is loaded when one of its names is first
# used: python-control, for one, is loaded for its models only.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
