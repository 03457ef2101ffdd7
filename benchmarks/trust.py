"""Prints the table "How far to trust it" of the README.  Usage: python benchmarks/trust.py (about 10 s)."""

from pathlib import Path

import numpy as np

import gallop_fmu as gf
import modal

PEERS = Path(__file__).parents[1] / "tests" / "peers" / "data"
RIGID_X3 = 1e9
"""Stiffness [N/m] of a spring that holds like a rigid support."""


def relative_rms(found: np.ndarray, reference: np.ndarray) -> float:
    return float(np.sqrt(np.mean((found - reference) ** 2) / np.mean(reference**2)))


def example1(law: str) -> tuple[float, float, float]:
    """Difference of u2 and u3 from OpenSees, and largest twist [deg], with 20 elements and steps of 2.5 ms."""
    scene = gf.load_scene("example1")
    if law == "step":
        rise = {"kind": "ramp", "initial": 0.0, "final": 1.0, "duration": 1.0}
        load = {"force": [0.0, 1.0, 2.0], "torque": 1.0, "evenly_spaced": 39, "law": rise}
        scene = scene.with_values({"loads": [load]})
    motion = gf.simulate(scene, stop_time=10.0, record_every=4).midspan()
    peer = np.genfromtxt(PEERS / f"example1_{law}_opensees.csv", delimiter=",", skip_header=1)
    u2, u3 = (relative_rms(motion[name].values, peer[:, 1 + i]) for i, name in enumerate(("u2", "u3")))
    return u2, u3, float(np.degrees(motion.theta.max()))


def amplitudes(name: str, stop_time: float, **values: object) -> tuple[float, float, float]:
    scene = gf.load_scene(name).with_values({key.replace("__", "."): value for key, value in values.items()})
    steady = gf.simulate(scene, stop_time=stop_time).steady(100.0)
    return steady["u2"].amplitude, steady["u3"].amplitude, steady["u3"].frequency_hz / steady["u2"].frequency_hz


def main() -> None:
    row = "| {} | {} | {} |".format
    print(row("Compared with", "There", "Here"))
    print("| --- | --- | --- |")
    step, pulse = example1("step"), example1("pulse")
    print(row("Example 1, step load: OpenSees (160 elements), u2 / u3 over 10 s", "",
              f"relative RMS difference {step[0]:.1e} / {step[1]:.1e}"))  # fmt: skip
    print(row("Example 1, pulse: the same", "", f"{pulse[0]:.1e} / {pulse[1]:.1e}"))
    print(row("Example 1, largest twist: exact statics of 39 torques", "18.95 deg", f"{step[2]:.2f} deg"))
    vertical, horizontal, _ = amplitudes("example2", 1500.0)
    print(row("Example 2, galloping amplitudes: the paper (curve reconstructed)", "1.544 / 0.058 m",
              f"{vertical:.3f} / {horizontal:.3f} m"))  # fmt: skip
    pair = modal.frequency_ratio(gf.load_scene("example3"))
    print(row("Example 3, first vertical / horizontal frequency: the paper", "0.695 / 0.378 Hz",
              f"{pair.vertical_hz:.4f} / {pair.horizontal_hz:.4f} Hz"))  # fmt: skip
    vertical, horizontal, ratio = amplitudes("example3", 1200.0)
    print(row("Example 3, 5.5 m/s: an independent prototype of the same equations", "0.442 / 0.192 m, swing at 1/2",
              f"{vertical:.3f} / {horizontal:.3f} m, swing at {ratio:.4f}"))  # fmt: skip
    vertical, horizontal, _ = amplitudes("example3", 1600.0, wind__speed=5.0)
    print(row("Example 3, 5.0 m/s: the same", "0.386 / 0.011 m, no swing", f"{vertical:.3f} / {horizontal:.3f} m"))
    spring = {"kind": "springs", "stiffness_x1": 75.97e3, "stiffness_x3": RIGID_X3}
    vertical, horizontal, _ = amplitudes("example3", 1200.0, supports__left=spring, supports__right=spring)
    print(row("Example 3 with springs of 75.97 kN/m: the same", "1.90 / 0.094 m, no swing",
              f"{vertical:.3f} / {horizontal:.3f} m"))  # fmt: skip
    zebra = modal.natural_modes(gf.load_scene("zebra"), count=3)
    print(row("Zebra line, first three frequencies: published OpenSees model", "0.1710 / 0.3403 / 0.3418 Hz",
              " / ".join(f"{mode.frequency_hz:.4f}" for mode in zebra) + " Hz"))  # fmt: skip


if __name__ == "__main__":
    main()
