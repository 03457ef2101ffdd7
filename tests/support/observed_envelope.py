"""Amplitudes that the assumed curve predicts, compared with CIGRE 322's envelope of observed ones.

The envelope of a single conductor is, peak to peak, 80 d ln(8 sag/(50 d)) with the diameter d of
the bare conductor (`gallop_fmu.simulation.clearance`). It contains neither wind speed nor ice. The
lines below cover ratios of sag to diameter from 50 to 500.
"""

from __future__ import annotations

from typing import NamedTuple

import gallop_fmu as gf
from gallop_fmu.line.conductors import find_conductor
from gallop_fmu.simulation.clearance import cigre_322_single_loop

LINES = [
    (conductor, span) for conductor in ("Hawk", "Drake", "Bluejay") for span in (150, 225, 300, 400)
]
"""Conductor and span [m]; diameters of 22, 28 and 32 mm."""

STRINGING_PERCENT = 20.0
WIND_SPEED = 10.0
"""Chosen: the envelope has no wind speed."""

THICKNESS_RATIO = 0.1
"""Ice thickness over the diameter: the twist by the weight and inertia of the ice remains small."""

STOP_TIME, WINDOW = 300.0, 80.0
"""Duration of a run, and the time at its end in which the amplitude is taken [s]."""


class Predicted(NamedTuple):
    """Largest vertical motion [m] of a line, peak to peak, and the envelope [m]."""

    sag: float
    diameter: float
    amplitude: float
    envelope: float
    motion: str

    @property
    def ratio(self) -> float:
        """Prediction over envelope."""
        return self.amplitude / self.envelope


def predict(
    conductor: str,
    span: float,
    *,
    thickness_ratio: float = THICKNESS_RATIO,
    wind_speed: float = WIND_SPEED,
    attack_angle_deg: float = 0.0,
) -> Predicted:
    """Simulate a line between dead ends with the assumed curve."""
    diameter = find_conductor(conductor).diameter
    scene = gf.Scene.from_dict(
        {
            "line": {
                "conductor": conductor,
                "span": float(span),
                "stringing_percent": STRINGING_PERCENT,
                "ice_thickness": thickness_ratio * diameter,
                "attack_angle_deg": attack_angle_deg,
                "wind_speed": wind_speed,
                "coefficients": "assumed",
            },
            "conductor": {"slack": "tension_only"},
            "initial": {
                "seed_vertical": 1.0,
                "seed_horizontal": 0.05,
                "wind": "mean_wind_equilibrium",
            },
            "numerics": {"time_step": 0.02},
        }
    )
    result = gf.simulate(scene, stop_time=STOP_TIME, record_nodes="all")
    dataset = result.dataset
    u2 = dataset.u2.where(dataset.time > STOP_TIME - WINDOW, drop=True)
    amplitude = float((u2.max("time") - u2.min("time")).max())
    sag = float(dataset.attrs["sag"])
    envelope = cigre_322_single_loop(sag, diameter).major
    return Predicted(sag, diameter, amplitude, envelope, str(result.motion))
