"""Amplitudes of a beating swing, from a short simulation that starts near its unstable orbit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gallop_fmu import Model, Outcome, Scene, SimulationError
from modal.screening.continuation import Cycle

ELEMENTS = 6
"""Elements of the mesh."""

CYCLE_STEPS, CYCLE_RECORDS = 80, 16
"""Time steps and records in a vertical cycle."""

CYCLES, SETTLING_SHARE = 500, 0.4
"""Vertical cycles simulated, and the share of them before amplitudes are read."""


def beating_cycle(scene: Scene, wind: float, unsteady: Cycle) -> Cycle:
    """Replace the amplitudes of an unstable motion by those that the span reaches about it.

    Parameters
    ----------
    scene
        The span; its loads and support motions are inactive.
    wind
        Steady wind speed [m/s].
    unsteady
        The unstable periodic motion; the simulation starts from its amplitudes.

    Returns
    -------
    Cycle
        Largest amplitudes of the simulation; `unsteady` itself where it cannot start (a slack
        conductor) or does not complete.
    """
    coarse = {
        "numerics.elements": min(ELEMENTS, scene.numerics.elements),
        "numerics.time_step": 1.0 / (CYCLE_STEPS * unsteady.frequency_hz),
        "initial": {
            "seed_vertical": -unsteady.vertical,
            "seed_horizontal": unsteady.horizontal,
        },
        "wind": {"speed": wind, "air_density": scene.wind.air_density},
        "loads": [],
        "supports.left.motion": None,
        "supports.right.motion": None,
    }
    model = Model(scene.with_values(coarse))
    try:
        start = model.start()
    except SimulationError:
        return unsteady
    run = start.run(
        CYCLES * CYCLE_RECORDS,
        CYCLE_STEPS // CYCLE_RECORDS,
        np.array([1, 2, 3], np.int32),
        np.array([model.middle], np.int32),
    )
    if run.report.outcome is not Outcome.COMPLETED:
        return unsteady
    late = run.node_values[int(SETTLING_SHARE * len(run.node_values)) :, :, 0]
    vertical, horizontal, twist = (0.5 * float(size) for size in np.ptp(late, axis=0))
    return replace(unsteady, vertical=vertical, horizontal=horizontal, twist=twist)
