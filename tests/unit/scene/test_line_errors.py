"""Lines that are refused, and warnings: span, suspension, phase or device by number, and a cure."""

import re

import pytest

import gallop_fmu as gf
from gallop_fmu.foundation.text_files import parse_toml
from gallop_fmu.scene.line_consistency import MIN_PART
from support.lines import LINE

BARE = gf.LineScene.from_dict(parse_toml(LINE))
CURVE = {
    "kind": "polynomial",
    "valid_from_deg": -90.0,
    "valid_to_deg": 90.0,
    "lift": [0.0, -2.0],
    "drag": [1.0],
    "moment": [0.0],
}
PENDULUM = {"kind": "pendulum", "span": 2, "station": 0.5, "mass": 20.0, "arm": 0.5}
SPACER = {"kind": "interphase_spacer", "span": 1, "station": 0.5, "phases": [1, 2]}
INTERVAL = {"kind": "interval", "span": 1, "from_station": 0.2, "to_station": 0.6, "ice": "none"}
STRING = {"kind": "string", "length": 2.4, "weight": 600.0}
V_STRING = {"kind": "v_string", "length": 2.4, "weight": 300.0, "half_spread": 1.5}
ONE = {"bundle": {}, "phases": [{"name": "a"}], "loads": []}
"""Values of a line with one conductor."""


