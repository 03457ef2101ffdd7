"""The packaged coefficient curves: their numbers, sources and limits.

A file in ``curves/`` describes each. It contains one of

- ``[across_wind]``: the force across the wind as an odd polynomial, see `across_wind_table`;
- ``[table]``: the columns of a table;
- ``scene``: the packaged scene that contains the numbers.
"""

from __future__ import annotations

import difflib
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal

import numpy as np

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_files import packaged_names, packaged_text

Status = Literal["published", "reconstructed", "assumed"]

FOLDER = "scene/curves"


@dataclass(frozen=True)
class CurveEntry:
    """A packaged coefficient curve.

    Attributes
    ----------
    name : str
        Name in scenes.
    title : str
        The section in a few words.
    status : {"published", "reconstructed", "assumed"}
        Published: the numbers are in the source. Reconstructed: they were fitted to results of the
        source. Assumed: they have no source.
    source : str
        Source of the numbers.
    reynolds : str
        Reynolds number of the measurement.
    attack_angle : str
        Orientation of the section at attack angle zero.
    validity : str
        What the curve can be used for.
    data : Mapping
        Section ``[aerodynamics]`` with the numbers, of kind ``polynomial`` or ``table``.
    """

    name: str
    title: str
    status: Status
    source: str
    reynolds: str
    attack_angle: str
    validity: str
    data: Mapping[str, Any]


@cache
def packaged_curves() -> dict[str, CurveEntry]:
    """Return the packaged curves by name."""
    return {name: _entry(name) for name in packaged_names(FOLDER, ".toml")}


def find_curve(name: str) -> CurveEntry:
    """Return a packaged curve.

    Raises
    ------
    SceneError
        No curve has the name; the message names the closest.
    """
    curves = packaged_curves()
    if name not in curves:
        closest = difflib.get_close_matches(name, curves, n=1, cutoff=0.0)[0]
        raise SceneError(
            f"{name!r} is not a packaged curve; there are {', '.join(curves)}; closest: {closest}"
        )
    return curves[name]


def _entry(name: str) -> CurveEntry:
    content = tomllib.loads(packaged_text(FOLDER, f"{name}.toml"))
    if "scene" in content:
        scene = tomllib.loads(packaged_text("scene/packaged", f"{content.pop('scene')}.toml"))
        content["source"] = scene["sources"]["aerodynamics"]
        content["data"] = scene["aerodynamics"]
    elif "across_wind" in content:
        content["data"] = across_wind_table(**content.pop("across_wind"))
    else:
        content["data"] = {"kind": "table", **content.pop("table")}
    return CurveEntry(name=name, **content)


def across_wind_table(
    force: Sequence[float], drag: float, range_deg: float, step_deg: float
) -> dict[str, Any]:
    """Return the table of lift and drag whose force across the wind is a polynomial in x = v/U.

    With the velocity v across the wind U, the force per unit length is rho d U^2/2 CFy, CFy = sum
    of force[k] x^(2k + 1). The quasi-steady one is rho d Ur/2 (CL w3 + CD w2) with w3 = U, w2 = -v,
    tan(alpha) = -x and Ur = U/cos(alpha), so that CL = cos(alpha) CFy(-tan(alpha)) - CD tan(alpha).

    Parameters
    ----------
    force
        Coefficients of x, x^3, x^5, ...
    drag
        Drag coefficient, constant.
    range_deg, step_deg
        Largest attack angle and step of the table [deg].
    """
    steps = round(range_deg / step_deg)
    angle = step_deg * np.arange(-steps, steps + 1)
    tangent = np.tan(np.radians(angle))
    across = sum(c * (-tangent) ** (2 * k + 1) for k, c in enumerate(force))
    return {
        "kind": "table",
        "angle_deg": angle.tolist(),
        "lift": (np.cos(np.radians(angle)) * across - drag * tangent).tolist(),
        "drag": [drag] * len(angle),
        "moment": [0.0] * len(angle),
    }
