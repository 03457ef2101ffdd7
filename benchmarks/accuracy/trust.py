"""Write trust.md, the table of comparisons in the README.

Usage: python benchmarks/accuracy/trust.py (about 10 s)
"""

from pathlib import Path

import numpy as np

import gallop_fmu as gf
import modal
from gallop_fmu.scene.sag_tension import changed_tension

PEERS = Path(__file__).parents[2] / "tests" / "peers" / "data"
POUND, FOOT = 4.4482216, 0.3048
RECORD = Path(__file__).with_suffix(".md")
RIGID_X3 = 1e9
"""Stiffness [N/m] of a spring that holds like a rigid support."""


def relative_rms(found: np.ndarray, reference: np.ndarray) -> float:
    return float(np.sqrt(np.mean((found - reference) ** 2) / np.mean(reference**2)))


def example1(law: str) -> tuple[float, float, float]:
    """Difference of u2 and u3 from OpenSees and maximum twist [deg]; 20 elements, 2.5 ms."""
    scene = gf.load_scene("example1")
    if law == "step":
        rise = {"kind": "ramp", "initial": 0.0, "final": 1.0, "duration": 1.0}
        load = {"force": [0.0, 1.0, 2.0], "torque": 1.0, "evenly_spaced": 39, "law": rise}
        scene = scene.with_values({"loads": [load]})
    motion = gf.simulate(scene, stop_time=10.0, record_every=4).midspan()
    peer = np.genfromtxt(PEERS / f"example1_{law}_opensees.csv", delimiter=",", skip_header=1)
    u2, u3 = (
        relative_rms(motion[name].values, peer[:, 1 + i]) for i, name in enumerate(("u2", "u3"))
    )
    return u2, u3, float(np.degrees(motion.theta.max()))


def amplitudes(name: str, stop_time: float, **values: object) -> tuple[float, float, float]:
    scene = gf.load_scene(name).with_values(
        {key.replace("__", "."): value for key, value in values.items()}
    )
    steady = gf.simulate(scene, stop_time=stop_time).steady(100.0)
    return (
        steady["u2"].amplitude,
        steady["u3"].amplitude,
        steady["u3"].frequency_hz / steady["u2"].frequency_hz,
    )


def sag_tension() -> list[tuple[str, str, str]]:
    """Change of state against Table 14.5 of Grigsby (ed.) and against a stringing table in kg."""
    drake = gf.find_conductor("Drake")
    wire = {
        "span": 700.0 * FOOT,
        "weight": 1.094 * POUND / FOOT,
        "expansion": drake.thermal_expansion,
    }
    drake_rows = []
    for fahrenheit, load, published in (
        (0.0, 1.094, 7301.0),
        (120.0, 1.094, 4330.0),
        (0.0, 2.509, 11318.0),
    ):
        changes = {
            "new_weight": load * POUND / FOOT,
            "temperature_change": (fahrenheit - 60.0) / 1.8,
        }
        found = (
            changed_tension(
                5429.0 * POUND, axial_stiffness=drake.axial_stiffness, **wire, **changes
            )
            / POUND
        )
        drake_rows.append((published, found))
    bare = {
        "axial_stiffness": 7700.0 * 243.0,
        "weight": 0.987,
        "new_weight": 0.987,
        "expansion": 18.9e-6,
    }
    strung = changed_tension(1762.069, span=300.0, temperature_change=80.0 - 27.0, **bare)
    return [
        (
            (
                "Drake, 213 m: tension bare at -18 C / bare at 49 C / at -18 C with ice and wind"
                " (36.6 N/m), Grigsby (ed.), Table 14.5"
            ),
            " / ".join(f"{pounds * POUND / 1e3:.2f}" for pounds, _ in drake_rows) + " kN",
            " / ".join(f"{pounds * POUND / 1e3:.2f}" for _, pounds in drake_rows) + " kN",
        ),
        (
            "Stringing table, 300 m, strung at 27 C: tension at 80 C",
            "1363.5 kg",
            f"{strung:.1f} kg",
        ),
    ]