@pytest.mark.parametrize(
    ("values", "message"),
    [
        # numbers of suspensions
        (
            {"section.suspensions": [STRING]},
            r"suspensions: 1 given, but 3 spans need 2; give one between each two spans",
        ),
        (
            {"section.spans": [{"length": 300.0}], "devices": [], "loads": []},
            r"suspensions: 2 given, but 1 span needs 0",
        ),
        # numbers that the line does not have
        (
            {"devices.0.span": 7},
            r"devices\.0 \(device 1\): span = 7, but the line has 3 spans; give a number from 1 to",
        ),
        ({"devices.0.span": 0}, r"devices\.0\.span \(device 1\) = 0: must be .*at least 1"),
        ({"devices.1.phase": 3}, r"\(device 2\): phase = 3, but the line has 2 phases"),
        ({"devices.1.subconductor": 5}, r"subconductor = 5, but the line has 4 subconductors"),
        ({"loads.0.span": 4}, r"loads\.0 \(load 1\): span = 4, but the line has 3 spans"),
        ({"devices": [{**SPACER, "phases": [1, 3]}]}, r"phases = 3, but the line has 2 phases"),
        (
            {"section.sag": 5.0, "section.sag_span": 4, "section.horizontal_tension": None},
            r"sag_span = 4: the section has 3 spans; give a number from 1 to 3",
        ),
        # stations
        ({"devices.0.station": 1.0}, r"station \(device 1\) = 1\.0: must be .*less than 1"),
        (
            {"bundle.spacers": None, "bundle.stations": [0.2, 0.6, 0.4]},
            r"stations must increase: spacer 3 is at 0\.4 after 0\.6",
        ),
        (
            {"bundle.spacers": None, "bundle.stations": [0.2, 0.2]},
            r"spacer 2 is at 0\.2 after 0\.2; sort them, and remove double ones",
        ),
        (
            {"bundle.spacers": None, "bundle.stations": [0.2, 1.2]},
            r"spacer 2 is at 1\.2; must be greater than 0 and less than 1",
        ),
        ({"bundle.stations": [0.2]}, r"spacers = 6 and stations are both given"),
        (
            {"devices.0.station": 3 / 7 + 2e-5},
            r"spacer 3 and device 1 are 0\.007 m apart at station .* of span 2; give them the same",
        ),
        (
            {"devices.0.station": 1e-5},
            r"device 1 is at station 1e-05 of span 2, 0\.0035 m from its end; must be",
        ),
        (
            {"devices": [PENDULUM, {**PENDULUM, "phase": 2}]},
            r"device 1 and device 2 are both of kind pendulum at station 0\.5 of span 2 on phase 2",
        ),
        (
            {"devices": [SPACER, {**SPACER, "phases": [2, 1]}]},
            r"device 1 and device 2 are both of kind interphase_spacer between phases 1 and 2",
        ),
        (
            {"numerics.elements": 7},
            r"span 2: 7 elements, but .* divide phase 1 subconductor 1 into 8 parts .*at least 8",
        ),
        # intervals
        (
            {"devices": [INTERVAL, {**INTERVAL, "from_station": 0.5, "to_station": 0.9}]},
            r"devices\.1 \(device 2\): its interval from 0\.5 to 0\.9 overlaps that of device 1",
        ),
        ({"devices.1.to_station": 0.25}, r"from_station = 0\.25 must be less than to_station"),
        ({"devices.1.ice": None}, r"changes nothing; give ice"),
        # bundle
        (
            {"bundle.subconductors": 1, "bundle.spacing": None},
            r"spacers is given, but subconductors = 1: a single conductor has no spacers",
        ),
        ({"bundle.orientation": "vertical"}, r"only a twin bundle .* not a bundle of 4"),
        (
            {"bundle.spacing": None, "bundle.offsets": [[0, 0], [0, 1]]},
            r"offsets has 2 positions for 4 subconductors",
        ),
        (
            {"bundle.offsets": [[0, 0], [0, 1], [1, 0], [1, 1]]},
            r"both of spacing \[m\] and offsets",
        ),
        ({"bundle.spacing": None}, r"neither of spacing \[m\] and offsets"),
        (
            {"bundle.spacing": None, "bundle.offsets": [[0, 0], [0, 1], [0.01, 0], [1, 1]]},
            r"subconductors 1 and 3 are 0\.01 m apart and touch",
        ),
        (
            {**ONE, "bundle": {"yoke_mass": 5.0}},
            r"yoke_mass = 5, but a single conductor has no yoke",
        ),
        # phases
        ({"phases.1.name": "a"}, r"\(phase 2\): name = 'a' is also that of phase 1"),
        ({"phases.1.offset": [0.45, 0.01]}, r"\(phase 2\): it touches phase 1, at a distance of"),
        (
            {"phases.1.offset": [-2.0, 0.0]},
            r"suspension 1\): length = 2\.4 m, so the string of phase 2 passes phase 1",
        ),
        ({"devices": [{**SPACER, "phases": [1, 1]}]}, r"connects two different phases"),
        # strings and ends
        (
            {"section.suspensions.0.length": 2400.0},
            r"suspension 1\): length = 2400 m must be less than half the shorter span .* 150 m",
        ),
        ({"section.left_end.length": 150.0}, r"left_end: length = 150 m must be less than half"),
        (
            {"section.suspensions.0": V_STRING},
            r'kind = "v_string" holds a single conductor, not the yoke of a bundle of 4',
        ),
        ({"section.suspensions.0": {**V_STRING, "half_spread": 2.4}}, r"half_spread = 2\.4 m must"),
        (
            {"section.suspensions.0.clamp_torsional_stiffness": 10.0},
            r"give bundle\.clamp_torsional_stiffness in its place",
        ),
        # strung state
        ({"section.spans.1.height_difference": -350.0}, r"height_difference = -350 m must be less"),
        ({"section.horizontal_tension": 25.0}, r"span 1: .* 25 N is less than .*; is it in kN\?"),
        ({"section.horizontal_tension": 1e11}, r"span 1: .* 1e\+11 N is more than 1e\+06 times"),
        ({"section.horizontal_tension": None}, r"neither of horizontal_tension \[N\] and sag"),
        ({"section.sag": 5.0}, r"both of horizontal_tension \[N\] and sag \[m\]"),
        (
            {"section.sag": 5.0, "section.horizontal_tension": None},
            r"only one of sag and sag_span given; give sag_span",
        ),
        (
            {"section.sag": 9e3, "section.sag_span": 2, "section.horizontal_tension": None},
            r"section\.sag = 9000 m is more than 5 times the length 350 m of span 2; is it in",
        ),
        (
            {"section.sag": 1e-5, "section.sag_span": 2, "section.horizontal_tension": None},
            r"section\.sag = 1e-05 m is less than 1e-06 of the length 350 m of span 2; is it in km",
        ),
        (
            {"section.temperature_deg_c": -5.0},
            r"thermal_expansion: missing; section\.temperature_deg_c = -5 differs from .* = 15",
        ),
        # ice and curves
        ({"wind.speed": 4.0}, r"wind is given but aerodynamics is not"),
        (
            {"wind.speed": 4.0, "aerodynamics": CURVE, "section.spans.1.ice.attack_angle_deg": 120},
            r"section\.spans\.1\.ice \(span 2\)\.attack_angle_deg = 120.* outside the coefficient",
        ),
        (
            {"section.spans.1.ice.first_moment_x2": 9.0},
            r"section\.spans\.1\.ice \(span 2\)\.first_moment_x2 = 9\.0 kg .* too large",
        ),
        (
            {"devices.1.ice.first_moment_x3": 9.0},
            r"devices\.1\.ice \(device 2\)\.first_moment_x2 = 0\.0 kg and .* too large",
        ),
        # kinds and keys
        ({"devices.0.kind": "bell"}, r"devices\.0\.kind \(device 1\) = 'bell': must be one of"),
        ({"devices.4.mass": 1.0}, r"devices\.4 is not given in this scene"),
        ({"section.spans.1.lenth": 1.0}, r"closest valid one is section\.spans\.1\.length"),
        (
            {"devices": [{"kind": "damper", "span": 1, "station": 0.5, "damping": 5.0,
                          "hanging_mass": 3.0}]},
            r"only one of hanging_mass \[kg\] and hanging_stiffness",
        ),
    ],
)  # fmt: skip
def test_bad_line_is_refused_with_number_and_cure(values, message):
    with pytest.raises(gf.SceneError, match=message):
        BARE.with_values(values)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        (
            {"section.horizontal_tension": 3e3},
            r"span 2: the sag in the strung state is 8\d\.\d m, 0\.2\d+ of its length 350 m; usual",
        ),
        (
            {"section.rated_strength": 20e3},
            r"span 3: the tension in the strung state reaches 2\.51e\+04 N, more than",
        ),
        (
            {"section.horizontal_tension": 7e5},
            r"section\.horizontal_tension: the horizontal tension of 7e\+05 N is more than 2%",
        ),
        ({"bundle.spacers": 0}, r"bundle: 4 subconductors without spacers"),
        ({"devices": [SPACER]}, r"devices\.0 \(device 1\): .* subconductor 1 of each bundle"),
        ({"phases.1.offset": [0.0, 0.2]}, r"phases 1 and 2: conductors are 0\.2 m apart"),
        (
            {"section.suspensions.0.length": 60.0},
            r"suspensions\.0\.length \(suspension 1\) = 60 m is outside the usual 0\.2 to 10 m",
        ),
        ({"section.temperature_deg_c": 180.0, "conductor.thermal_expansion": 2e-5},
         r"section\.temperature_deg_c = 180 degC is outside"),
        (
            {"wind.speed": 4.0, "aerodynamics": CURVE},
            r"section\.spans\.1\.ice \(span 2\): the first moments of the ice are 0",
        ),
    ],
)  # fmt: skip
def test_unusual_line_is_warned_of(values, message):
    found = BARE.with_values(values).warnings
    assert any(re.search(message, text) for text in found), found


def test_the_line_itself_has_no_warnings():
    assert BARE.warnings == ()


def test_a_repeated_problem_is_reported_once():
    """Both pendulums are on all eight conductors."""
    with pytest.raises(gf.SceneError) as caught:
        BARE.with_values({"devices": [PENDULUM, PENDULUM]})
    assert len(str(caught.value).splitlines()) == 1


def test_stations_one_part_apart_are_accepted():
    near = {**PENDULUM, "kind": "mass", "station": 0.5 + 1.01 * MIN_PART / 350.0}
    del near["arm"]
    BARE.with_values({"devices": [PENDULUM, near]})


def test_v_string_and_elastic_clamp_hold_a_single_conductor():
    values = {**ONE, "section.suspensions": [V_STRING, {**STRING, "clamp_torsional_stiffness": 9}]}
    line = BARE.with_values(values)
    assert line.section.suspensions[0].half_spread == 1.5
    assert line.section.suspensions[1].clamp_torsional_stiffness == 9.0


def test_different_devices_share_a_station():
    other = {"kind": "mass", "span": 2, "station": 0.5, "mass": 3.0}
    assert len(BARE.with_values({"devices": [PENDULUM, other]}).devices) == 2
