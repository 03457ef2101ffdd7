"""Ice that cannot fall as a scene says: refused with number and remedy; and unusual curves."""

import re
import tomllib

import pytest

import gallop_fmu as gf
from gallop_fmu.foundation.errors import SceneError
from support.sections import DRAKE, section

LIFT = {
    **{"kind": "polynomial", "lift": [0.0, -1.0], "drag": [1.0], "moment": [0.0]},
    **{"valid_from_deg": -60.0, "valid_to_deg": 60.0},
}
ICE = {"mass_per_length": 1.0}


def span(*shedding, **tables):
    data = {
        "title": "span",
        "span": {"length": 300.0, "horizontal_tension": 35e3},
        "conductor": DRAKE,
        "ice": ICE,
        "numerics": {"elements": 8},
    }
    return gf.Scene.from_dict({**data, **tables, "shedding": list(shedding)})


def line(*shedding, **tables):
    return section(**{"ice": ICE, **tables, "shedding": [{"span": 1, **one} for one in shedding]})


def part(start, stop, time=1.0, **more):
    return {"from_station": start, "to_station": stop, "time": time, **more}


TWICE = (part(0.0, 0.5), part(0.4, 1.0))
NARROW = {**LIFT, "valid_from_deg": 10.0}
BOTH = {
    "twice": (TWICE, {}, r"shedding\.1 \(shedding 2\): the ice on (the span|span 1) from 0\.4 to"
              r" 0\.5 falls already by shedding 1, and ice falls once; make the two adjoin"),
    "no ice": ((part(0.0, 1.0),), {"ice": {}}, r"shedding\.0 \(shedding 1\): there is no ice on .*"
               r"give ice"),
    "backwards": ((part(0.5, 0.2),), {}, r"from_station = 0\.5 must be less than to_station = 0\.2;"
                  r" exchange them"),
    "outside": ((part(0.5, 1.2),), {}, r"shedding\.0\.to_station.*1\.2"),
    "before the span": ((part(-0.1, 0.5),), {}, r"shedding\.0\.from_station.*-0\.1"),
    "neither": ((part(0.0, 1.0, None),), {}, "neither of time .* give exactly one"),
    "both": ((part(0.0, 1.0, acceleration=5.0),), {}, "both of time .* give exactly one"),
    "negative time": ((part(0.0, 1.0, -1.0),), {}, r"shedding\.0\.time.*-1"),
    "angle": ((part(0.0, 1.0, aerodynamics=NARROW),),
              {"wind": {"speed": 5.0}, "aerodynamics": LIFT},
              r"the attack angle of the bare conductor, 0 deg, is outside its coefficient curve"),
}  # fmt: skip


@pytest.mark.parametrize("build", [span, line])
@pytest.mark.parametrize("case", BOTH)
def test_refused(case, build):
    sheddings, tables, message = BOTH[case]
    with pytest.raises(SceneError, match=message):
        build(*sheddings, **tables)


MESH = {
    "few": (
        (part(0.1, 0.2), part(0.3, 0.4)),
        {"elements": 8},
        r"divides half of the span into 5 parts with at least one element each; give at least 10",
    ),
    "close": (
        (part(0.0, 0.49999),),
        {"elements": 8},
        r"0\.49999 and 0\.5 of the span are 0\.003 m",
    ),
}


@pytest.mark.parametrize("case", MESH)
def test_a_mesh_that_does_not_fit_is_refused(case):
    sheddings, numerics, message = MESH[case]
    with pytest.raises(SceneError, match=message):
        span(*sheddings, numerics=numerics)


def test_numbers_of_a_line_are_no_keys_of_a_span():
    with pytest.raises(SceneError, match=r"shedding\.0\.span"):
        span({"span": 1, "time": 1.0})
    with pytest.raises(SceneError, match="span = 4, but the line has 3 spans"):
        section(ice=ICE, shedding=[{"span": 4, "time": 1.0}])


def test_adjoining_parts_and_other_phases_may_fall():
    assert len(span(part(0.0, 0.5), part(0.5, 1.0)).shedding) == 2
    phases = [{"name": "a"}, {"name": "b", "offset": [4.0, 0.0]}]
    falls = [part(0.0, 0.6, phase=1), part(0.3, 1.0, phase=2)]
    assert len(line(*falls, phases=phases).shedding) == 2


ECCENTRIC = {**ICE, "torsional_inertia": 4e-4, "first_moment_x3": -2e-3}
ROUND = {**LIFT, "lift": [0.0]}
CONTRADICTIONS = {
    "lift of round ice": (ICE, LIFT, "the first moments of the ice are 0, as for round or no ice"),
    "eccentric ice without lift": (
        ECCENTRIC,
        ROUND,
        r"the first moments of the ice are 0 and -0\.002 kg, as for ice on one side, but the"
        r" coefficient curve has no lift",
    ),
}


@pytest.mark.parametrize("build", [span, line])
@pytest.mark.parametrize("case", CONTRADICTIONS)
def test_ice_against_its_curve_is_warned_of(case, build):
    ice, curve, message = CONTRADICTIONS[case]
    scene = build(ice=ice, wind={"speed": 5.0}, aerodynamics=curve)
    assert any(re.search(message, text) for text in scene.warnings)


@pytest.mark.parametrize("build", [span, line])
@pytest.mark.parametrize(("ice", "curve"), [(ICE, ROUND), (ECCENTRIC, LIFT)])
def test_ice_that_fits_its_curve_is_not_warned_of(build, ice, curve):
    scene = build(ice=ice, wind={"speed": 5.0}, aerodynamics=curve)
    assert not any("first moments" in text for text in scene.warnings)


@pytest.mark.parametrize("build", [span, line])
def test_an_own_curve_of_the_bare_conductor_is_checked(build):
    wild = {**ROUND, "drag": [-1.0]}
    scene = build(part(0.0, 1.0, aerodynamics=wild))
    assert any("drag acts along the wind" in text for text in scene.warnings)
    assert scene.shedding[0].bare_curve.drag == (-1.0,)


def test_a_scene_with_shedding_is_written_and_read():
    scene = span(part(0.25, 0.75), part(0.0, 0.25, None, acceleration=5.0))
    assert gf.Scene.from_dict(tomllib.loads(scene.to_toml())) == scene
