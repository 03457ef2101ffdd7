"""Channels of a span or line that can be recorded; node and span channels in the kernel's order."""

from __future__ import annotations

from typing import NamedTuple


class Channel(NamedTuple):
    """One quantity that can be recorded."""

    name: str
    unit: str
    meaning: str


NODE_CHANNELS = (
    Channel("u1", "m", "displacement along the span, from the initial equilibrium"),
    Channel("u2", "m", "vertical displacement, upwards, from the initial equilibrium"),
    Channel("u3", "m", "horizontal displacement, with the wind, from the initial equilibrium"),
    Channel("theta", "rad", "twist, right-handed about the span axis"),
    Channel("v1", "m/s", "velocity along the span"),
    Channel("v2", "m/s", "vertical velocity, upwards"),
    Channel("v3", "m/s", "horizontal velocity, with the wind"),
    Channel("omega", "rad/s", "twist velocity"),
    Channel("a1", "m/s2", "acceleration along the span"),
    Channel("a2", "m/s2", "vertical acceleration, upwards"),
    Channel("a3", "m/s2", "horizontal acceleration, with the wind"),
    Channel("omega_rate", "rad/s2", "twist acceleration"),
    Channel("tension", "N", "tension"),
    Channel(
        "angle_of_attack",
        "rad",
        "attack angle, from the ice angle, the twist and the direction of the relative wind",
    ),
)

SPAN_CHANNELS = (
    Channel("wind_speed", "m/s", "wind speed, without profile and gusts"),
    Channel("left_f1", "N", "force of the cable on the left end along the span"),
    Channel("left_f2", "N", "force of the cable on the left end, upwards"),
    Channel("left_f3", "N", "force of the cable on the left end, with the wind"),
    Channel("right_f1", "N", "force of the cable on the right end along the span"),
    Channel("right_f2", "N", "force of the cable on the right end, upwards"),
    Channel("right_f3", "N", "force of the cable on the right end, with the wind"),
    Channel("kinetic_energy", "J", "kinetic energy, including that of the rotating eccentric ice"),
    Channel(
        "potential_energy",
        "J",
        "strain and gravitational energy, from the initial equilibrium; without the work of the"
        " static reactions on moving towers",
    ),
    Channel("newton_iterations", "1", "Newton iterations of the last step"),
    Channel("substeps", "1", "sub-steps of the last step"),
)

END_FORCES = tuple(f"{end}_f{axis}" for end in ("left", "right") for axis in (1, 2, 3))
"""Span channels of the forces on the ends."""

SYSTEM_CHANNELS = SPAN_CHANNELS[1 + len(END_FORCES) :]
"""Channels of the whole system: energies, and the work of the last step."""

DEVICE_CHANNELS = (
    *(f"tower_force_x{axis}" for axis in (1, 2, 3)),
    *("string_pull", "string_lean_along", "string_lean_across", "turn"),
)
"""Channels of a device, in the order of gallop_device_channel."""

LINE_CHANNELS = (
    Channel("wind_speed", "m/s", "wind speed, without profile and gusts"),
    Channel("tower_force_x1", "N", "force of the conductors on the tower along the line"),
    Channel("tower_force_x2", "N", "force of the conductors on the tower, upwards"),
    Channel("tower_force_x3", "N", "force of the conductors on the tower, with the wind"),
    Channel(
        "string_pull",
        "N",
        "pull along the string, positive in tension; of a V-string in the bar with the smaller"
        " one; of several strings of a bundle their sum",
    ),
    Channel(
        "string_lean_along",
        "rad",
        "angle of the string from straight down along the line, towards +x1",
    ),
    Channel(
        "string_lean_across",
        "rad",
        "angle of the string from straight down across the line, with the wind",
    ),
    Channel("yoke_turn", "rad", "rotation of the yoke about x1"),
    Channel("spacer_turn", "rad", "rotation of the spacer about x1"),
    *SYSTEM_CHANNELS,
)
"""Channels of a line beside those of its nodes."""

DESCRIBED = {channel.name: channel for channel in (*NODE_CHANNELS, *SPAN_CHANNELS, *LINE_CHANNELS)}
"""Every channel by its name."""

NODE_INDEX = {channel.name: index for index, channel in enumerate(NODE_CHANNELS)}
SPAN_INDEX = {channel.name: index for index, channel in enumerate(SPAN_CHANNELS)}
LINE_INDEX = {channel.name: index for index, channel in enumerate(LINE_CHANNELS)}
