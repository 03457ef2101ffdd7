"""Derivatives of `modal.sensitivity` beside differences of branches that are computed again.

Prints, for example 3, drawn spans, a section of two spans and a twin bundle, the derivative of each
quantity by some numbers, and the central difference of the quantity between two scenes with the
number changed by `STEP` of it (`ANGLE_STEP` in degrees for the attack angle). The scenes are
followed from scratch, in coordinates of their own modes.

Usage: python benchmarks/accuracy/sensitivity.py [SEED] (some minutes)
"""

import sys
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

import gallop_fmu as gf
import modal
from modal.foundation.scene_variation import number_of, varied
from support.galloping_lines import section_of_example2
from support.simulated_swing import drawn_scene

SEED, DRAWN = 2026, 3
STEP, ANGLE_STEP = 0.001, 0.05
NUMBERS = ("span.horizontal_tension", "damping.translation", "ice.attack_angle_deg")
NUMBERS_OF_LINES = ("section.horizontal_tension", "damping.translation", "aerodynamics.lift")
RATIOS = dict.fromkeys(("damping.translation.low_ratio", "damping.translation.high_ratio"), 4e-3)
"""Damping ratios of the lines, with which their modes gallop from different winds."""


def main() -> None:
    """Compute and print."""
    draw = np.random.default_rng(int(sys.argv[1]) if len(sys.argv) > 1 else SEED)
    third = gf.load_scene("example3").with_values({"wind.speed": 5.2})
    scenes = [("example 3", third, (4.5, 5.4))]
    for number in range(1, DRAWN + 1):
        scene = drawn_scene(draw).with_values({"numerics.elements": 10})
        scenes.append((f"drawn {number}", scene, (None, None)))
    scenes += [("section", two_spans(), (2.3, 2.7)), ("twin bundle", twin(), (1.5, 3.2))]
    print("| span | quantity | number | derivative | difference | relative error |")
    print("| --- | --- | --- | --- | --- | --- |")
    errors = []
    for name, scene, (start, stop) in scenes:
        errors += compare(name, scene, start, stop)
    errors.sort()
    print(f"\n{len(errors)} derivatives: relative error in the median {np.median(errors):.1e},")
    print(f"90 % below {errors[int(0.9 * len(errors))]:.1e}, largest {errors[-1]:.1e}")


def two_spans() -> gf.LineScene:
    """Return a section of two unequal spans on a string."""
    data = section_of_example2(2, elements=8).model_dump(mode="json", exclude_none=True)
    data["section"]["spans"][1]["length"] = 112.0
    return gf.LineScene.from_dict(data).with_values({**RATIOS, "wind.speed": 2.55})


def twin() -> gf.LineScene:
    """Return a span of a twin bundle with four spacers."""
    bundle = {"subconductors": 2, "spacing": 0.4, "spacers": 4, "clamp_torsional_stiffness": 500.0}
    scene = section_of_example2(1, elements=10, bundle=bundle)
    return scene.with_values({**RATIOS, "wind.speed": 3.0})


def compare(
    name: str, scene: gf.Scene | gf.LineScene, start: float | None, stop: float | None
) -> list[float]:
    """Print the rows of a scene and return the relative errors."""
    of_line = isinstance(scene, gf.LineScene)
    found = modal.branches(scene, "wind.speed", start, stop)
    start, stop = (getattr(found.dataset.value, part)().item() for part in ("min", "max"))
    data = modal.sensitivity(found, NUMBERS_OF_LINES if of_line else NUMBERS).dataset
    errors = []
    for path in NUMBERS_OF_LINES if of_line else NUMBERS:
        value = number_of(scene, path)
        step = ANGLE_STEP if path.endswith("deg") else STEP * value
        sides = []
        for side in (-step, step):
            changed = varied(scene, path, value + side)
            again = modal.branches(changed, "wind.speed", start, stop)
            only = "damping.twist" if path == "damping.translation" else "damping.translation"
            sides.append(modal.sensitivity(again, [only]).dataset)
        for k, quantity in enumerate(data["quantity"].values):
            if any(list(one["quantity"].values).count(quantity) != 1 for one in (data, *sides)):
                continue  # two events of the same name cannot be told apart
            low, high = (one.value.sel(quantity=quantity).item() for one in sides)
            difference = (high - low) / (2.0 * step)
            derivative = data.derivative.sel(number=path).values[k]
            scale = max(abs(difference), 1e-3 * abs(data.value.values[k] / (value or 1.0)))
            error = abs(derivative - difference) / scale
            errors.append(error)
            print(
                f"| {name} | {quantity} | {path} | {derivative:.5g} | {difference:.5g}"
                f" | {error:.1e} |",
                flush=True,
            )
    return errors


if __name__ == "__main__":
    main()
