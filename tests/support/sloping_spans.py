"""Example 3 on a slope with constant slopes of lift and drag, and the growth of its motion."""

import math

import numpy as np

import gallop_fmu as gf

SLOPE_OF_LIFT, DRAG, LENGTH = -4.5, 1.0, 125.88


def sloping(rise, **values):
    """Example 3 without eccentric ice, stiff in twist, with constant slopes of lift and drag."""
    return gf.load_scene("example3").with_values(
        {
            "span.sag": None,
            "ice.first_moment_x2": 0.0,
            "ice.first_moment_x3": 0.0,
            "conductor.torsional_stiffness": 15300.0,
            "aerodynamics.moment": [0.0],
            "aerodynamics.lift": [0.0, SLOPE_OF_LIFT],
            "aerodynamics.drag": [DRAG],
            "numerics.elements": 30,
            "span.height_difference": rise * LENGTH,
        }
        | {key.replace("__", "."): value for key, value in values.items()}
    )


def proportional_to_mass(rate, low, high):
    """Damping b1 M [1/s] as two ratios, proportional to 1/f."""
    return {
        "low_ratio": rate / (4.0 * math.pi * low),
        "low_frequency": low,
        "high_ratio": rate / (4.0 * math.pi * high),
        "high_frequency": high,
    }


def growth(scene, first=100.0, last=200.0, piece=20.0):
    """Growth rate [1/s] of the amplitude of mid-span u2 in a simulation."""
    result = gf.simulate(scene, stop_time=last)
    time, u2 = result.dataset.time.values, result.midspan()["u2"].values
    starts = np.arange(first, last - 0.5 * piece, piece)
    sizes = [np.ptp(u2[(time >= start) & (time < start + piece)]) for start in starts]
    return np.polyfit(starts, np.log(sizes), 1)[0]
