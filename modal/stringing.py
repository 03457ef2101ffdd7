"""How the tension of a strung conductor changes with temperature and with the mass of ice on it.

The conductor keeps its unstretched length but for thermal expansion: the change-of-state equation of sag and tension,
here on the elastic catenary. Spans on both sides are taken to change alike, so that insulators stay upright and towers
still. Creep and the birdcaging of aluminium at high temperature are left out.
"""

from __future__ import annotations

import math

from gallop_fmu import Model, Scene, SceneError
from gallop_fmu.supports import AdjacentSpanSupport

ACSR_EXPANSION = 18.9e-6
"""Coefficient of linear expansion [1/K] of ACSR with 26 aluminium and 7 steel wires: 23e-6 and 11.5e-6 1/K weighted by
E A, the usual mean (IEC TR 61597:1995), with 60 and 200 GPa and 6.1 times as much aluminium as steel. Other strandings
have 18e-6 to 21e-6, plain aluminium 23e-6, plain steel 11.5e-6."""


def change_of_state(
    scene: Scene, temperature_change: float = 0.0, ice_mass: float | None = None, expansion: float = ACSR_EXPANSION
) -> Scene:
    """The same conductor at another temperature, or with another mass of ice.

    Parameters
    ----------
    scene
        The span in its given state, from its tension where that is given, else from its sag.
    temperature_change
        Rise of temperature from the scene's state [K].
    ice_mass
        New ``ice.mass_per_length`` [kg/m]; None keeps the scene's. First moments and inertia of the ice stay.
    expansion
        Coefficient of linear expansion [1/K].

    Returns
    -------
    Scene
        With its new ``span.horizontal_tension``, from which the sag follows; the tension of adjacent spans that the
        supports stand for changes in proportion.

    Raises
    ------
    SceneError
        If no tension fits, which a strong cooling or wrong units can cause.
    """
    from scipy.optimize import brentq  # slow to import

    if not (math.isfinite(temperature_change) and math.isfinite(expansion)):
        raise SceneError(f"temperature_change = {temperature_change} K, expansion = {expansion} 1/K: must be finite")
    bare = scene.conductor.mass_per_length
    before = scene.span.horizontal_tension
    if before is None:
        before = Model(scene).equilibrium().horizontal_tension
    iced = scene.ice.mass_per_length if ice_mass is None else ice_mass
    values = {"span.sag": None, "span.horizontal_tension": before, "ice.mass_per_length": iced}
    after = scene.with_values(values)  # refuses an impossible mass
    bare_length = unstretched_length(scene, before, bare + scene.ice.mass_per_length)
    wanted = bare_length * math.exp(expansion * temperature_change)

    def excess(tension: float) -> float:
        return unstretched_length(scene, tension, bare + iced) - wanted

    # slacker than any line, where the conductor is almost twice as long as the span; tighter than it can bear
    low, high = 0.25 * (bare + iced) * scene.span.gravity * scene.span.length, 0.02 * scene.conductor.axial_stiffness
    if not excess(low) > 0.0 > excess(high):
        raise SceneError(
            f"no tension fits a temperature change of {temperature_change} K and {iced} kg/m of ice: the unstretched "
            f"length would be {wanted:.6g} m in a span of {scene.span.length} m; check the units"
        )
    tension = float(brentq(excess, low, high, rtol=1e-14))
    beside = {
        f"supports.{end}.adjacent_tension": support.adjacent_tension * tension / before
        for end, support in (("left", scene.supports.left), ("right", scene.supports.right))
        if isinstance(support, AdjacentSpanSupport)
    }
    return after.with_values({"span.horizontal_tension": tension, **beside})


def unstretched_length(scene: Scene, tension: float, mass: float) -> float:
    """Length [m] that the conductor would have without tension, from a horizontal tension [N] and a mass [kg/m].

    The catenary's length less its elastic stretch, the integral of T/EA. Fast enough to be a step of a root search.
    """
    span = scene.span
    c = tension / (mass * span.gravity)
    half = 0.5 * span.length / c
    middle = math.asinh(0.5 * span.height_difference / (c * math.sinh(half)))
    ends = middle - half, middle + half
    length = c * (math.sinh(ends[1]) - math.sinh(ends[0]))
    # T = H cosh(x/c) and ds = cosh(x/c) dx
    integral = 0.5 * tension * (span.length + 0.5 * c * (math.sinh(2.0 * ends[1]) - math.sinh(2.0 * ends[0])))
    return length - integral / scene.conductor.axial_stiffness
