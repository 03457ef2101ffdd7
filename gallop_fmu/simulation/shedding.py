"""Ice that fell in a run: when and where, how far the conductor jumped, and where it comes to rest.

Rises are vertical displacements from the initial equilibrium, with all ice and in still air.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.engine.line_map import LineMap, MappedShedding
from gallop_fmu.engine.model import State
from gallop_fmu.engine.pack import map_of
from gallop_fmu.foundation.channels import DESCRIBED, END_FORCES
from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.outcome import SimulationError
from gallop_fmu.scene.line_scene import LineScene
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.stations import SAME_PLACE
from gallop_fmu.simulation.recording import Recording

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

    from gallop_fmu.simulation.line_result import LineResult
    from gallop_fmu.simulation.result import Result

Array = NDArray[np.float64]

SETTLED = "_settled"
"""End of the names of values in the equilibrium in still air with the ice that is left."""

SETTLING = ("u1", "u2", "u3", "theta", "tension", *END_FORCES)
"""Channels that have such a value, besides those of towers and strings."""

PLACES = {
    "number": ("1", "number of the shedding in the scene"),
    "span": ("1", "number of the span"),
    "phase": ("1", "number of the phase"),
    "subconductor": ("1", "number of the subconductor"),
    "from_station": ("1", "start of the part, as a fraction of the conductor's length"),
    "to_station": ("1", "end of the part, as a fraction of the conductor's length"),
    "ice": ("kg/m", "mass of the ice of the part per unit length"),
}
"""Field of `MappedShedding` to unit and meaning of its coordinate ``shedding_...``."""

VALUES = {
    "shed_time": ("s", "time at which the ice of the part fell; NaN: it has not"),
    "shed_kinetic_energy": ("J", "kinetic energy of the ice when it fell"),
    "shed_potential_energy": (
        "J",
        "potential energy of the ice when it fell, from the initial equilibrium",
    ),
}

UNITS = {
    **dict.fromkeys(("shedding", "span", "phase", "subconductor"), "1"),
    **dict.fromkeys(("from_station", "to_station", "highest_rise_station"), "1"),
    "ice": "kg/m",
    **dict.fromkeys(("time", "highest_rise_time", "clearance_time"), "s"),
    **dict.fromkeys(("highest_rise", "lowest_rise", "final_rise", "smallest_clearance"), "m"),
    **dict.fromkeys(("kinetic_energy", "potential_energy"), "J"),
    **dict.fromkeys(("unbalanced_pull", "final_unbalanced_pull"), "N"),
    **dict.fromkeys(("unbalanced_pull_tower", "final_unbalanced_pull_tower"), "1"),
}
"""Unit of each column of the table of sheddings that a run can have."""


def with_sheddings(
    dataset: xr.Dataset, mapped: LineMap, recording: Recording, state: State | None
) -> xr.Dataset:
    """Return the dataset of a run with the times of its sheddings, and where it comes to rest.

    Parameters
    ----------
    dataset
        Histories of the run.
    mapped
        Map of the model; without sheddings the dataset is returned as it is.
    recording
        What was recorded.
    state
        State at the end of the run, which stays as it is; None: the run could not start.
    """
    if not mapped.sheddings:
        return dataset
    count = len(mapped.sheddings)
    times, energies = np.full(count, np.inf), np.full((count, 2), np.nan)
    if state is not None:
        times, energies = state.shedding_times(), state.shedding_energies()
    fallen = np.isfinite(times)
    values = {
        "shed_time": np.where(fallen, times, np.nan),
        "shed_kinetic_energy": np.where(fallen, energies[:, 0], np.nan),
        "shed_potential_energy": np.where(fallen, energies[:, 1], np.nan),
    }
    made: dict[str, Any] = {
        name: ("shedding", array, _about(*VALUES[name])) for name, array in values.items()
    }
    for name, about in PLACES.items():
        made[f"shedding_{name}"] = (
            "shedding",
            [getattr(part, name) for part in mapped.sheddings],
            _about(*about),
        )
    if state is not None and fallen.any():
        made |= _settled(recording, state)
    return dataset.assign(made).set_coords([f"shedding_{name}" for name in PLACES])


def _about(unit: str, meaning: str) -> dict[str, str]:
    return {"units": unit, "long_name": meaning}


def _settled(recording: Recording, state: State) -> dict[str, Any]:
    """Return the recorded channels at rest with the ice that is left; NaN without such a state."""
    resting = copy.copy(state)
    try:
        resting.settle()
        observed = resting.observe(recording.probes)[np.newaxis]
    except SimulationError:
        observed = np.full((1, len(recording.probes)), np.nan)
    found = {}
    for name, (dimensions, values) in recording.values(observed).items():
        if name not in SETTLING and "tower" not in dimensions:
            continue
        about = DESCRIBED[name]
        meaning = f"{about.meaning}, at rest in still air with the ice left at the end of the run"
        found[f"{name}{SETTLED}"] = (dimensions[1:], values[0], _about(about.unit, meaning))
    return found


def shedding_warnings(dataset: xr.Dataset, scene: Scene | LineScene) -> Iterator[str]:
    """Yield warnings about ice that did not fall, and about a line without a new equilibrium."""
    if "shed_time" not in dataset:
        return
    end, times = float(dataset.time[-1]), dataset["shed_time"].values
    for number, shedding in enumerate(scene.shedding, start=1):
        own = times[dataset["shedding_number"].values == number]
        left = int(np.isnan(own).sum())
        if not left:
            continue
        how_much = "No ice fell" if left == len(own) else f"The ice of {left} of {len(own)} parts"
        stayed = how_much if left == len(own) else f"{how_much} did not fall"
        if shedding.time is not None:
            why = f"its time is {shedding.time:g} s and the run ends at {end:g} s"
            cure = "Run longer (run.stop_time, --stop-time), or give an earlier time"
        else:
            why = f"its limit of acceleration, {shedding.acceleration:g} m/s2, was not exceeded"
            cure = "Give a lower limit, or a time, unless this is meant"
        yield f"shedding.{number - 1} (shedding {number}): {stayed} in the run: {why}. {cure}."
    settled = [name for name in dataset.data_vars if str(name).endswith(SETTLED)]
    if settled and not any(np.isfinite(dataset[name].values).any() for name in settled):
        yield (
            "shedding: no equilibrium in still air was found with the ice that is left, so that"
            " there are no final rises. Check the tension and the strings without this ice."
        )


def sheddings(result: Result | LineResult) -> pd.DataFrame:
    """Return a row for each part of a conductor whose ice can fall.

    Rises are of the recorded nodes of the conductor in its span from the fall to the end of the
    run, clearances and pulls (forces along the line on towers with a suspension) of the whole line.
    """
    import pandas as pd

    data, mapped = result.dataset, map_of(result.scene)
    rows = []
    for index, part in enumerate(mapped.sheddings):
        time = float(data["shed_time"][index])
        row: dict[str, Any] = {
            "shedding": part.number,
            **{name: getattr(part, name) for name in PLACES if name != "number"},
            "time": time,
            "kinetic_energy": float(data["shed_kinetic_energy"][index]),
            "potential_energy": float(data["shed_potential_energy"][index]),
        }
        if np.isfinite(time):
            row |= _rises(data, mapped, part, time)
            row |= _pulls(data, mapped, time)
            row |= _clearance(result, part, time)
        rows.append(row)
    frame = pd.DataFrame(rows)
    frame.attrs = {"units": {name: unit for name, unit in UNITS.items() if name in frame}}
    return frame


def _rises(data: xr.Dataset, mapped: LineMap, part: MappedShedding, time: float) -> dict[str, Any]:
    """Return the highest and the final rise of the conductor of a part."""
    chain = mapped.chain(part.span, part.phase, part.subconductor)
    nodes = data.node.values
    own = np.flatnonzero((nodes >= chain.nodes.start) & (nodes < chain.nodes.stop))
    after = np.flatnonzero(data.time.values >= time - SAME_PLACE)
    if "u2" not in data or not len(own) or not len(after):
        return {}
    rise = data["u2"].values[np.ix_(after, own)]
    record, column = np.unravel_index(int(np.argmax(rise)), rise.shape)
    node = int(nodes[own[column]]) - chain.first_node
    found = {
        "highest_rise": float(rise[record, column]),
        "highest_rise_time": float(data.time.values[after[record]]),
        "highest_rise_station": float(chain.stations[node]),
        "lowest_rise": float(rise.min()),
    }
    if chain.middle in nodes and f"u2{SETTLED}" in data:
        middle = int(np.flatnonzero(nodes == chain.middle)[0])
        found["final_rise"] = float(data[f"u2{SETTLED}"][middle])
    return found


def _pulls(data: xr.Dataset, mapped: LineMap, time: float) -> dict[str, Any]:
    """Return the largest force along the line on a suspension tower, and the one at rest."""
    held = [tower for tower in mapped.towers if 0 < tower.tower < mapped.spans]
    name, found = "tower_force_x1", dict[str, Any]()
    if not held or name not in data:
        return found
    after = data.time.values >= time - SAME_PLACE
    at = ([tower.tower for tower in held], [tower.phase - 1 for tower in held])
    pulls = data[name].values[:, *at]
    worst = np.abs(pulls[after]).max(axis=0)
    found["unbalanced_pull"] = float(worst.max())
    found["unbalanced_pull_tower"] = held[int(worst.argmax())].tower
    if f"{name}{SETTLED}" in data:
        final = np.abs(data[f"{name}{SETTLED}"].values[at])
        if np.isfinite(final).all():
            found["final_unbalanced_pull"] = float(final.max())
            found["final_unbalanced_pull_tower"] = held[int(final.argmax())].tower
    return found


def _clearance(result: Result | LineResult, part: MappedShedding, time: float) -> dict[str, Any]:
    """Return the smallest distance of two phases in the span of a part, from its fall on."""
    from gallop_fmu.simulation.line_result import LineResult
    from gallop_fmu.simulation.line_tables import clearances

    if not isinstance(result, LineResult) or result.map.phases < 2:
        return {}
    try:
        table = clearances(result, since=time)
    except SceneError:  # displacements were not recorded
        return {}
    own = table[table["span"] == part.span] if len(table) else table
    if not len(own):
        return {}
    least = own.loc[own["smallest"].idxmin()]
    return {
        "smallest_clearance": float(least["smallest"]),
        "clearance_time": float(least["time"]),
    }
