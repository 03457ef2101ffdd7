"""A section of three spans that a pulse moves, against OpenSees (320 elements a span, 0.001 s)."""

import numpy as np
import pytest

import gallop_fmu as gf
from support.line_references import line_scene, series, stored

BOUND = 0.005
"""Relative RMS of each series; 0.0029 seen, of the clamp along the line."""

PULSE = {"kind": "pulse", "peak": 1.0, "start": 0.0, "rise": 1.0, "fall_start": 1.5, "fall": 0.5}


def simulated(case):
    """The columns of the case: mid-spans and the first clamp along x1, x2, x3."""
    given = case["scene"]["load"]
    load = {"span": given["span"], "position": given["station_of_rest_length"]}
    scene = line_scene(
        case,
        elements=30,
        loads=[{**load, "force": given["force"], "law": PULSE}],
        numerics={"elements": 30, "time_step": 0.01, "integrator": "gauss6"},
    )
    result = gf.simulate(scene, float(series(case)[0][-1]), record_every=5)
    clamp = result.map.node_of_junction[result.map.tower(1).junctions[0]]
    nodes = [*(result.map.chain(span).middle for span in (1, 2, 3)), clamp]
    return [result.dataset[f"u{axis}"].sel(node=n).values for n in nodes for axis in (1, 2, 3)]


@pytest.mark.xdist_group("pulse")
def test_every_series_of_the_drake_section():
    case = stored("section3_pulse")
    for number, (ours, theirs) in enumerate(zip(simulated(case), series(case)[1:], strict=True)):
        rms = np.sqrt(np.mean((ours - theirs) ** 2) / np.mean(theirs**2))
        assert rms < BOUND, (number, rms)
