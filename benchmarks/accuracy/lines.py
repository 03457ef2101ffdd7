"""Print the table of lines in docs/reference/accuracy.md: this program against others.

Usage: python benchmarks/accuracy/lines.py (about a minute)

The other programs' results are stored with their sources in tests/peers/data/lines.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import numpy as np

import modal

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests"))

from support.line_references import line_scene, stored
from support.line_runs import galloping

FREQUENCIES = {
    "three spans of 300 m on strings": "section_frequencies_zebra_3_spans",
    "300 / 350 / 280 m on strings": "section_frequencies_drake_3_spans",
    "drawn section 1": "new_section_frequencies_1",
    "drawn section 2": "new_section_frequencies_2",
    "drawn section 3": "new_section_frequencies_3",
    "quad bundle with 4 spacers": "bundle_frequencies_quad_200m",
    "triple bundle with 6 spacers": "bundle_frequencies_triple_300m",
    "drawn bundle 1": "new_bundle_frequencies_1",
    "drawn bundle 2": "new_bundle_frequencies_2",
}
FAMILIES = {
    "in_plane": ("vertical", "tension-neutral", "longitudinal"),
    "vertical": ("vertical",),
    "out_of_plane": ("horizontal",),
    "horizontal": ("horizontal",),
    "torsion": ("bundle torsion",),
}
ELEMENTS = 30


def wanted(case: dict[str, Any], key: str) -> np.ndarray | None:
    """Frequencies [Hz] of the other program for zero mesh size."""
    if f"{key}_extrapolated" in case.get("repeated", {}):
        return np.array(case["repeated"][f"{key}_extrapolated"])
    found = case["results"].get(key)
    return None if found is None else np.array(found)


def worst_frequency(name: str) -> tuple[float, int]:
    """Largest relative difference of a case, and the number of its frequencies."""
    case = stored(name)
    modes = modal.natural_modes(line_scene(case, ELEMENTS), count=26)
    worst, count = 0.0, 0
    for key, families in FAMILIES.items():
        other = wanted(case, key)
        if other is None:
            continue
        own = sorted(mode.frequency_hz for mode in modes if mode.family in families)
        worst = max(worst, float(np.abs(np.array(own[: len(other)]) / other - 1.0).max()))
        count += len(other)
    return worst, count


def main() -> None:
    print("| natural frequencies of | frequencies | largest difference from OpenSees |")
    print("| --- | ---: | ---: |")
    for title, name in FREQUENCIES.items():
        worst, count = worst_frequency(name)
        print(f"| {title} | {count} | {worst:.1e} |")
    twin = galloping(
        line_scene(stored("bundle_galloping_twin_horizontal"), 20).with_values(
            {"numerics.time_step": 0.01}
        ),
        600.0,
    )
    section = galloping(
        line_scene(stored("section_galloping_example2_3_spans"), 20).with_values(
            {"numerics.time_step": 0.01}
        ),
        350.0,
    )
    print()
    print("| galloping | this program | lumped chain |")
    print("| --- | ---: | ---: |")
    vertical, lateral = twin.mid_spans[-1, 1, 0], twin.mid_spans[-1, 2, 0]
    print(f"| twin bundle, vertical, steady | {vertical:.3f} m | 1.471 m |")
    print(f"| twin bundle, lateral, steady | {lateral:.4f} m | 0.0974 m |")
    plateau = section.mid_spans[-1, 1].max()
    print(f"| section of three spans, vertical, 300 to 350 s | {plateau:.2f} m | 1.43 to 1.44 m |")


if __name__ == "__main__":
    main()
