"""Write equivalent_bundle.md: frequencies of equivalent conductors against those of the bundles.

Usage: python benchmarks/accuracy/equivalent_bundle.py (about 10 s)
"""

from pathlib import Path

import gallop_fmu as gf
import modal

RECORD = Path(__file__).with_suffix(".md")
ELEMENTS = 16
DRAKE = {
    "diameter": 0.0281,
    "mass_per_length": 1.628,
    "axial_stiffness": 29.0e6,
    "torsional_stiffness": 159.0,
    "torsional_inertia": 2e-4,
}
STRING = {"kind": "string", "length": 2.4, "weight": 600.0}
POST = {"kind": "post"}
BUNDLES = {
    "twin, horizontal, 0.40 m": {"subconductors": 2, "spacing": 0.40},
    "twin, vertical, 0.40 m": {"subconductors": 2, "spacing": 0.40, "orientation": "vertical"},
    "triple, 0.40 m": {"subconductors": 3, "spacing": 0.40},
    "quad, 0.45 m": {"subconductors": 4, "spacing": 0.45},
    "hexa, 0.40 m": {"subconductors": 6, "spacing": 0.40},
}
SPANS = {
    "200 m, 25 kN, 4 spacers": ([200.0], [], 4, 25e3),
    "350 m, 25 kN, 7 spacers": ([350.0], [], 7, 25e3),
    "350 m, 25 kN, 3 spacers": ([350.0], [], 3, 25e3),
    "posts, 300 + 300 m, 25 kN, 6 spacers": ([300.0, 300.0], [POST], 6, 25e3),
    "strings, 300 + 350 + 280 m, 25 kN, 6 spacers": ([300.0, 350.0, 280.0], [STRING] * 2, 6, 25e3),
    "strings, 300 + 300 m, 25 kN, 6 spacers": ([300.0, 300.0], [STRING], 6, 25e3),
    "strings, 300 + 300 m, 12 kN, 6 spacers": ([300.0, 300.0], [STRING], 6, 12e3),
}
FAMILIES = (
    ("horizontal", ("horizontal",), ("horizontal",)),
    ("vertical", ("vertical", "tension-neutral"), ("vertical", "tension-neutral")),
    ("torsion", ("bundle torsion",), ("torsional",)),
)
"""Column, families of the bundle and of the equivalent conductor."""


def line(
    bundle: dict[str, object], spans: tuple[list[float], list[object], int, float]
) -> gf.LineScene:
    lengths, suspensions, spacers, tension = spans
    return gf.LineScene.from_dict(
        {
            "title": "bundle",
            "section": {
                "horizontal_tension": tension,
                "spans": [{"length": length} for length in lengths],
                "suspensions": suspensions,
            },
            "bundle": {**bundle, "spacers": spacers},
            "conductor": DRAKE,
            "numerics": {"elements": ELEMENTS},
        }
    )


def of(modes: list[modal.LineMode], families: tuple[str, ...]) -> list[modal.LineMode]:
    return [mode for mode in modes if mode.family in families]


def cell(mode: modal.LineMode, others: list[modal.LineMode]) -> str:
    """Frequency, loops, and error [%] of the mode with the same loops; removes it from `others`."""
    loops = " ".join(str(loops) for loops in mode.loops)
    alike = [other for other in others if other.loops == mode.loops]
    if not alike:
        return f"{mode.frequency_hz:.4f}, {loops}: none"
    others.remove(alike[0])
    error = 100.0 * (alike[0].frequency_hz / mode.frequency_hz - 1.0)
    return f"{mode.frequency_hz:.4f}, {loops}: {error:+.2f}"


def row(name: str, span: str, scene: gf.LineScene) -> str:
    """The first two modes of each family."""
    found = modal.equivalent_bundle(scene)
    full, single = (modal.natural_modes(s, 24) for s in (scene, found.scene))
    cells = [name, span, f"{found.sag_factor:.2f}"]
    for _, of_bundle, of_single in FAMILIES:
        others = of(single, of_single)
        cells += [cell(mode, others) for mode in of(full, of_bundle)[:2]]
    return "| " + " | ".join(cells) + " |"


def main() -> None:
    heads = ["bundle", "spans", "sag factor"]
    heads += [f"{name} {number}" for name, *_ in FAMILIES for number in (1, 2)]
    lines = [
        "The first two modes of each family of bundles of Drake: frequency [Hz], loops in each",
        "span, and error [%] of the equivalent conductor (`modal.equivalent_bundle`). Written by",
        "`benchmarks/accuracy/equivalent_bundle.py`.",
        "",
        "| " + " | ".join(heads) + " |",
        "| " + " | ".join("---" for _ in heads) + " |",
    ]
    for name, bundle in BUNDLES.items():
        lines += [row(name, span, line(bundle, given)) for span, given in SPANS.items()]
    RECORD.write_text("\n".join(lines) + "\n", encoding="utf-8")
    print("\n".join(lines))


if __name__ == "__main__":
    main()
