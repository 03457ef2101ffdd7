# %% [markdown]
# # Beyond the paper: a swing without symmetry, and a true section in place of springs
#
# 1. At 6.5 m/s the swing of example 3 is itself unstable: motion in two loops grows and takes over.
# 2. Equations (23) and (24) replace the adjacent spans by springs. A true section of spans on
#    insulator strings has modes at other frequencies, among them one in which all strings swing.
#    Example 16 shows how galloping drives it.

# %%
import tempfile
from pathlib import Path

import gallop_fmu as gf
import modal
from gallop_fmu.plots import histories, save_figure

# %% A load pulse at 0.3 of the span: it moves the symmetric modes and those of two loops.
pulse = {"kind": "pulse", "peak": 1.0, "rise": 0.5, "fall_start": 1.0, "fall": 0.5}
push = {"position": 0.3, "force": (0.0, 5.0, 0.0), "law": pulse}
scene = gf.load_scene("example3").with_values({"wind.speed": 6.5, "loads": [push]})
middle = scene.numerics.elements
quarter = middle // 2
nodes = [quarter, middle, 2 * middle - quarter]
result = gf.simulate(scene, stop_time=2500.0, record_every=5, record_nodes=nodes)

# %%
steady, window = result.steady(), result.in_window(100.0)
left, right = (result.dataset.u2.sel(node=node)[window] for node in (nodes[0], nodes[2]))
loops = (left - right).values / 2.0
two_loops = (loops.max() - loops.min()) / 2.0
print(
    f"6.5 m/s: mid-span {steady['u2'].amplitude:.3f} m vertical, {steady['u3'].amplitude:.3f} m"
    f" horizontal, two-loop motion {two_loops:.3f} m at the quarter points"
)
folder = Path(tempfile.mkdtemp(prefix="gallop-"))
print("wrote", save_figure(histories(result, ("u2", "u3")), folder / "symmetry.pdf"))

# %% Example 2 as a section of three spans.
one_span = gf.load_scene("example2")
given = one_span.model_dump(mode="json", exclude_none=True)
section = gf.LineScene.from_dict(
    {name: given[name] for name in ("conductor", "ice")}
    | {
        "title": "Three spans of example 2 on insulator strings",
        "section": {
            "horizontal_tension": 21730.0,
            "strung_with_ice": True,
            "spans": [{"length": 125.88}] * 3,
            "suspensions": [{"kind": "string", "length": 2.1, "weight": 490.0}] * 2,
        },
        "numerics": {"elements": 15},
    }
)


def lowest(modes, family):
    """Frequencies [Hz] of the three lowest modes of a family."""
    return [mode.frequency_hz for mode in modes if family in mode.family][:3]


with_springs = modal.natural_modes(one_span, count=12)
as_section = modal.natural_modes(section, count=20)
for family in ("vertical", "horizontal"):
    for name, modes in (("springs", with_springs), ("section", as_section)):
        values = " ".join(f"{value:.4f}" for value in lowest(modes, family))
        print(f"{family:10} {name:8} {values} Hz")
swing = lowest(as_section, "horizontal")[0]
print(f"the whole section swings at {swing:.4f} Hz; no mode of the span on springs is that low")

# %%
assert abs(steady["u2"].amplitude - 0.696) < 0.01
assert abs(two_loops - 0.473) < 0.01
assert abs(swing - 0.3256) < 0.001  # OpenSees: 0.32558 Hz
assert swing < 0.9 * lowest(with_springs, "horizontal")[0]
