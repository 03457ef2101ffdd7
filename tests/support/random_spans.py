"""Random spans by Latin hypercube: 20 to 1,500 m, taut to deep, calm to 60 m/s, bare to iced.

A seed names a series of hypercubes of `BLOCK` scenes each; seed and number name one scene until
what is drawn changes. The scene of a test is therefore stored as data in tests/extremes/data.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.random import Generator
from numpy.typing import NDArray
from scipy.stats import qmc

from gallop_fmu import Inputs

BLOCK = 500
"""Scenes of one Latin hypercube; more runs take further hypercubes."""

WORK, FEWEST, MOST = 4000, 30, 120
"""Elements times steps of a run, and the fewest and most steps."""

GRAVITY = 9.81

STEEPEST = 0.8
"""Largest height difference over the span's length."""

AXES = (
    "length", "sag", "height", "given", "diameter", "density", "modulus", "torsion", "gyration",
    "ice", "eccentricity",
    "direction", "attack", "curve", "wind", "speed", "damping", "twist_damping", "left", "left_x1",
    "left_x3", "right",
    "right_x1", "right_x3", "motion", "load", "elements", "step", "start", "seed_vertical",
    "seed_horizontal",
    "seed_twist",
)  # fmt: skip
"""Coordinates of the hypercube, evenly spread over 0 to 1; curves and histories are drawn apart."""

Point = dict[str, float]
Data = dict[str, Any]


@dataclass(frozen=True)
class Stress:
    """A scene as plain data, its number of steps, and its inputs in addition to the scene's laws.

    A wind that turns round has no place in a scene, whose speeds are not negative. It is driven by
    inputs instead: the speed falls steadily from `reversal` to minus that over the run, and the ice
    turns by `turn` [rad] meanwhile.
    """

    name: str
    data: Data
    steps: int
    reversal: float = 0.0
    turn: float = 0.0

    @property
    def step(self) -> float:
        """Time step [s]."""
        return float(self.data["numerics"]["time_step"])

    @property
    def duration(self) -> float:
        """Simulated time [s]."""
        return self.steps * self.step

    def inputs(self, time: float) -> Inputs:
        """Wind and attack angle of a driven run at a time [s], and their rates from there on."""
        done = time / self.duration
        return Inputs(
            time,
            self.reversal * (1.0 - 2.0 * done),
            math.radians(self.data["ice"]["attack_angle_deg"]) + self.turn * done,
            np.zeros((2, 3)),
            wind_speed_rate=-2.0 * self.reversal / self.duration,
            attack_angle_rate=self.turn / self.duration,
        )


@dataclass(frozen=True)
class Line:
    """Data of the sections: metal and ice [kg/m], tension [N], axial stiffness [N]."""

    length: float
    diameter: float
    metal: float
    ice: float
    tension: float
    axial_stiffness: float

    @property
    def wave_speed(self) -> float:
        """Speed of transverse waves [m/s]."""
        return math.sqrt(self.tension / (self.metal + self.ice))


@lru_cache(maxsize=4)
def _hypercube(seed: int, block: int) -> NDArray[np.float64]:
    cube = qmc.LatinHypercube(len(AXES), seed=np.random.default_rng([seed, block]))
    return np.asarray(cube.random(BLOCK))


