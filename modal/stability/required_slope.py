"""Slope of the coefficient curve that a span or line needs to gallop, where no curve is known.

**Slope.** At the attack angle of the mean wind, lift and moment are assumed to be zero and to have
slopes; the drag is constant. The equations of small motion about the equilibrium in the mean wind
are then linear in each slope,

    M q'' + (C + p C1) q' + (K + p K1) q = 0                                                     (1)

(`modal.linear.slope_load`). A mode is neutral where (1) has a solution that oscillates with
constant amplitude: the determinant of K + p K1 - w^2 M + i w (C + p C1) is zero, two real equations
for p and the frequency w (`modal.linear.neutral_slope`). For a section that moves vertically and
twists it is the flutter determinant of two degrees of freedom.

The balance of damping along the mode p_i of still air, whose modal mass is 1 and damping ratio xi,

    2 xi w + p_i.C_wind p_i + p p_i.C1 p_i = 0,                                                  (2)

is the estimate. In pure vertical motion it is Den Hartog's criterion with structural damping, CD +
dCL/dalpha = -4 m xi w / (rho d U); in pure twist, with the moment, dCM/dalpha = -4 I xi w / (rho
d^2 r U).

**Divergence.** The lowest positive slope of the moment at which K + p K1 is singular: the wind's
moment grows as fast with the twist as the restoring moment. In pure twist it is 2 I w^2 / (rho U^2
d^2).

**Amplitude.** How high a mode gallops depends on the whole curve. It is estimated for an assumed
saturation: the force across the wind is the cubic

    F = rho U^2 d/2 D v/U (1 - (v/U)^2 / s^2),    D = CD + dCL/dalpha < 0,                       (3)

in the velocity v, which changes its sign again at v/U = s, the tangent of the angle of the relative
wind there. With f the mode's motion normal to the wind, 1 where it is largest, and D0 the slope at
which the mode is neutral, the work of one cycle vanishes at the amplitude

    A = (U/w) s sqrt(4/3 int f^2 dS / int f^4 dS) sqrt(1 - D0/D).                                (4)

The amplitude limit is that of a very negative D: 1.33 s U/w for a half-wave.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Scene, SceneError
from gallop_fmu.foundation.figures import drawn
from gallop_fmu.input.scene_like import SceneLike, as_scene
from gallop_fmu.simulation.clearance import cigre_322_single_loop
from modal.foundation.one_thread import one_thread
from modal.linear.line_modes import LineMode
from modal.linear.modes import Mode
from modal.stability.slope_search import SlopePath, SlopeSearch

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Array = NDArray[np.float64]

DEFAULT_WIND_SPEEDS = tuple(float(speed) for speed in range(1, 21))
"""Wind speeds [m/s] if none are given: 1 to 20 m/s."""

DEFAULT_DRAG = 1.0
"""Drag coefficient of a scene without a curve: about that of a stranded conductor."""

DEFAULT_SATURATION_DEG = 45.0
"""Angle of the relative wind at which the force across the wind is assumed to change its sign."""

MIN_SPAN_SHARE = 0.1
"""Share of a span in the kinetic energy of a mode above which the mode counts for the span."""

UNITS = {
    "still_air_hz": "Hz",
    "damping_ratio": "1",
    "span_share": "1",
    "slope": "1/rad",
    "slope_estimate": "1/rad",
    "frequency_hz": "Hz",
    "amplitude_limit": "m",
    "moment_slope": "1/rad",
    "moment_slope_estimate": "1/rad",
    "moment_frequency_hz": "Hz",
    "divergence_moment_slope": "1/rad",
    "observed_amplitude": "m",
}
"""Numbers of the result, and their units."""


@dataclass(frozen=True)
class RequiredSlope:
    """Slope of the coefficient curve at which each mode begins to grow, over the wind speed.

    Attributes
    ----------
    dataset : xarray.Dataset
        Over ``mode`` (number from 1), ``wind_speed`` [m/s] and ``span`` (number from 1), with the
        unit of each variable in its attribute ``units``:

        - ``slope``: CD + dCL/dalpha at which the mode is neutral; it grows where the curve is
          steeper (below). NaN where the mode has no vertical motion, or none was found;
        - ``slope_estimate``: the same from the balance of damping along the mode of still air;
        - ``frequency_hz``: frequency of the neutral mode;
        - ``amplitude_limit``: estimate of the largest amplitude of the mode, normal to the wind
          where it is largest, for a very negative slope and the assumed saturation;
        - ``moment_slope``, ``moment_slope_estimate``, ``moment_frequency_hz``: dCM/dalpha below
          which a torsional mode grows, the same from the balance, and the frequency of the neutral
          mode;
        - ``divergence_moment_slope``: dCM/dalpha above which the twist diverges (of all modes
          together);
        - ``observed_amplitude``: largest amplitude observed on lines by CIGRE 322, half its
          ellipse's major axis (of each span; NaN for bundles);
        - ``family``, ``loops``, ``still_air_hz``, ``damping_ratio``, ``span_share`` of the mode in
          still air.
    drag : float
        Drag coefficient.
    given_lift_slope, given_moment_slope : float
        Slopes of lift (for ``moment_slope``) and moment (for ``slope``) [1/rad].
    saturation_deg : float
        Assumed angle of the relative wind [deg] at which the force across the wind changes sign.
    remarks : list of str
        Assumptions of the result, and what could not be computed.
    """

    dataset: xr.Dataset = field(repr=False)
    drag: float
    given_lift_slope: float
    given_moment_slope: float
    saturation_deg: float
    remarks: list[str]

    def plot(self) -> Any:
        """Draw slopes and amplitudes over the wind speed by `modal.plots.slope_figure`.

        Returns
        -------
        matplotlib.figure.Figure
        """
        return drawn("RequiredSlope.plot", self)

    def decisive(self) -> xr.DataArray:
        """Largest ``slope`` of all modes over the wind speed; a curve above it excites no mode."""
        found: xr.DataArray = self.dataset.slope.max("mode", skipna=True)
        return found

    def by_span(self) -> xr.DataArray:
        """Largest ``slope`` of the modes in which a span has 10 % of the energy, for each span."""
        counts = self.dataset.span_share >= MIN_SPAN_SHARE
        found: xr.DataArray = self.dataset.slope.where(counts).max("mode", skipna=True)
        return found

    def amplitude(self, slope: float) -> xr.DataArray:
        """Estimate the amplitude [m] of each mode for a curve with a given CD + dCL/dalpha.

        Parameters
        ----------
        slope
            CD + dCL/dalpha [1/rad], negative.

        Returns
        -------
        xarray.DataArray
            Over mode and wind speed: equation (4) of the module, 0 where the mode does not grow.

        Raises
        ------
        SceneError
            If the slope is not negative: the assumed saturation holds for negative slopes.
        """
        if not (np.isfinite(slope) and slope < 0.0):
            raise SceneError(
                f"slope = {slope} 1/rad: must be a negative number; the estimate of the amplitude"
                " holds for a force that grows with the velocity"
            )
        above = (1.0 - self.dataset.slope / slope).clip(0.0, 1.0)
        found: xr.DataArray = self.dataset.amplitude_limit * np.sqrt(above)
        found = found.rename("amplitude").assign_attrs(units="m")
        return found

    def to_dataframe(self) -> pd.DataFrame:
        """Table of the modes, a row for each mode and wind speed; units in ``attrs["units"]``."""
        of_modes = self.dataset.drop_dims("span")
        frame = of_modes.to_dataframe().reset_index()
        frame.attrs["units"] = {name: UNITS[name] for name in frame.columns if name in UNITS} | {
            "wind_speed": "m/s"
        }
        return frame


@one_thread
def required_slope(
    scene: SceneLike,
    wind_speeds: Sequence[float] | None = None,
    *,
    count: int = 6,
    drag: float | None = None,
    lift_slope: float = 0.0,
    moment_slope: float = 0.0,
    saturation_deg: float = DEFAULT_SATURATION_DEG,
) -> RequiredSlope:
    """Compute how negative the slope of the coefficient curve must be for galloping.

    The curve need not be known. For each mode and wind speed the slope is found at which the whole
    linear model, about the equilibrium in that wind, neither grows nor decays.

    Parameters
    ----------
    scene
        The span or line; of its curve only the drag at the attack angle is used. All sections have
        the same slope, except intervals with a curve of their own.
    wind_speeds
        Wind speeds [m/s]; None takes 1 to 20 m/s.
    count
        Number of modes, the lowest in still air.
    drag
        Drag coefficient; None takes that of the scene's curve at the attack angle (of a line, of
        the first span), or 1.0 without a curve.
    lift_slope
        dCL/dalpha [1/rad] with which the slope of the moment is found.
    moment_slope
        dCM/dalpha [1/rad] with which the slope of the lift is found.
    saturation_deg
        Assumed angle of the relative wind [deg] at which the force across the wind changes its
        sign, for the estimate of amplitudes: about 15 deg for a square prism (Parkinson and Smith
        1964), 57 deg for the curve of Example 3 (Liu et al. 2009).

    Raises
    ------
    SceneError
        If an argument is not possible, or there is no stable equilibrium in still air.
    SimulationError
        If no initial equilibrium exists.
    """
    scene = as_scene(scene)
    speeds = _checked_speeds(wind_speeds)
    for name, value in (("lift_slope", lift_slope), ("moment_slope", moment_slope)):
        if not np.isfinite(value):
            raise SceneError(f"{name} = {value} 1/rad: must be a finite number")
    if not 0.0 < saturation_deg < 90.0:
        raise SceneError(
            f"saturation_deg = {saturation_deg}: must be greater than 0 and less than 90 deg"
        )
    drag, remarks = _drag_of(scene, drag)
    search = SlopeSearch(scene, count, drag)
    lift = search.along_wind("lift", speeds, moment_slope)
    moment = search.along_wind("moment", speeds, lift_slope)
    remarks += [
        "lift and moment are assumed to be 0 at the attack angle, and the drag to be constant",
        f"the amplitude limit is an estimate: it assumes that the force across the wind changes its"
        f" sign where the relative wind is rotated by {saturation_deg:g} deg",
        *search.remarks,
    ]
    dataset = _dataset(search, speeds, lift, moment, math.tan(math.radians(saturation_deg)))
    return RequiredSlope(dataset, drag, lift_slope, moment_slope, saturation_deg, remarks)


def _checked_speeds(wind_speeds: Sequence[float] | None) -> Array:
    speeds = np.asarray(
        DEFAULT_WIND_SPEEDS if wind_speeds is None else wind_speeds, dtype=np.float64
    )
    if speeds.ndim != 1 or not len(speeds):
        raise SceneError("wind_speeds: at least one wind speed is needed")
    wrong = speeds[~(np.isfinite(speeds) & (speeds > 0.0))]
    if len(wrong):
        raise SceneError(f"wind_speeds: {wrong[0]} m/s: must be a finite, positive wind speed")
    if np.any(np.diff(speeds) <= 0.0):
        raise SceneError("wind_speeds: must increase from one to the next")
    return speeds


def _drag_of(scene: Scene | LineScene, drag: float | None) -> tuple[float, list[str]]:
    """Drag coefficient, and a remark if it is assumed."""
    if drag is not None:
        if not (np.isfinite(drag) and drag >= 0.0):
            raise SceneError(f"drag = {drag}: must be a finite number, 0 or more")
        return drag, []
    if scene.aerodynamics is None:
        return DEFAULT_DRAG, [f"the drag coefficient is assumed to be {DEFAULT_DRAG:g}"]
    ice = scene.ice if isinstance(scene, Scene) else scene.ice_of_span(1)
    angle = math.radians(ice.attack_angle_deg)
    return float(scene.aerodynamics.curve().drag(angle)), []


def _dataset(
    search: SlopeSearch, speeds: Array, lift: SlopePath, moment: SlopePath, saturation: float
) -> xr.Dataset:
    """Collect the results."""
    import xarray as xr

    modes, table, of_mode = search.modes, ("mode", "wind_speed"), ("mode",)
    values = {
        "family": (of_mode, [mode.family for mode in modes]),
        "loops": (of_mode, [_loops(mode) for mode in modes]),
        "still_air_hz": (of_mode, [mode.frequency_hz for mode in modes]),
        "damping_ratio": (of_mode, [mode.damping_ratio for mode in modes]),
        "span_share": (("mode", "span"), [_span_shares(mode) for mode in modes]),
        "slope": (table, search.drag + lift.slopes),
        "slope_estimate": (table, search.drag + lift.estimates),
        "frequency_hz": (table, lift.frequencies),
        "amplitude_limit": (table, saturation * lift.reaches),
        "moment_slope": (table, moment.slopes),
        "moment_slope_estimate": (table, moment.estimates),
        "moment_frequency_hz": (table, moment.frequencies),
        "divergence_moment_slope": (("wind_speed",), search.divergence(speeds)),
        "observed_amplitude": (("span",), _observed_amplitudes(search)),
    }
    dataset = xr.Dataset(
        values,
        coords={
            "mode": search.numbers,
            "wind_speed": ("wind_speed", speeds, {"units": "m/s"}),
        },
        attrs={"title": search.motion.scene.title},
    )
    dataset = dataset.assign_coords(span=np.arange(1, dataset.sizes["span"] + 1))
    for name, unit in UNITS.items():
        dataset[name].attrs["units"] = unit
    return dataset


def _loops(mode: Mode | LineMode) -> str:
    """Half-waves in each span, such as ``1 1 2``."""
    loops = (mode.loops,) if isinstance(mode, Mode) else mode.loops
    return " ".join(str(number) if number else "-" for number in loops)


def _span_shares(mode: Mode | LineMode) -> Array:
    return np.ones(1) if isinstance(mode, Mode) else mode.span_shares


def _observed_amplitudes(search: SlopeSearch) -> Array:
    """Half the major axis [m] of CIGRE's ellipse for each span; NaN where there is none."""
    model, scene = search.motion.model, search.motion.scene
    spans = model.map.spans
    if model.map.subconductors > 1:
        return np.full(spans, np.nan)
    x, found = model.equilibrium().x, []
    for span in range(1, spans + 1):
        along, height = x[model.map.chain(span).nodes, :2].T
        chord = np.interp(along, along[[0, -1]], height[[0, -1]])
        sag = float(np.max(chord - height))
        try:
            found.append(0.5 * cigre_322_single_loop(sag, scene.conductor.diameter).major)
        except ValueError:  # a sag of few diameters
            found.append(math.nan)
    return np.array(found)