def critical_winds_on_slopes() -> tuple[str, str, str]:
    """Vertical galloping without eccentric ice and twist: 4 m w xi / (rho d |CD + dCL/dalpha|)."""
    rises, right, here = (0.0, 0.3, 0.7), [], []
    for rise in rises:
        scene = gf.load_scene("example3").with_values(
            {
                "span.height_difference": rise * 125.88,
                "span.sag": None,
                "ice.first_moment_x2": 0.0,
                "ice.first_moment_x3": 0.0,
                "conductor.torsional_stiffness": 15300.0,
                "aerodynamics.moment": [0.0],
                "aerodynamics.lift": [0.0, -4.5],
                "aerodynamics.drag": [1.0],
            }
        )
        onset = next(
            c
            for c in modal.critical_wind_speed(scene, 2, highest_wind=6.0)
            if c.mode.family == "vertical"
        )
        mass = scene.conductor.mass_per_length + scene.ice.mass_per_length
        damping = 4.0 * mass * 2.0 * np.pi * onset.mode.frequency_hz * onset.mode.damping_ratio
        right.append(damping / (scene.wind.air_density * scene.conductor.diameter * 3.5))
        here.append(onset.wind_speed)
    return (
        (
            "Critical wind at rises of 0 / 0.3 / 0.7 of the span, stiff in twist: Den Hartog's"
            " closed form"
        ),
        " / ".join(f"{speed:.3f}" for speed in right) + " m/s",
        " / ".join(f"{speed:.3f}" for speed in here) + " m/s",
    )


def computed_at_once() -> list[tuple[str, str, str]]:
    """The rows that cost next to nothing."""
    step, pulse = example1("step"), example1("pulse")
    pair = modal.frequency_ratio(gf.load_scene("example3"))
    zebra = modal.natural_modes(gf.load_scene("zebra"), count=3)
    return [
        (
            "Example 1, step load: difference from OpenSees (160 elements) in u2 / u3,"
            " RMS over 10 s",
            "0 / 0",
            f"{step[0]:.1e} / {step[1]:.1e} of the motion",
        ),
        ("Example 1, load pulse: the same", "0 / 0", f"{pulse[0]:.1e} / {pulse[1]:.1e}"),
        (
            "Example 1, largest twist: exact statics of 39 torques",
            "18.95 deg",
            f"{step[2]:.2f} deg",
        ),
        (
            "Example 3, first vertical / horizontal frequency: the paper",
            "0.695 / 0.378 Hz",
            f"{pair.vertical_hz:.4f} / {pair.horizontal_hz:.4f} Hz",
        ),
        (
            "Zebra line, first three frequencies: published OpenSees model",
            "0.1710 / 0.3403 / 0.3418 Hz",
            " / ".join(f"{mode.frequency_hz:.4f}" for mode in zebra) + " Hz",
        ),
        *sag_tension(),
        critical_winds_on_slopes(),
    ]


def simulated() -> list[tuple[str, str, str]]:
    """The rows for which galloping must settle."""
    second, third = amplitudes("example2", 1500.0), amplitudes("example3", 1200.0)
    weaker = amplitudes("example3", 1600.0, wind__speed=5.0)
    spring = {"kind": "springs", "stiffness_x1": 75.97e3, "stiffness_x3": RIGID_X3}
    sprung = amplitudes("example3", 1200.0, supports__left=spring, supports__right=spring)
    return [
        (
            "Example 2, galloping amplitudes: the paper (curve reconstructed)",
            "1.544 / 0.058 m",
            f"{second[0]:.3f} / {second[1]:.3f} m",
        ),
        (
            "Example 3, 5.5 m/s: an independent prototype of the same equations",
            "0.442 / 0.192 m, swing at 1/2",
            f"{third[0]:.3f} / {third[1]:.3f} m, swing at {third[2]:.4f}",
        ),
        (
            "Example 3, 5.0 m/s: the same",
            "0.386 / 0.011 m, no swing",
            f"{weaker[0]:.3f} / {weaker[1]:.3f} m",
        ),
        (
            "Example 3 with springs of 75.97 kN/m: the same",
            "1.90 / 0.094 m, no swing",
            f"{sprung[0]:.3f} / {sprung[1]:.3f} m",
        ),
    ]


def line(*cells: str) -> str:
    return "| {} | {} | {} |".format(*cells)


def main() -> None:
    table = [line("Compared with", "Reference", "Here"), line("---", "---", "---")]
    table += [line(*row) for row in (*computed_at_once(), *simulated())]
    RECORD.write_text("\n".join(table) + "\n", encoding="utf-8")
    print(*table, sep="\n")


if __name__ == "__main__":
    main()
