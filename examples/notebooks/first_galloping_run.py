# %% [markdown]
# # First galloping run
#
# The packaged scene `example3` is the third example of Liu, Yan, Zhang and Zhou (2009): an iced
# span of 126 m. A function that takes a scene also takes its name, or the path of a scene file.

# %%
import gallop_fmu as gf

scene = gf.load_scene("example3").with_values({"wind.speed": 5.5})
scene

# %% [markdown]
# Open the line above to see all values with their units and sources. The run takes less than a
# second.

# %%
result = gf.simulate(scene, stop_time=900.0)
result.plot()

# %% [markdown]
# Vertical galloping grows first. When its amplitude is large enough, it starts a horizontal swing
# at half its frequency. Amplitudes are half peak-to-peak, over the last 100 s:

# %%
steady = result.steady()
steady["u2"], steady["u3"]

# %% [markdown]
# The path of mid-span, seen along the line, has the shape of a parabola: the sign of a 2:1
# resonance.

# %%
result.trace()

# %% [markdown]
# Every history is an xarray with its unit; `to_dataframe()` gives a pandas table.

# %%
result.to_dataframe()[["u2", "u3", "tension"]].tail(3)

# %%
assert abs(steady["u2"].amplitude - 0.442) < 0.002
