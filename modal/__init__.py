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
    from modal.analytic import ShallowCable, shallow_cable
    from modal.comparison import Comparison, LinearMode, Parting, compare
    from modal.corridor import screen_spans
    from modal.criteria import Criterion, coupled, den_hartog, nigol, stability_criteria
    from modal.linear import linear_model, root_locus
    from modal.modes import Mode, natural_modes
    from modal.onset import CriticalWind, critical_wind_speed
    from modal.report.page import write_report
    from modal.resonance import DesignChange, FrequencyRatio, crossings, frequency_ratio, ratio_map, way_out
    from modal.screening import Cycle, Screening, screen
    from modal.stringing import change_of_state
    from modal.superposition import mode_superposition
    from modal.tracking import track_modes
    from modal.two_mode import Coupling, TwoMode, quadratic_coupling, two_mode_estimate

# Where each public name lives.  A module is loaded when its name is first used, so that nobody waits for python-control
# who did not ask for it.
_HOMES = {
    "analytic": ("ShallowCable", "shallow_cable"),
    "comparison": ("Comparison", "LinearMode", "Parting", "compare"),
    "corridor": ("screen_spans",),
    "criteria": ("Criterion", "coupled", "den_hartog", "nigol", "stability_criteria"),
    "linear": ("linear_model", "root_locus"),
    "modes": ("Mode", "natural_modes"),
    "onset": ("CriticalWind", "critical_wind_speed"),
    "report.page": ("write_report",),
    "resonance": ("DesignChange", "FrequencyRatio", "crossings", "frequency_ratio", "ratio_map", "way_out"),
    "screening": ("Cycle", "Screening", "screen"),
    "stringing": ("change_of_state",),
    "superposition": ("mode_superposition",),
    "tracking": ("track_modes",),
    "two_mode": ("Coupling", "TwoMode", "quadratic_coupling", "two_mode_estimate"),
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
