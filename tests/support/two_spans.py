"""Two spans of the conductor of Example 2 with a curve over the whole turn, for studies."""

import numpy as np

import gallop_fmu as gf

PHASES = [{"name": "low"}, {"name": "top <1>", "offset": [3.0, 0.5]}]


def smooth_curve(slope=3.0, to=180):
    """CL = -slope/2 sin 2x, CD = 1: CL' + CD (Den Hartog) is 1 - slope at 0, 1 + slope at 90."""
    angle = np.arange(-to, to + 1, 15.0)
    return {
        "kind": "table",
        "angle_deg": angle.tolist(),
        "lift": np.round(-0.5 * slope * np.sin(2.0 * np.radians(angle)), 9).tolist(),
        "drag": [1.0] * len(angle),
        "moment": [0.0] * len(angle),
    }


def two_spans():
    """Two spans of the conductor of Example 2 with a curve over the whole turn."""
    return gf.LineScene.from_dict(
        {
            "title": "two <spans>",
            "section": {
                "horizontal_tension": 21730.0,
                "gravity": 9.81,
                "rated_strength": 80000.0,
                "spans": [{"length": 125.88}, {"length": 110.0, "height_difference": 4.0}],
                "suspensions": [{"kind": "string", "length": 2.1, "weight": 490.0}],
            },
            "phases": PHASES,
            "conductor": {
                "diameter": 0.0286,
                "mass_per_length": 1.53,
                "axial_stiffness": 13.3e6,
                "torsional_stiffness": 101.0,
                "torsional_inertia": 0.57e-4,
            },
            "ice": {"mass_per_length": 0.3},
            "wind": {"speed": 4.0},
            "aerodynamics": smooth_curve(),
            "damping": {
                "translation": {
                    "low_ratio": 0.005,
                    "low_frequency": 0.4,
                    "high_ratio": 0.005,
                    "high_frequency": 0.8,
                },
                "twist": {
                    "low_ratio": 0.04,
                    "low_frequency": 3.0,
                    "high_ratio": 0.04,
                    "high_frequency": 6.0,
                },
            },
            "initial": {"seed_vertical": 0.05},
            "numerics": {"elements": 6, "time_step": 0.02},
            "run": {"stop_time": 60.0, "record_every": 2},
        }
    )
