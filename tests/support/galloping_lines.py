"""Lines of the paper's example 2: spans of 125.88 m on strings of 2.1 m and 490 N."""

import math

import gallop_fmu as gf
from gallop_fmu.scene.line_scene import LineScene

STRING = {"kind": "string", "length": 2.1, "weight": 490.0}


def damping(rate, low, high):
    """Two ratios at two frequencies that make a damping in proportion to the mass alone [1/s]."""
    pairs = (("low_ratio", "low_frequency", low), ("high_ratio", "high_frequency", high))
    return {
        key: value
        for ratio, frequency, hertz in pairs
        for key, value in ((ratio, rate / (4.0 * math.pi * hertz)), (frequency, hertz))
    }


def section_of_example2(spans, elements=10, **parts):
    """Make a section of so many spans; `parts` are more sections of the scene, such as bundle."""
    one_span = gf.load_scene("example2").model_dump(mode="json", exclude_none=True)
    section = {
        "horizontal_tension": 21730.0,
        "strung_with_ice": True,
        "spans": [{"length": 125.88}] * spans,
        "suspensions": [STRING] * (spans - 1),
    }
    return LineScene.from_dict(
        {name: one_span[name] for name in ("conductor", "ice", "wind", "aerodynamics")}
        | {
            "title": f"{spans} spans of example 2",
            "section": section,
            "damping": {
                "translation": damping(0.0044, 0.275, 0.55),
                "twist": damping(2.52, 5.29, 10.58),
            },
            "initial": {"seed_vertical": 1e-3, "seed_horizontal": 1e-3},
            "numerics": {"elements": elements, "time_step": 0.02},
        }
        | parts
    )
