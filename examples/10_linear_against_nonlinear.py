# %% [markdown]
# # Simpler models of example 3
#
# Three models of one span with the same start. Linear theory predicts galloping and its frequency,
# but not its amplitude. Mode superposition (Desai et al. 1995) has the nonlinear wind force on a
# linear structure: galloping saturates. Only in the simulation does the tension change with the
# motion, so only there galloping starts the horizontal swing at half its frequency. The coefficient
# curve is a reconstruction in all three.

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

# %% Linear theory: small motion in the mean wind.
for mode in comparison.linear_modes[:3]:
    print(f"{mode.family:10} {mode.frequency_hz:.4f} Hz grows at {mode.growth_rate:+.4f} 1/s")

# %% The time from which the vertical amplitudes differ by a fifth, until the end.
for model in ("linear", "superposition"):
    print(
        f"{model:14} parts from the simulation at"
        f" {comparison.divergence(model, 'u2', 0.2).amplitude:.0f} s"
    )

# %% One mode in each of the three directions: the model of Yu et al. (1993).
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
assert swing["superposition"] < 0.005  # 0.0039 m, from the drag, which changes twice per period
assert swing["linear"] < 0.001  # 0.0006 m
assert abs(three.steady()["u2"].amplitude - 0.631) < 0.002  # 0.6312 m
