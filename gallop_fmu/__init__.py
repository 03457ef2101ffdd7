"""Galloping of iced overhead-line conductors: a nonlinear cable model, and its FMI 2.0 co-simulation FMU.

Axes: x1 along the span (left to right), x2 up, x3 horizontal; wind blows towards +x3.  Twist is right-handed about x1,
so the windward edge rises for positive twist.  SI units and radians; degrees only in names that end in ``_deg``.

The model is that of Liu, Yan, Zhang and Zhou (2009), Appl. Math. Mech. 30(4) 489-501.

Examples
--------
>>> import gallop_fmu as gf
>>> scene = gf.load_scene("example3").with_values({"wind.speed": 5.0})
>>> result = gf.simulate(scene, stop_time=1.0)
>>> result.outcome.name
'COMPLETED'
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from gallop_fmu.engine import Equilibrium, Inputs, Model, State
from gallop_fmu.errors import SceneError
from gallop_fmu.outcome import Outcome, Report, SimulationError
from gallop_fmu.result import Oscillation, Result
from gallop_fmu.scene import Scene, load_scene, packaged_scenes
from gallop_fmu.simulation import simulate

if TYPE_CHECKING:
    from gallop_fmu.fmu import check_fmu, export_fmu

__all__ = [
    "Equilibrium",
    "Inputs",
    "Model",
    "Oscillation",
    "Outcome",
    "Report",
    "Result",
    "Scene",
    "SceneError",
    "SimulationError",
    "State",
    "check_fmu",
    "export_fmu",
    "load_scene",
    "packaged_scenes",
    "simulate",
]


def __getattr__(name: str) -> Any:
    """Load the FMU tools when they are first used: they import fmpy and pythonfmu, which a simulation does not need."""
    if name in ("check_fmu", "export_fmu"):
        from gallop_fmu import fmu

        return getattr(fmu, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
