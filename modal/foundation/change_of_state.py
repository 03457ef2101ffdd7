"""Change of state of a strung conductor: tension at another temperature or mass of ice.

It applies `gallop_fmu.scene.sag_tension` to a scene. The adjacent spans are assumed to change in
the same way, so that insulators stay vertical and towers do not move.
"""

from __future__ import annotations

from gallop_fmu import Model, Scene
from gallop_fmu.input.scene_like import SpanLike, as_span
from gallop_fmu.scene.sag_tension import changed_tension
from gallop_fmu.scene.supports import AdjacentSpanSupport

ACSR_EXPANSION = 18.9e-6
"""Coefficient of linear expansion [1/K] of ACSR with 26 aluminium and 7 steel wires.

The mean of 23e-6 and 11.5e-6 1/K weighted by E A (IEC TR 61597:1995), with 60 and 200 GPa and 6.1
times as much aluminium as steel. Other strandings have 18e-6 to 21e-6, plain aluminium 23e-6, plain
steel 11.5e-6.
"""


def change_of_state(
    scene: SpanLike,
    temperature_change: float = 0.0,
    ice_mass: float | None = None,
    expansion: float = ACSR_EXPANSION,
) -> Scene:
    """Change the temperature of a strung conductor, or its mass of ice.

    Parameters
    ----------
    scene
        The span in its present state, with its tension, or its sag if no tension is given.
    temperature_change
        Rise of temperature from the scene's state [K].
    ice_mass
        New ``ice.mass_per_length`` [kg/m]; None keeps the scene's. First moments and inertia of the
        ice do not change.
    expansion
        Coefficient of linear expansion [1/K].

    Returns
    -------
    Scene
        The span with its new ``span.horizontal_tension``; the sag is computed from it. The tension
        of adjacent spans changes in proportion.

    Raises
    ------
    SceneError
        If no tension satisfies the equation, as with strong cooling or wrong units.
    """
    scene = as_span(
        scene,
        "change_of_state",
        "set section.temperature_deg_c and ice of the line, whose equilibrium follows from them",
    )
    bare = scene.conductor.mass_per_length
    before = scene.span.horizontal_tension
    if before is None:
        before = Model(scene).equilibrium().horizontal_tension
    iced = scene.ice.mass_per_length if ice_mass is None else ice_mass
    values = {"span.sag": None, "span.horizontal_tension": before, "ice.mass_per_length": iced}
    after = scene.with_values(values)  # raises for an impossible mass
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
    adjacent = {
        f"supports.{end}.adjacent_tension": support.adjacent_tension * tension / before
        for end, support in (("left", scene.supports.left), ("right", scene.supports.right))
        if isinstance(support, AdjacentSpanSupport)
    }
    return after.with_values({"span.horizontal_tension": tension, **adjacent})
