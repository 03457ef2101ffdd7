"""A taut span, whose free vibration is close to that of a string and of a shaft."""

from typing import Any

from gallop_fmu import Scene

Section = dict[str, Any]


def taut_span(
    span: Section | None = None, conductor: Section | None = None, **sections: Section
) -> Scene:
    """100 m under 92 kN with a sag of 0.2 m; the first twist mode of the shaft has 5 Hz.

    `span` and `conductor` replace single values; with a gravity of 0.01 m/s2 the modes are sines.
    """
    return Scene.from_dict({
        "title": "a taut span",
        "span": {"length": 100.0, "horizontal_tension": 92000.0} | (span or {}),
        "conductor": {
            "diameter": 0.028, "mass_per_length": 1.5, "axial_stiffness": 4e7,
            "torsional_stiffness": 150.0, "torsional_inertia": 1.5e-4,
        } | (conductor or {}),
        **sections,
    })  # fmt: skip
