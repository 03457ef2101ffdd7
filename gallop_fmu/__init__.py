"""Galloping of iced overhead-line conductors: a nonlinear cable model and its FMI 2.0 FMU.

Axes: x1 along the span (left to right), x2 up, x3 horizontal; wind blows towards +x3.  Twist is
right-handed about x1, so the windward edge rises for positive twist.  SI units and radians; degrees
only in names that end in ``_deg``.

Functions that take a scene also take the name of a packaged scene or the path of a scene file.

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
from pathlib import Path
from typing import Any

import lazy_loader

from gallop_fmu.foundation.figures import FIGURES, NOTEBOOK
from gallop_fmu.scene.front_ends import FRONT_ENDS

# `__init__.pyi` is the one list of public names. A module is loaded when one of its names is first
# used: `gallop-fmu --help` does not load numpy, and a simulation does not load fmpy.
__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)


def _resolve_line(data: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    from gallop_fmu.line.line_table import scene_data

    return scene_data(data, folder)


FRONT_ENDS["line"] = _resolve_line
FIGURES |= {
    NOTEBOOK: "gallop_fmu.plots:shown_in_notebooks",
    "Result.plot": "gallop_fmu.plots:overview",
    "Result.trace": "gallop_fmu.plots:trace",
    "LineResult.plot": "gallop_fmu.line_plots:line_histories",
    "LineResult.trace": "gallop_fmu.line_plots:line_paths",
}
