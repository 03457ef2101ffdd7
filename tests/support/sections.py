"""Lines for tests: sections of Drake, with what a test adds."""

from gallop_fmu.scene.line_scene import LineScene

DRAKE = {
    "diameter": 0.02814,
    "mass_per_length": 1.628,
    "axial_stiffness": 29.0e6,
    "torsional_stiffness": 159.0,
    "torsional_inertia": 2e-4,
}
STRING = {"kind": "string", "length": 2.4, "weight": 600.0}
POST = {"kind": "post"}


def section(lengths=(300.0, 350.0, 280.0), suspension=STRING, tension=25e3, **tables):
    """A section of level spans of Drake with equal suspensions; `tables` are added or merged."""
    data = {
        "title": "section for a test",
        "section": {
            "horizontal_tension": tension,
            "spans": [{"length": length} for length in lengths],
            "suspensions": [suspension] * (len(lengths) - 1),
        },
        "conductor": DRAKE,
        "numerics": {"elements": 10, "time_step": 0.02},
    }
    for name, content in tables.items():
        merge = isinstance(content, dict) and name in data
        data[name] = {**data[name], **content} if merge else content
    return LineScene.from_dict(data)
