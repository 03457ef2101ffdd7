# %% [markdown]
# # Ice that falls
#
# Three spans of Drake with 1 kg/m of ice, two phases one above the other and 1.5 m apart across the
# line. The ice of the lower phase falls from the middle span: all at once, from half of the span,
# or in quarters of which each falls when the motion of its neighbour shakes it. How high does the
# conductor jump, how near does it come to the upper phase, and what pull is left on the towers?

# %%
import gallop_fmu as gf
from gallop_fmu.scene.line_scene import LineScene

FALL = 1.0
LINE = {
    "section": {
        "horizontal_tension": 25e3,
        "spans": [{"length": 300.0}, {"length": 350.0}, {"length": 280.0}],
        "suspensions": [{"kind": "string", "length": 2.4, "weight": 600.0}] * 2,
    },
    "phases": [{"name": "lower"}, {"name": "upper", "offset": [4.0, 1.5]}],
    "conductor": {
        "diameter": 0.02814,
        "mass_per_length": 1.628,
        "axial_stiffness": 29e6,
        "torsional_stiffness": 159.0,
        "torsional_inertia": 2e-4,
    },
    "ice": {"mass_per_length": 1.0},
    "numerics": {"elements": 12, "time_step": 0.01},
    "run": {"stop_time": 8.0},
}


def part(start, stop, **when):
    """Ice on the lower phase of the middle span; `when` is a time or an acceleration."""
    return {"span": 2, "phase": 1, "from_station": start, "to_station": stop, **when}


CASES = {
    "whole span": [part(0.0, 1.0, time=FALL)],
    "middle half": [part(0.25, 0.75, time=FALL)],
    "quarters": [
        part(0.0, 0.25, time=FALL),
        *(part(0.25 * k, 0.25 * k + 0.25, acceleration=4.0) for k in (1, 2, 3)),
    ],
}

# %% The jump, the smallest distance of the phases, and the pull on the towers beside the span.
found = {}
for name, sheddings in CASES.items():
    scene = LineScene.from_dict({**LINE, "title": name, "shedding": sheddings})
    table = gf.simulate(scene, record_nodes="all").sheddings
    row = found[name] = table.iloc[0]
    print(
        f"{name:12} jump {row.highest_rise:.2f} m at {row.highest_rise_time - FALL:.2f} s, then"
        f" {row.final_rise:.2f} m; phases {row.smallest_clearance:.2f} m apart; pull up to"
        f" {row.unbalanced_pull:.0f} N, then {row.final_unbalanced_pull:.0f} N"
    )
    assert table["time"].notna().all(), "all parts fell"
print("quarters fell at", ", ".join(f"{time:.2f} s" for time in table["time"]))

# %% The conductor jumps to almost twice the height at which it comes to rest, past the upper phase;
# quarters that fall one after another make it jump higher still.
whole = found["whole span"]
assert 1.5 < whole.highest_rise / whole.final_rise < 2.0
assert abs(whole.final_unbalanced_pull - 563.0) < 5.0
assert found["middle half"].smallest_clearance > whole.smallest_clearance
assert found["quarters"].highest_rise > whole.highest_rise
