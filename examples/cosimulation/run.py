# %% [markdown]
# # A line between towers, wind from a file, and a relay
#
# Four FMUs: the line of example 19, two towers, and a relay (`relay.py`) that trips when the
# clearance between the middle of span 2 and a wire above it has been below a limit for 20 ms. The
# master (`master.py`) runs them with FMPy, and finds the time of the trip by taking steps back.

# %%
import sys
import tempfile
from pathlib import Path

import numpy as np

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent))

from cosimulation.master import PORTS, Master  # noqa: E402
from towers.coupling import galloping_line  # noqa: E402

STEP, STOP = 0.005, 6.0
GAP = 0.61
"""Assumed distance [m] of the wire above in the equilibrium."""

wind = np.loadtxt(HERE / "wind.csv", delimiter=",", skiprows=1).T
scene = galloping_line(cable_step=0.005)


def clearance(x2):
    """Distance [m] to the wire above."""
    return GAP - x2


# %% Runs with two steps: the time of the trip is that of the motion, not of the master.
trips = []
for step in (STEP, 0.5 * STEP):
    folder = Path(tempfile.mkdtemp(prefix="gallop-"))
    master = Master(scene, PORTS, folder, wind)
    try:
        history, trip = master.run_until_trip(STOP, step, clearance)
    finally:
        master.close()
    trips.append(trip)
    print(
        f"steps of {1000 * step:g} ms: trip at {trip or np.nan:.4f} s, x2 from"
        f" {history[:, 1].min():.3f} to {history[:, 1].max():.3f} m"
    )

# %%
assert None not in trips
assert abs(trips[0] - trips[1]) < STEP  # when the clearance falls below its limit is not searched
