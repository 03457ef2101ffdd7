"""Modes, frequency ratios and stability of an iced span or line, without simulating it.

Functions that take a scene also take the name of a packaged scene or the path of a scene file.

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

from typing import Any

import lazy_loader

from gallop_fmu.foundation.figures import FIGURES

# `__init__.pyi` is the one list of public names. A module is loaded when one of its names is first
# used: python-control, for one, is loaded for its models only.
_public_name, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)

FIGURES |= {
    "Branches.plot": "modal.plots.branch_figure:branch_figure",
    "Comparison.plot": "modal.plots.comparison_figure:comparison_figure",
    "LineMode.plot": "modal.plots.line_figures:line_mode_shapes",
    "Mode.plot": "modal.plots.span_figures:mode_shapes",
    "RiskAtlas.plot": "modal.plots.risk_figure:risk_figure",
    "RequiredSlope.plot": "modal.plots.slope_figure:slope_figure",
    "Screening.plot": "modal.plots.span_figures:screening_figure",
}

RENAMED = {"Parting": "Divergence", "way_out": "suggest_design_changes"}
"""Old names, which remain for one release, and the new ones."""


def __getattr__(name: str) -> Any:
    if name in RENAMED:
        from gallop_fmu.foundation.deprecation import warn_renamed

        warn_renamed(f"modal.{name}", RENAMED[name])
        name = RENAMED[name]
    return _public_name(name)