def stress_scene(seed: int, number: int, numerics: Data | None = None) -> Stress:
    """Scene `number` of a seed, with some values of its numerics replaced."""
    x = dict(zip(AXES, map(float, _hypercube(seed, number // BLOCK)[number % BLOCK]), strict=True))
    rng = np.random.default_rng([seed, number, 1])
    elements, step = (
        math.floor(logarithmic(x["elements"], 2.0, 201.0)),
        logarithmic(x["step"], 1e-4, 0.2),
    )
    steps = max(FEWEST, min(MOST, WORK // elements))
    span, line = _span(x)
    wind, reversal = _wind(x, rng, steps * step)
    attack = 360.0 * x["attack"] - 180.0
    data = {
        "title": f"stress {seed}-{number}",
        "span": span,
        **_section(x, line, attack),
        "wind": wind,
        "aerodynamics": _curve(x, rng, attack),
        "supports": {end: _support(x, rng, end, line, steps * step) for end in ("left", "right")},
        "damping": _damping(x, line),
        "loads": _loads(x, rng, line, steps * step),
        "initial": _initial(x, line),
        "numerics": {"elements": elements, "time_step": step} | (numerics or {}),
    }
    return Stress(
        f"{seed}-{number}",
        data,
        steps,
        reversal,
        rng.uniform(-3.0, 3.0) * math.pi if reversal else 0.0,
    )


def logarithmic(x: float, low: float, high: float) -> float:
    """From low to high as x goes from 0 to 1, evenly in the logarithm."""
    return low * (high / low) ** x


def rest_of(x: float, share: float) -> float:
    """Spread the draws above a share over 0 to 1 again; the share itself gives 0."""
    return max(0.0, (x - share) / (1.0 - share))


def signed(x: float) -> float:
    """From -1 to 1 as x goes from 0 to 1."""
    return 2.0 * x - 1.0


def _span(x: Point) -> tuple[Data, Line]:
    length = logarithmic(x["length"], 20.0, 1500.0)
    height = STEEPEST * length * signed(rest_of(x["height"], 0.4)) if x["height"] > 0.4 else 0.0
    sag, diameter = (
        logarithmic(x["sag"], 0.002, 0.12) * length,
        logarithmic(x["diameter"], 0.008, 0.05),
    )
    area = 0.75 * math.pi / 4.0 * diameter**2  # three quarters of a stranded conductor are metal
    metal = area * (2700.0 + 5100.0 * x["density"])  # aluminium to steel
    ice = 3.0 * rest_of(x["ice"], 0.15) * metal
    tension = (metal + ice) * GRAVITY * length * math.hypot(length, height) / (8.0 * sag)
    span = {"length": length, "height_difference": height}
    if x["given"] < 0.7:
        span["sag"] = sag
    if x["given"] > 0.4:
        span["horizontal_tension"] = tension
    return span, Line(length, diameter, metal, ice, tension, area * (50e9 + 150e9 * x["modulus"]))


def _section(x: Point, line: Line, attack: float) -> Data:
    square = line.diameter**2
    arm = 0.6 * line.diameter * x["eccentricity"]  # of the centre of the ice
    direction = 2.0 * math.pi * x["direction"]
    return {
        "conductor": {
            "diameter": line.diameter,
            "mass_per_length": line.metal,
            "axial_stiffness": line.axial_stiffness,
            "torsional_stiffness": (
                logarithmic(x["torsion"], 0.003, 0.048) * line.axial_stiffness * square
            ),  # to solid
            "torsional_inertia": (0.09 + 0.06 * x["gyration"]) * line.metal * square,
        },
        "ice": {
            "mass_per_length": line.ice,
            "torsional_inertia": line.ice * (arm**2 + 0.1 * square),
            "first_moment_x2": line.ice * arm * math.sin(direction),
            "first_moment_x3": line.ice * arm * math.cos(direction),
            "attack_angle_deg": attack,
        },
    }


def _wind(x: Point, rng: Generator, duration: float) -> tuple[Data, float]:
    """Wind section, and the speed that is reversed by inputs."""
    speed, kind = 60.0 * x["speed"], math.floor(9.0 * x["wind"])
    start, other = float(rng.uniform(0.1, 0.6) * duration), float(rng.uniform(0.0, 60.0))
    if kind == 0:
        return {"speed": 0.0}, 0.0
    if kind == 1:
        return {"speed": speed}, 0.0
    if kind == 2:
        return {
            "history": {
                "kind": "ramp",
                "initial": other,
                "final": speed,
                "start": start,
                "duration": 0.0,
            }
        }, 0.0
    if kind == 3:
        gust = {
            "start": start,
            "rise": 0.1 * duration,
            "fall_start": start + 0.15 * duration,
            "fall": 0.1 * duration,
        }
        return {
            "history": {
                "kind": "pulse",
                "initial": min(speed, other),
                "peak": max(speed, other),
                **gust,
            }
        }, 0.0
    if kind == 4:
        wave = {
            "mean": 0.5 * speed,
            "amplitude": 0.5 * speed,
            "frequency_hz": logarithmic(x["speed"], 0.5, 50.0),
        }
        wave["frequency_hz"] /= duration
        return {"history": {"kind": "harmonic", **wave}}, 0.0
    if kind == 5:
        time = np.linspace(0.0, duration, 12)
        return {
            "history": {
                "kind": "table",
                "time": list(time),
                "value": list(rng.uniform(0.0, speed, 12)),
            }
        }, 0.0
    if kind == 6:
        ends = (0.0, speed) if rng.random() < 0.5 else (speed, 0.0)
        rise = {
            "kind": "ramp",
            "initial": ends[0],
            "final": ends[1],
            "start": 0.3 * start,
            "duration": 0.5 * duration,
        }
        return {"history": rise}, 0.0
    if kind == 7:
        time, value = np.linspace(0.0, duration, 12), rng.uniform(0.0, speed, 12)
        value[[0, -1]] = 0.0
        value[5:7] *= rng.random() < 0.5  # half of them are calm for a while
        return {"history": {"kind": "table", "time": list(time), "value": list(value)}}, 0.0
    return {"speed": 0.0}, speed


def _curve(x: Point, rng: Generator, attack: float) -> Data:
    """Coefficients over the circle, about the attack angle, or as a cubic that grows outside it."""
    kind, outside = math.floor(4.0 * x["curve"]), str(rng.choice(["error", "hold"]))
    if kind < 2:
        first, last = (-180.0, 180.0) if kind == 0 else (attack - 90.0, attack + 70.0)
        angle = np.linspace(first, last, 37)
        harmonics = np.radians(np.outer(angle, [1.0, 2.0, 3.0]))
        lift, moment = (
            np.sin(harmonics) @ rng.normal(0.0, size) for size in ([0.8, 0.8, 0.4], [0.2, 0.2, 0.1])
        )
        drag = 1.2 + np.cos(harmonics) @ rng.uniform(-0.3, 0.3, 3)
        values = {"lift": lift, "drag": drag, "moment": moment}
        if kind == 0:
            outside = "periodic"
            values = {name: np.append(value[:-1], value[0]) for name, value in values.items()}
        return {
            "kind": "table", "outside": outside, "angle_deg": list(angle),
            **{name: list(value) for name, value in values.items()},
        }  # fmt: skip
    reach = float(rng.uniform(30.0, 120.0))
    return {
        "kind": "polynomial", "outside": outside, "centre_deg": attack,
        "valid_from_deg": attack - reach,
        "valid_to_deg": attack + reach, "lift": list(rng.normal(0.0, [0.5, 3.0, 1.0, 2.0])),
        "drag": [float(rng.uniform(0.8, 1.6)), float(rng.normal(0.0, 0.2)), 0.5],
        "moment": list(rng.normal(0.0, [0.1, 0.3, 0.1, 0.2])),
    }  # fmt: skip


def _support(x: Point, rng: Generator, end: str, line: Line, duration: float) -> Data:
    support: Data = {"kind": "rigid"}
    if x[end] > 0.7:
        support = {
            "kind": "adjacent_span", "adjacent_span": line.length * rng.uniform(0.5, 1.5),
            "adjacent_tension": line.tension, "insulator_length": logarithmic(x[f"{end}_x1"], 0.3,
            6.0),
            "insulator_weight": 2000.0 * x[f"{end}_x3"],
        }  # fmt: skip
    elif x[end] > 0.4:
        support = {
            "kind": "springs", "stiffness_x1": logarithmic(x[f"{end}_x1"], 1e3, 1e9),
            "stiffness_x3": logarithmic(x[f"{end}_x3"], 1e2, 1e9),
        }  # fmt: skip
    if x["motion"] > 0.8:  # within what an elastic wire can follow
        give = line.tension / line.axial_stiffness * line.length
        sway = {
            "kind": "pulse",
            "rise": 0.4 * duration,
            "fall_start": 0.5 * duration,
            "fall": 0.4 * duration,
        }
        support["motion"] = {
            f"x{i}": {**sway, "peak": 0.2 * give * rng.uniform(-1.0, 1.0)} for i in (1, 2, 3)
        }
    return support


def _damping(x: Point, line: Line) -> Data:
    first = line.wave_speed / (2.0 * line.length)
    pairs = {}
    for name, draw, frequency in (
        ("translation", "damping", first),
        ("twist", "twist_damping", 10.0 * first),
    ):
        ratio = 0.1 * rest_of(x[draw], 0.2)
        if ratio > 0.0:
            pair = {"low_frequency": frequency, "high_frequency": 2.0 * frequency}
            pairs[name] = {"low_ratio": ratio, "high_ratio": ratio, **pair}
    return pairs


def _loads(x: Point, rng: Generator, line: Line, duration: float) -> list[Data]:
    """Up to a fifth of the weight, distributed or at one point, as a pulse or a harmonic."""
    if x["load"] < 0.6:
        return []
    points = int(rng.integers(1, 20))
    size = 0.2 * (line.metal + line.ice) * GRAVITY * line.length / points
    if x["load"] > 0.8:
        law = {
            "kind": "harmonic",
            "amplitude": 1.0,
            "frequency_hz": float(rng.uniform(1.0, 8.0)) / duration,
        }
    else:
        law = {
            "kind": "pulse",
            "peak": 1.0,
            "rise": 0.3 * duration,
            "fall_start": 0.503 * duration,
            "fall": 0.0,
        }
    place = (
        {"position": float(rng.uniform(0.02, 0.98))} if points == 1 else {"evenly_spaced": points}
    )
    torque = size * line.diameter * rng.uniform(-1.0, 1.0)
    return [
        {"force": list(size * rng.uniform(-1.0, 1.0, 3)), "torque": torque, "law": law, **place}
    ]


def _initial(x: Point, line: Line) -> Data:
    """Seeds up to the amplitude that doubles a string's tension, or a sixth of a turn."""
    reach = 0.1 * line.length * math.sqrt(line.tension / line.axial_stiffness)
    return {
        "wind": "mean_wind_equilibrium" if x["start"] > 0.6 else "at_once",
        "seed_vertical": reach * signed(x["seed_vertical"]) ** 3,
        "seed_horizontal": reach * signed(x["seed_horizontal"]) ** 3,
        "seed_twist": signed(x["seed_twist"]) ** 3,
    }
