# %% [markdown]
# # What simpler models say of example 3
#
# Three models of one span, started alike. Linear theory says that it gallops, and at which
# frequency, but not how far. Mode superposition (Desai et al. 1995) keeps the nonlinear wind load
# on a linear structure: the galloping saturates. Only the simulation has a structure whose tension
# changes with the motion, and only there does the horizontal swing of half the frequency wake. The
# curve of coefficients is a reconstruction in all three.

# %%
import tempfile
from pathlib import Path

import gallop_fmu as gf
import modal
from gallop_fmu.plots import save_figure
from modal.plots import comparison_figure

scene = gf.load_scene("example3").with_values({"numerics.time_step": 0.02, "run.record_every": 2})
comparison = modal.compare(scene, stop_time=900.0)
print(comparison)

# %% Small motion in the mean wind: what linear theory can tell.
for mode in comparison.linear_modes[:3]:
    print(f"{mode.family:10} {mode.frequency_hz:.4f} Hz grows at {mode.growth_rate:+.4f} 1/s")

# %% When the vertical amplitudes have parted by a fifth, for good.
for model in ("linear", "superposition"):
    print(
        f"{model:14} parts from the simulation at"
        f" {comparison.divergence(model, 'u2', 0.2).amplitude:.0f} s"
    )

# %% The same three directions with one mode each: the model of Yu et al. (1993).
three = modal.mode_superposition(scene, 900.0, vertical=1, horizontal=1, torsional=1)
print(f"one mode in each direction: vertical {three.steady()['u2'].amplitude:.3f} m")

# %%
print(
    "wrote",
    save_figure(
        comparison_figure(comparison), Path(tempfile.mkdtemp(prefix="gallop-")) / "models.png"
    ),
)

# %% The swing exists only in the nonlinear model.
swing = {name: motion["u3"].amplitude for name, motion in comparison.amplitudes().items()}
assert abs(swing["nonlinear"] - 0.192) < 0.001  # 0.1918 m
assert swing["superposition"] < 0.005  # 0.0039 m, with the drag that changes twice a period
assert swing["linear"] < 0.001  # 0.0006 m
assert abs(three.steady()["u2"].amplitude - 0.631) < 0.002  # 0.6312 m
