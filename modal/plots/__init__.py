"""Figures of the modal toolkit."""

from modal.plots.comparison_figure import comparison_figure
from modal.plots.line_figures import line_mode_shapes, pair_figure
from modal.plots.risk_figure import risk_figure
from modal.plots.slope_figure import slope_figure
from modal.plots.span_figures import (
    criteria_figure,
    locus_figure,
    mode_shapes,
    ratio_figure,
    screening_figure,
    tracking_figure,
)

__all__ = [
    "comparison_figure",
    "criteria_figure",
    "line_mode_shapes",
    "locus_figure",
    "mode_shapes",
    "pair_figure",
    "ratio_figure",
    "risk_figure",
    "screening_figure",
    "slope_figure",
    "tracking_figure",
]
