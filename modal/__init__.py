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

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from modal.foundation.change_of_state import change_of_state
    from modal.linear.mode_tracking import track_modes
    from modal.linear.modes import Mode, natural_modes
    from modal.linear.shallow_cable import ShallowCable, shallow_cable
    from modal.linear.state_space import linear_model, root_locus
    from modal.report.page import write_report
    from modal.screening.many_spans import screen_spans
    from modal.screening.screen import Cycle, Screening, screen
    from modal.screening.two_mode_estimate import (
        Coupling,
        TwoMode,
        quadratic_coupling,
        two_mode_estimate,
    )
    from modal.stability.criteria import Criterion, coupled, den_hartog, nigol, stability_criteria
    from modal.stability.critical_wind import CriticalWind, critical_wind_speed
    from modal.stability.frequency_ratio import (
        DesignChange,
        FrequencyRatio,
        crossings,
        frequency_ratio,
        ratio_map,
        way_out,
    )
    from modal.superposition.comparison import Comparison, LinearMode, Parting, compare
    from modal.superposition.mode_superposition import mode_superposition

# Where each public name lives.  A module is loaded when its name is first used, so that nobody
# waits for python-control who did not ask for it.
_HOMES = {
    "linear.shallow_cable": ("ShallowCable", "shallow_cable"),
    "superposition.comparison": ("Comparison", "LinearMode", "Parting", "compare"),
    "screening.many_spans": ("screen_spans",),
    "stability.criteria": ("Criterion", "coupled", "den_hartog", "nigol", "stability_criteria"),
    "linear.state_space": ("linear_model", "root_locus"),
    "linear.modes": ("Mode", "natural_modes"),
    "stability.critical_wind": ("CriticalWind", "critical_wind_speed"),
    "report.page": ("write_report",),
    "stability.frequency_ratio": (
        "DesignChange",
        "FrequencyRatio",
        "crossings",
        "frequency_ratio",
        "ratio_map",
        "way_out",
    ),
    "screening.screen": ("Cycle", "Screening", "screen"),
    "foundation.change_of_state": ("change_of_state",),
    "superposition.mode_superposition": ("mode_superposition",),
    "linear.mode_tracking": ("track_modes",),
    "screening.two_mode_estimate": (
        "Coupling",
        "TwoMode",
        "quadratic_coupling",
        "two_mode_estimate",
    ),
}

__all__ = [
    "Comparison",
    "Coupling",
    "Criterion",
    "CriticalWind",
    "Cycle",
    "DesignChange",
    "FrequencyRatio",
    "LinearMode",
    "Mode",
    "Parting",
    "Screening",
    "ShallowCable",
    "TwoMode",
    "change_of_state",
    "compare",
    "coupled",
    "critical_wind_speed",
    "crossings",
    "den_hartog",
    "frequency_ratio",
    "linear_model",
    "mode_superposition",
    "natural_modes",
    "nigol",
    "quadratic_coupling",
    "ratio_map",
    "root_locus",
    "screen",
    "screen_spans",
    "shallow_cable",
    "stability_criteria",
    "track_modes",
    "two_mode_estimate",
    "way_out",
    "write_report",
]


def __getattr__(name: str) -> Any:
    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"modal.{home}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
