"""Ice that falls, against OpenSees, mechaphlowers and a lumped chain."""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.engine.model import Model
from gallop_fmu.engine.probes import junction_probes
from support.line_references import line_scene, mass_proportional, mean_strain, stored

DRAKE = stored("ice_shed_drake_300m")
ONE_SPAN = stored("ice_on_one_span")
TOLERANCE = 0.01
"""Relative difference that the project's specification allows."""


def drake(shed, kind):
    """Return the stored span as a scene of one span, or as a line of one span."""
    scene = dict(DRAKE["scene"])
    share = 1.0 / (1.0 + scene["horizontal_tension"] / scene["conductor"]["axial_stiffness"])
    mass = scene["conductor"]["mass_per_rest_length"] * share
    tables = {
        "title": "ice that falls",
        "conductor": {
            "diameter": 0.028,
            "mass_per_length": mass,
            "axial_stiffness": scene["conductor"]["axial_stiffness"],
            "torsional_stiffness": 159.0,
            "torsional_inertia": 2e-4,
        },
        "ice": {"mass_per_length": scene["ice"]["mass_per_length"] * share},
        "damping": {
            "translation": mass_proportional(scene["damping"]["translation_mass_proportional"])
        },
        "numerics": {"elements": 20, "time_step": 0.01, "integrator": "gauss6"},
    }
    part = {"time": 0.0, "from_station": shed[0], "to_station": shed[1]}
    tension, length = scene["horizontal_tension"], scene["spans"][0]["length"]
    if kind == "span":
        span = {"length": length, "horizontal_tension": tension}
        return gf.Scene.from_dict({**tables, "span": span, "shedding": [part]})
    section = {"horizontal_tension": tension, "strung_with_ice": True, "spans": [{"length": 300.0}]}
    return gf.LineScene.from_dict({**tables, "section": section, "shedding": [{"span": 1, **part}]})


@pytest.mark.parametrize("kind", ["span", "line"])
@pytest.mark.parametrize("case", range(2), ids=["all", "middle half"])
def test_drake(case, kind):
    """Observed: jump 0.1 and 0.35 %, its time 0.3 %, final rises 0.02 %.

    The quarter point is 0.97 % below the stored one, and 0.13 % above that of the same program run
    again (`repeated`).
    """
    wanted = DRAKE["results"]["cases"][case]
    result = gf.simulate(drake(wanted["shed"], kind), 5.0, record_nodes="all")
    [row] = result.sheddings.to_dict("records")
    assert row["time"] == 0.0
    assert row["highest_rise_station"] == 0.5
    assert row["highest_rise"] == pytest.approx(wanted["jump"], rel=TOLERANCE)
    assert row["highest_rise_time"] == pytest.approx(wanted["time_of_jump"], rel=TOLERANCE)
    assert row["final_rise"] == pytest.approx(wanted["final_rise"], rel=1e-3)
    if kind == "span":
        sag = result.dataset.attrs["sag"]
    else:
        sag = result.dataset["sag"].item()
    assert sag == pytest.approx(wanted["iced_sag"], rel=1e-4)
    if "quarter_point" in wanted:
        quarter = result.dataset["u2"].sel(node=10).max()
        assert float(quarter) == pytest.approx(wanted["quarter_point"], rel=TOLERANCE)
        again = DRAKE["repeated"]["cases"][case]["160 elements"]["quarter_point"]
        assert float(quarter) == pytest.approx(again, rel=3e-3)


def test_zebra():
    """Strung bare, then iced. The stored "first peak" is the rise at 1.0 s; see its `repeated`.

    Observed: 0.2 % of the rise, 0.13 % of the peak, 0.5 % of its time.
    """
    case = stored("ice_shed_zebra_300m")
    scene, wanted, again = case["scene"], case["results"], case["repeated"]["160 elements"]
    scene["conductor"]["diameter"] = 0.0286
    ice = scene["ice"]["mass_per_length"] / (1.0 + mean_strain(scene))
    line = line_scene(
        case,
        24,
        ice={"mass_per_length": ice},
        shedding=[{"span": 1, "time": 0.0}],
        numerics={"elements": 24, "time_step": 0.002, "integrator": "gauss6"},
    )
    result = gf.simulate(line, 1.4)
    assert result.dataset["sag"].item() == pytest.approx(wanted["iced_sag"], rel=1e-4)
    rise = result.midspan()["u2"]
    at = wanted["time_of_first_peak"]
    found = float(rise.sel(time=at, method="nearest"))
    assert found == pytest.approx(wanted["first_peak_mid_span"], rel=TOLERANCE)
    first = int(np.argmax(np.diff(rise.values) < 0.0))
    assert rise.values[first] == pytest.approx(again["first_peak_mid_span"], rel=TOLERANCE)
    when = float(rise.time[first])
    assert when == pytest.approx(again["time_of_first_peak"], rel=TOLERANCE)


@pytest.mark.parametrize("state", ONE_SPAN["results"]["states"], ids=lambda s: str(s["iced"]))
@pytest.mark.parametrize("way", ["ice by span", "ice that falls"])
def test_unbalanced_pull(state, way):
    """Both programs within 0.5 %, whether a span had no ice from the start or lost it.

    Observed: OpenSees 0.01 %, mechaphlowers 0.12 % (its own difference from OpenSees).
    """
    scene, iced = ONE_SPAN["scene"], state["iced"]
    ice = scene["ice"]["mass_per_length"]
    case = {"kind": "ice on one span", "scene": scene}
    if way == "ice by span":
        spans = [
            {**s, "ice_mass_per_length": ice * on}
            for s, on in zip(scene["spans"], iced, strict=True)
        ]
        model = Model(line_scene({**case, "scene": {**scene, "spans": spans}}, 16))
        pulls = [float(model.observe_equilibrium(_pull(model, tower))[0]) for tower in (1, 2)]
    else:
        falls = [{"span": k, "time": 0.0} for k, on in enumerate(iced, 1) if not on]
        shedding = {"ice": {"mass_per_length": ice}, "shedding": falls}
        result = gf.simulate(line_scene(case, 16, **shedding), 0.02)
        name = "force_x1_settled" if falls else "preload_x1"
        pulls = result.towers[name].values[1:3]
    wanted = state["opensees"]["unbalanced_pull"]
    assert pulls == pytest.approx(wanted, rel=5e-3)
    assert pulls == pytest.approx(state["mechaphlowers"]["unbalanced_pull"], rel=5e-3)


def _pull(model, tower):
    """Probes of the force of the conductor on a tower, along the line first."""
    return junction_probes(model.map.tower(tower).junctions[0])
