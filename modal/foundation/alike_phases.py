"""One phase for all, where all phases of a line move alike."""

from __future__ import annotations

from gallop_fmu import LineScene


def one_phase(scene: LineScene) -> LineScene:
    """Return the line with the first phase only, if all phases would move alike.

    Phases move alike if nothing connects them, nothing acts on a single one, and the wind is that
    of all heights.
    """
    wind = scene.wind
    alone = (
        len(scene.phases) > 1
        and wind.profile is None
        and wind.turbulence is None
        and not any(getattr(load, "phase", None) for load in scene.loads)
        and not any(getattr(shed, "phase", None) for shed in scene.shedding)
        and all(
            device.kind != "interphase_spacer" and getattr(device, "phase", None) is None
            for device in scene.devices
        )
    )
    if not alone:
        return scene
    return scene.with_values({"phases": [{"name": scene.phases[0].name}]})
