# %% [markdown]
# # All motions of a span, and the risk of a swing
#
# A simulation shows the motion that its start leads to. `modal.branches` finds all of them over the
# wind speed, stable and unstable.

# %%
import modal

found = modal.branches("example3", "wind.speed", 4.5, 5.2)
found

# %%
found.plot()

# %% [markdown]
# Solid lines are stable. From 5.04 m/s on, galloping without swing is unstable: the swing starts.
# `modal.screen` computes that wind speed alone:

# %%
screening = modal.screen("example3")
screening

# %%
screening.plot()

# %% [markdown]
# The cause is the ratio of the two lowest symmetric frequencies. Near 2, galloping drives the
# swing.

# %%
modal.natural_modes("example3", count=4)

# %%
modal.frequency_ratio("example3")

# %%
assert screening.risk == "certain"
assert abs(screening.onset_wind_speed - 5.041) < 0.002
