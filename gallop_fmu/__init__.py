"""Galloping of iced overhead-line conductors: a nonlinear cable model, and its FMI 2.0 co-simulation FMU.

Axes: x1 along the span (left to right), x2 up, x3 horizontal; wind blows towards +x3.  Twist is
right-handed about x1, so the windward edge rises for positive twist.  SI units and radians; degrees
only in names that end in ``_deg``.

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

from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from gallop_fmu.scene.front_ends import FRONT_ENDS

if TYPE_CHECKING:
    from gallop_fmu.engine.model import Equilibrium, Inputs, Model, State
    from gallop_fmu.fmu import check_fmu, export_fmu
    from gallop_fmu.foundation.errors import SceneError
    from gallop_fmu.foundation.outcome import Outcome, Report, SimulationError
    from gallop_fmu.input.input_csv import with_inputs
    from gallop_fmu.input.scene_files import load_scene, packaged_scenes
    from gallop_fmu.line.clearance import cigre_322_single_loop, davison_single_loop
    from gallop_fmu.line.conductors import find_conductor
    from gallop_fmu.scene.scene import Scene
    from gallop_fmu.simulation.energy_balance import EnergyBalance, energy_balance
    from gallop_fmu.simulation.result import Oscillation, Result
    from gallop_fmu.simulation.simulate import simulate
    from gallop_fmu.simulation.steadiness import Motion, dominant_frequency
    from gallop_fmu.sweeps.cases import read_spans
    from gallop_fmu.sweeps.runs import Runs, RunsStoppedError, read_runs
    from gallop_fmu.sweeps.sweep import sweep

# Where each public name lives.  A module is loaded when its name is first used, so that `gallop-fmu
# --help` does not wait for numpy, nor a simulation for fmpy.
_HOMES = {
    "line.clearance": ("cigre_322_single_loop", "davison_single_loop"),
    "line.conductors": ("find_conductor",),
    "engine.model": ("Equilibrium", "Inputs", "Model", "State"),
    "foundation.errors": ("SceneError",),
    "fmu": ("check_fmu", "export_fmu"),
    "input.input_csv": ("with_inputs",),
    "foundation.outcome": ("Outcome", "Report", "SimulationError"),
    "simulation.energy_balance": ("EnergyBalance", "energy_balance"),
    "simulation.result": ("Oscillation", "Result"),
    "sweeps.runs": ("Runs", "RunsStoppedError", "read_runs"),
    "scene.scene": ("Scene",),
    "input.scene_files": ("load_scene", "packaged_scenes"),
    "simulation.simulate": ("simulate",),
    "sweeps.cases": ("read_spans",),
    "simulation.steadiness": ("Motion", "dominant_frequency"),
    "sweeps.sweep": ("sweep",),
}

__all__ = [
    "EnergyBalance",
    "Equilibrium",
    "Inputs",
    "Model",
    "Motion",
    "Oscillation",
    "Outcome",
    "Report",
    "Result",
    "Runs",
    "RunsStoppedError",
    "Scene",
    "SceneError",
    "SimulationError",
    "State",
    "check_fmu",
    "cigre_322_single_loop",
    "davison_single_loop",
    "dominant_frequency",
    "energy_balance",
    "export_fmu",
    "find_conductor",
    "load_scene",
    "packaged_scenes",
    "read_runs",
    "read_spans",
    "simulate",
    "sweep",
    "with_inputs",
]


def _resolve_line(data: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    from gallop_fmu.line.line_table import scene_data

    return scene_data(data, folder)


FRONT_ENDS["line"] = _resolve_line


def __getattr__(name: str) -> Any:
    for home, names in _HOMES.items():
        if name in names:
            return getattr(import_module(f"gallop_fmu.{home}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__
