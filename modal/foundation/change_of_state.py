"""How the tension of a strung conductor changes with temperature and with the mass of ice on it.

The change of state of `gallop_fmu.scene.sag_tension`, for a scene. Spans on both sides are taken to
change alike, so that insulators stay upright and towers still.
"""

from __future__ import annotations

from gallop_fmu import Model, Scene
from gallop_fmu.scene.sag_tension import changed_tension
from gallop_fmu.scene.supports import AdjacentSpanSupport

ACSR_EXPANSION = 18.9e-6
"""Coefficient of linear expansion [1/K] of ACSR with 26 aluminium and 7 steel wires: 23e-6 and 11.5e-6 1/K weighted by
E A, the usual mean (IEC TR 61597:1995), with 60 and 200 GPa and 6.1 times as much aluminium as
steel. Other strandings
have 18e-6 to 21e-6, plain aluminium 23e-6, plain steel 11.5e-6."""


def change_of_state(
    scene: Scene,
    temperature_change: float = 0.0,
    ice_mass: float | None = None,
    expansion: float = ACSR_EXPANSION,
) -> Scene:
    """The same conductor at another temperature, or with another mass of ice.

    Parameters
    ----------
    scene
        The span in its given state, from its tension where that is given, else from its sag.
    temperature_change
        Rise of temperature from the scene's state [K].
    ice_mass
        New ``ice.mass_per_length`` [kg/m]; None keeps the scene's. First moments and inertia of the
        ice stay.
    expansion
        Coefficient of linear expansion [1/K].

    Returns
    -------
    Scene
        With its new ``span.horizontal_tension``, from which the sag follows; the tension of
        adjacent spans that the supports stand for changes in proportion.

    Raises
    ------
    SceneError
        If no tension fits, which a strong cooling or wrong units can cause.
    """
    bare = scene.conductor.mass_per_length
    before = scene.span.horizontal_tension
    if before is None:
        before = Model(scene).equilibrium().horizontal_tension
    iced = scene.ice.mass_per_length if ice_mass is None else ice_mass
    values = {"span.sag": None, "span.horizontal_tension": before, "ice.mass_per_length": iced}
    after = scene.with_values(values)  # refuses an impossible mass
    tension = changed_tension(
        before,
        span=scene.span.length,
        weight=(bare + scene.ice.mass_per_length) * scene.span.gravity,
        new_weight=(bare + iced) * scene.span.gravity,
        axial_stiffness=scene.conductor.axial_stiffness,
        temperature_change=temperature_change,
        expansion=expansion,
        height_difference=scene.span.height_difference,
    )
    beside = {
        f"supports.{end}.adjacent_tension": support.adjacent_tension * tension / before
        for end, support in (("left", scene.supports.left), ("right", scene.supports.right))
        if isinstance(support, AdjacentSpanSupport)
    }
    return after.with_values({"span.horizontal_tension": tension, **beside})
