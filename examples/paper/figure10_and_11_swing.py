# %% [markdown]
# # Figures 10 and 11: trace and histories at mid-span of example 3, the new galloping mode
#
# First the span gallops vertically (a), then a horizontal swing at half the frequency grows (b),
# and both reach a steady state (c). The coefficient curve, figure 6(b), is not available to us;
# that of the packaged scene is a reconstruction. The paper prints no amplitude for this example. It
# prints the frequencies of the first vertical and the first horizontal mode, 0.695 and 0.378 (Hz).

# %%
import tempfile
from pathlib import Path

import gallop_fmu as gf
import modal
from gallop_fmu.plots import histories, save_figure, trace

scene = gf.load_scene("example3")
frequencies = modal.frequency_ratio(scene)
result = gf.simulate(scene, stop_time=900.0)

# %%
folder = Path(tempfile.mkdtemp(prefix="gallop-"))
windows = {
    "(a) vertical": (480.0, 500.0),
    "(b) transition": (535.0, 560.0),
    "(c) steady": (870.0, 900.0),
}
print("wrote", save_figure(trace(result, windows), folder / "figure10.pdf"))
print("wrote", save_figure(histories(result, ("u2", "u3")), folder / "figure11.pdf"))

# %%
print(
    f"first modes {frequencies.vertical_hz:.4f} and {frequencies.horizontal_hz:.4f} Hz,"
    " the paper 0.695 and 0.378"
)
before, after = result.between(470.0, 510.0), result.steady()
for name, motion in (("before", before), ("after", after)):
    print(
        f"{name:6} vertical {motion['u2'].amplitude:.3f} m, horizontal"
        f" {motion['u3'].amplitude:.4f} m at {motion['u3'].frequency_hz:.4f} Hz"
    )

# %%
assert abs(frequencies.vertical_hz - 0.695) < 0.0005  # 0.6954 Hz
assert abs(frequencies.horizontal_hz - 0.378) < 0.0006  # 0.3775 Hz
assert before["u2"].amplitude > after["u2"].amplitude  # 0.560 m falls to 0.442 m
assert before["u3"].amplitude < 0.025  # 0.020 m, most of it a component of the vertical motion
assert abs(after["u3"].amplitude - 0.1915) < 0.001  # 0.1915 m
assert abs(after["u3"].frequency_hz / after["u2"].frequency_hz - 0.5) < 1e-4
