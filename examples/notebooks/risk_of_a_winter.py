# %% [markdown]
# # The risk of a winter
#
# Wind and ice of an ice event are random. The distributions below are an example, not a climate.

# %%
from scipy import stats

import modal

random = {
    "wind.speed": stats.weibull_min(2.0, scale=5.0),
    "ice.attack_angle_deg": stats.uniform(150.0, 60.0),
}
spans = [
    {"name": "A1-A2", "span.length": 110.0, "span.sag": 1.62},
    {"name": "A2-A3", "span.length": 126.0, "span.sag": 2.12},
]
atlas = modal.risk_atlas(
    "example3",
    random,
    table=spans,
    draws=64,
    shares=True,
    clearance=2.5,
    events_per_winter=2.0,
    workers=1,
)
atlas

# %% [markdown]
# Each number has its interval of 95 % confidence. The picture shows how it narrows with more draws,
# and which random value causes the variance of the amplitude.

# %%
atlas.plot()

# %% [markdown]
# All numbers as an xarray with units:

# %%
atlas.dataset[["winter_galloping", "winter_clash", "amplitude"]]

# %%
assert 0.3 < atlas.dataset.winter_galloping.values[1] < 0.5
