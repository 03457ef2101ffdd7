# %% [markdown]
# # Galloping in one loop: example 2 of the paper
#
# An iced span on suspension insulators in a wind of 4.1 m/s. The paper gives a vertical amplitude
# of 1.544 m and a horizontal one of 0.058 m. The coefficient curve is a reconstruction, chosen to
# reproduce them. So the agreement shows that such a curve exists, not that it is the paper's.

# %%
import numpy as np

import gallop_fmu as gf

scene = gf.load_scene("example2")
print(scene.sources["conductor.torsional_inertia"])

# %% Den Hartog: the conductor can gallop where dCL/dalpha + CD < 0. This is so at the attack angle
# of the ice.
curve = scene.aerodynamics.curve()
attack_angle = np.radians(scene.ice.attack_angle_deg)
print(
    f"dCL/dalpha + CD = {curve.den_hartog(attack_angle):.3f} per radian at"
    f" {scene.ice.attack_angle_deg} deg"
)

# %%
result = gf.simulate(scene, stop_time=900.0)
steady = result.steady()
vertical, horizontal = steady["u2"], steady["u3"]
print(f"vertical   {vertical.amplitude:.3f} m at {vertical.frequency_hz:.4f} Hz, paper 1.544 m")
print(f"horizontal {horizontal.amplitude:.4f} m at {horizontal.frequency_hz:.4f} Hz, paper 0.058 m")

# %% Both directions have the same frequency: the path is an ellipse, and there is no separate
# swing.
assert abs(vertical.amplitude - 1.548) < 0.002  # 1.5476 m
assert abs(horizontal.amplitude - 0.0579) < 0.0002  # 0.0579 m
assert abs(horizontal.frequency_hz / vertical.frequency_hz - 1.0) < 1e-4
