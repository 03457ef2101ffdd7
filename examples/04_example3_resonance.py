# %% [markdown]
# # The 2:1 internal resonance: example 3 of the paper
#
# Galloping starts the swing only if the vertical frequency is about twice the horizontal one and
# the vertical amplitude is large enough. Three runs show it: a lower wind speed (amplitude too
# small), the paper's wind speed (swing), and the paper's wind speed with soft supports, which lower
# the vertical frequency so that the ratio is not 2:1. The coefficient curve is a reconstruction.

# %%
import tempfile
from pathlib import Path

import gallop_fmu as gf
from gallop_fmu.plots import save_figure, trace

rigid = gf.load_scene("example3")
springs = {
    "kind": "springs",
    "stiffness_x1": 75.97e3,
    "stiffness_x3": 1e9,
}  # soft along the span only
runs = {
    "5.0 m/s": (rigid.with_values({"wind.speed": 5.0}), 1500.0),
    "5.5 m/s": (rigid.with_values({"wind.speed": 5.5}), 900.0),
    "5.5 m/s, springs": (
        rigid.with_values({"supports.left": springs, "supports.right": springs}),
        900.0,
    ),
}
results = {name: gf.simulate(scene, stop_time) for name, (scene, stop_time) in runs.items()}

# %%
steady = {name: result.steady() for name, result in results.items()}
for name, motion in steady.items():
    vertical, swing = motion["u2"], motion["u3"]
    print(
        f"{name:18} vertical {vertical.amplitude:.3f} m at {vertical.frequency_hz:.4f} Hz, "
        f"horizontal {swing.amplitude:.4f} m at {swing.frequency_hz:.4f} Hz"
    )

# %% The path of the mid-span point before and after the start of the swing.
figure = trace(results["5.5 m/s"], {"before": (470.0, 510.0), "after": (860.0, 900.0)})
print("wrote", save_figure(figure, Path(tempfile.mkdtemp(prefix="gallop-")) / "trace.png"))

# %% Frequency of the horizontal over that of the vertical motion: 1/2 with the swing, 1 without.
ratio = {
    name: motion["u3"].frequency_hz / motion["u2"].frequency_hz for name, motion in steady.items()
}
assert abs(ratio["5.5 m/s"] - 0.5) < 1e-4
assert abs(ratio["5.0 m/s"] - 1.0) < 1e-3
assert abs(ratio["5.5 m/s, springs"] - 1.0) < 1e-3
assert abs(steady["5.5 m/s"]["u3"].amplitude - 0.1915) < 0.001  # 0.1915 m
assert steady["5.0 m/s"]["u3"].amplitude < 0.012  # 0.0106 m: a component of the vertical motion
