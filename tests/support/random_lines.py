"""Random valid lines for property tests: spans, towers, bundles, phases, devices, loads."""

from __future__ import annotations

from hypothesis import strategies as st

TOWER = st.one_of(
    st.fixed_dictionaries(
        {
            "kind": st.just("string"),
            "length": st.floats(0.5, 8.0),
            "weight": st.floats(0.0, 5e3),
        },
        optional={"damping": st.floats(0.0, 1e3), "stiffness": st.floats(1e6, 1e8)},
    ),
    st.just({"kind": "post"}),
)
END = st.one_of(
    st.just({"kind": "rigid"}),
    st.fixed_dictionaries(
        {
            "kind": st.just("springs"),
            "stiffness_x1": st.floats(1e3, 1e8),
            "stiffness_x3": st.floats(1e3, 1e8),
        }
    ),
    st.fixed_dictionaries(
        {"kind": st.just("string"), "length": st.floats(0.5, 8.0), "weight": st.floats(0.0, 5e3)}
    ),
)
ICE = st.one_of(
    st.just("none"),
    st.fixed_dictionaries(
        {"mass_per_length": st.floats(0.0, 5.0), "attack_angle_deg": st.floats(-180.0, 180.0)}
    ),
)
SPAN = st.fixed_dictionaries(
    {"length": st.floats(60.0, 600.0)},
    optional={"height_difference": st.floats(-50.0, 50.0), "ice": ICE, "elements": st.just(40)},
)


@st.composite
def line_data(draw: st.DrawFn) -> dict[str, object]:
    """Draw the content of a scene file of a line."""
    spans = draw(st.lists(SPAN, min_size=1, max_size=6))
    subconductors = draw(st.sampled_from([1, 2, 3, 4, 6, 8]))
    phases = draw(st.integers(1, 3))
    bundle: dict[str, object] = {"subconductors": subconductors}
    if subconductors > 1:
        bundle |= {"spacing": draw(st.floats(0.2, 0.6)), "spacers": draw(st.integers(0, 8))}
        bundle["yoke_height"] = draw(st.floats(0.0, 0.3))
    if subconductors == 2:
        bundle["orientation"] = draw(st.sampled_from(["horizontal", "vertical"]))
    devices = [draw(device(len(spans), phases, subconductors, slot)) for slot in range(draw(_FEW))]
    return {
        "title": draw(st.text("aé\n\"'# ", max_size=10)),
        "section": {
            "horizontal_tension": draw(st.floats(1e4, 5e4)),
            "strung_with_ice": draw(st.booleans()),
            "temperature_deg_c": draw(st.floats(-30.0, 80.0)),
            "spans": spans,
            "suspensions": draw(st.lists(TOWER, min_size=len(spans) - 1, max_size=len(spans) - 1)),
            "left_end": draw(END),
            "right_end": draw(END),
        },
        "bundle": bundle,
        "phases": [{"name": f"{k}", "offset": [0.0, 8.0 * k]} for k in range(phases)],
        "conductor": {
            "diameter": 0.028,
            "mass_per_length": 1.6,
            "axial_stiffness": 29e6,
            "torsional_stiffness": 159.0,
            "torsional_inertia": 2e-4,
            "thermal_expansion": 1.9e-5,
        },
        "numerics": {"elements": 40},
        "devices": devices,
        "loads": [{"span": 1, "position": 0.4, "force": [0.0, draw(st.floats(-1e3, 1e3)), 1.0]}],
    }


_FEW = st.integers(0, 5)


@st.composite
def device(draw: st.DrawFn, spans: int, phases: int, subconductors: int, slot: int) -> object:
    """Draw a device; each slot has a stretch of the span of its own, away from spacers."""
    kinds = ["pendulum", "mass", "damper", "interval"]
    kind = draw(st.sampled_from(kinds + ["interphase_spacer"] * (phases > 1)))
    place = 0.03 + 0.15 * slot
    found: dict[str, object] = {"kind": kind, "span": draw(st.integers(1, spans))}
    if kind == "interphase_spacer":
        return {**found, "station": place, "phases": [phases, 1], "mass": draw(st.floats(0, 50))}
    if draw(st.booleans()):
        found["phase"] = draw(st.integers(1, phases))
    if draw(st.booleans()):
        found["subconductor"] = draw(st.integers(1, subconductors))
    if kind == "interval":
        return {**found, "from_station": place, "to_station": place + 0.04, "ice": draw(ICE)}
    found["station"] = place
    if kind == "damper":
        return {**found, "damping": draw(st.floats(0, 1e3)), "axis": draw(st.sampled_from(_AXES))}
    found["mass"] = draw(st.floats(0.1, 50.0))
    return found if kind == "mass" else {**found, "arm": draw(st.floats(0.05, 1.0))}


_AXES = ["x1", "x2", "x3"]
