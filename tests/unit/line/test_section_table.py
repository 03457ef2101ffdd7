"""Sections from tables of towers, also those of mechaphlowers with its cable catalogue."""

import math
from pathlib import Path

import pytest

import gallop_fmu as gf
from gallop_fmu.line.cable_catalogue import find_cable
from gallop_fmu.line.conductors import find_conductor
from gallop_fmu.line.section_table import section_data
from gallop_fmu.line.tower_table import read_towers
from gallop_fmu.scene.sag_tension import ruling_span

TOWERS = """\
Tower;Type;Span length [m];Attachment height [m];String length [m];String weight [kN]
T1;tension;300;130;;
T2;suspension;350;132.5;2.4;0.6
T3;post;280;128;;
T4;dead end;;130;3;0.8
"""
# A table as `SectionArray.data.to_csv` of mechaphlowers writes it: the section of 500, 300 and 400
# m with which its statics were computed (tests/analytic), strung at H/w = 2000 m and 15 deg C.
MECHAPHLOWERS = """\
,name,suspension,conductor_attachment_altitude,crossarm_length,line_angle,insulator_length,span_length,insulator_mass,sagging_parameter,sagging_temperature
0,A,False,30.0,0.0,0.0,3.0,500.0,100.0,2000.0,15.0
1,B,True,30.0,0.0,0.0,3.0,300.0,50.0,2000.0,15.0
2,C,True,30.0,0.0,0.0,3.0,400.0,50.0,2000.0,15.0
3,D,False,30.0,0.0,0.0,3.0,,100.0,,
"""
# Columns of mechaphlowers' sample_cable_database.csv, as far as they are read.
CATALOGUE = """\
name,section,diameter,young_modulus,linear_mass,dilatation_coefficient,is_polynomial,rts_cable
ASTER600,600.4,31.86,60000,1.8,2.3E-05,False,200000
NARCISSE600G,600.4,29.56,75565,2.2,1.77E-05,True,
TWICE,600.4,29.56,75565,2.2,1.77E-05,True,1
twice,600.4,29.56,75565,2.2,1.77E-05,True,1
BAD,600.4,-29.56,75565,2.2,1.77E-05,True,1
"""
DRAKE = {"section": "towers.csv", "conductor": "Drake", "stringing_percent": 20.0}


@pytest.fixture
def folder(tmp_path):
    for name, text in (("towers", TOWERS), ("mech", MECHAPHLOWERS), ("cables", CATALOGUE)):
        (tmp_path / f"{name}.csv").write_text(text, encoding="utf-8")
    return tmp_path


def made(folder, **options):
    values = {name: value for name, value in (DRAKE | options).items() if value is not None}
    return gf.LineScene.from_dict(section_data(values, folder), folder)


def test_a_table_of_towers_becomes_a_section(folder):
    line, wire = made(folder), find_conductor("Drake")
    section = line.section
    assert [span.length for span in section.spans] == [300.0, 350.0, 280.0]
    assert [span.height_difference for span in section.spans] == [2.5, -4.5, 2.0]
    assert [line.elements_of_span(span) for span in (1, 2, 3)] == [15, 18, 15]
    string, post = section.suspensions
    assert (string.kind, string.length, string.weight) == ("string", 2.4, 600.0)
    assert post.kind == "post"
    assert section.left_end.kind == "rigid"
    assert (section.right_end.kind, section.right_end.weight) == ("string", 800.0)
    assert section.horizontal_tension == pytest.approx(0.2 * wire.rated_strength, rel=1e-14)
    assert section.rated_strength == wire.rated_strength
    assert (section.strung_temperature_deg_c, section.temperature_deg_c) == (15.0, 0.0)
    assert line.conductor.thermal_expansion == wire.thermal_expansion
    assert line.conductor.axial_stiffness == wire.axial_stiffness


def test_every_value_of_a_made_section_has_a_source(folder):
    line = made(folder, wind_speed=4.0, coefficients="example3", attack_angle_deg=180.0)
    given = [path for path in line.numbers() if "." in path]
    without = [
        path
        for path in given
        if not any(path == s or path.startswith(s + ".") for s in line.sources)
    ]
    # The bundle of one conductor has defaults only.
    assert [path for path in without if not path.startswith("bundle.")] == []


def test_damping_and_ice_are_those_of_the_ruling_span(folder):
    line = made(folder, ice_thickness=0.01, attack_angle_deg=30.0)
    alone = gf.Scene.from_dict(
        {
            "line": {
                "conductor": "Drake",
                "span": ruling_span([300.0, 350.0, 280.0]),
                "stringing_percent": 20.0,
                "ice_thickness": 0.01,
                "attack_angle_deg": 30.0,
            }
        }
    )
    assert line.ice == alone.ice
    assert line.damping == alone.damping
    assert line.wind == alone.wind


def test_a_table_and_a_catalogue_of_mechaphlowers_become_a_section(folder):
    line = made(
        folder, section="mech.csv", catalogue="cables.csv", conductor="aster600",
        stringing_percent=None,
    )  # fmt: skip
    section, conductor = line.section, line.conductor
    assert [span.length for span in section.spans] == [500.0, 300.0, 400.0]
    assert section.horizontal_tension == pytest.approx(2000.0 * 1.8 * 9.81, rel=1e-14)
    assert section.strung_temperature_deg_c == 15.0
    assert [s.weight for s in section.suspensions] == pytest.approx([50 * 9.81] * 2, rel=1e-14)
    assert section.left_end.weight == pytest.approx(100 * 9.81, rel=1e-14)
    assert conductor.axial_stiffness == pytest.approx(600.4e-6 * 60e9, rel=1e-14)
    assert conductor.diameter == pytest.approx(31.86e-3, rel=1e-14)
    assert (conductor.mass_per_length, conductor.thermal_expansion) == (1.8, 2.3e-5)
    assert section.rated_strength == 200e3


def test_polynomials_of_a_catalogue_are_said_not_to_be_used(folder):
    cable = find_cable(folder / "cables.csv", "NARCISSE600G")
    assert "polynomials of the cable are not used" in cable.value_sources["axial_stiffness"]
    assert cable.rated_strength is None
    assert cable.torsional_inertia == pytest.approx(2.2 * 0.02956**2 / 8, rel=1e-14)


def test_bundle_of_a_section(folder):
    line = made(folder, subconductors=4, spacing=0.45, spacers=11)
    assert (line.bundle.subconductors, line.bundle.spacers) == (4, 11)
    assert line.section.right_end.weight == 200.0
    assert [line.elements_of_span(span) for span in (1, 2, 3)] == [24, 24, 24]
    with pytest.raises(gf.SceneError, match="a single conductor has no spacers"):
        made(folder, spacers=3)


def test_a_v_string_of_a_table_has_two_bars(folder):
    text = TOWERS.replace("[kN]", "[kN];half spread [m]").replace("suspension;", "V-string;")
    text = text.replace("2.4;0.6", "2.4;0.6;1.5")
    (folder / "towers.csv").write_text("".join(_padded(text, 7)), encoding="utf-8")
    v_string = made(folder).section.suspensions[0]
    assert (v_string.kind, v_string.weight, v_string.half_spread) == ("v_string", 300.0, 1.5)


def _padded(text, width):
    for line in text.splitlines():
        yield line + ";" * (width - 1 - line.count(";")) + "\n"


@pytest.mark.parametrize(
    ("header", "length"),
    [
        ("Span", 300.0),
        ("SPAN LENGTH (m)", 300.0),
        ("ahead-span", 300.0),
        ("span_length [ft]", 91.44),
        ("Span length [cm]", 3.0),
    ],
)
def test_names_and_units_of_columns(folder, header, length):
    path = folder / "towers.csv"
    path.write_text(f"name,{header}\nA,300\nB,300\nC,\n", encoding="utf-8")
    assert read_towers(path, 9.81).towers[0].span_length == pytest.approx(length, rel=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("T2;", "T3;", r"row 4: tower T3 is in row 3, too"),
        (
            "T2;suspension;350;132.5;2.4;0.6\n",
            "",
            r"row 3: tower T3 follows tower T1; tower T2 is missing: insert it, or give the towers",
        ),
        ("T2;", ";", r"row 3: the tower has no name"),
        ("350;", ";", r"row 3: tower T2 has no span_length, but tower T3 follows; give the span"),
        ("350;", "-350;", r"row 3: span_length after tower T2 is -350 m; must be greater than 0"),
        ("350;", "350e6;", r"row 3: span_length after tower T2 is 3\.5e\+08 m; must .*most 10000"),
        ("350;", "35O;", r"Span length \[m\] in row 3 is '35O', must be a finite number"),
        ("350;", "350,5;", r"row 3 .* write 350\.5, with a decimal point"),
        (
            "end;;",
            "end;100;",
            r"row 5: the last tower T4 has a span of 100 m, but no tower",
        ),
        ("suspension;", "anchor;", r"row 3: tower T2 is a tension tower \(anchor\) within the"),
        ("tension;", "suspension;", r"row 2: tower T1 is at an end of the section and of type"),
        ("suspension;", "portal;", r"row 3: tower T2 has the type 'portal'; allowed are susp"),
        ("132.5;", ";", r"row 3: tower T2 has no attachment_height, but others have one"),
        ("2.4;0.6", ";0.6", r"row 3: suspension tower T2 has no string_length \[m\]; give it in"),
        ("2.4;0.6", "2.4;", r"row 3: suspension tower T2 has no string_weight \[N\]"),
        ("2.4;0.6", "-2.4;0.6", r"row 3: string_length of tower T2 is -2\.4; must not be neg"),
        ("2.4;0.6", "400;0.6", r"suspension 1\): length = 400 m must be less than half"),
        ("3;0.8", "3;", r"row 5: tension tower T4 has a string without string_weight"),
        ("suspension;", "v-string;", r"row 3: tower T2 has a V-string without half_spread"),
        ("[kN]", "[kp]", r"'String weight \[kp\]' has the unit kp; allowed are n, kn, dan, lbf"),
        ("Type", "Colour", r"column 'Colour' is unknown; a table of towers has tower, span_length"),
        ("Type", "Span", r"columns 'Span' and 'Span length \[m\]' are both the span_length"),
        ("Span length [m]", "Tower height", r"has no column span_length; a table of towers has"),
    ],
)
def test_a_bad_table_is_refused_with_its_row(folder, old, new, message):
    path = folder / "towers.csv"
    assert old in TOWERS
    path.write_text(TOWERS.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(gf.SceneError, match=message):
        made(folder)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        (
            "1,B,True,30.0,0.0,0.0",
            "1,B,True,30.0,0.0,4.5",
            r"mech\.csv: row 3: tower B has a line angle of 4\.5 deg; a section must be straight",
        ),
        (
            "2,C,True,30.0,0.0",
            "2,C,True,30.0,8.0",
            r"row 4: crossarm_length of tower C is 8 m, and 0 m of tower B; a section must be",
        ),
        ("500.0,100.0,2000.0", "500.0,100.0,1900.0", r"row 3: sagging_parameter is 2000 m, and"),
        ("insulator_mass", "counterweight_mass", r"tower A has a counterweight of 100 kg"),
    ],
)  # fmt: skip
def test_a_bad_table_of_mechaphlowers_is_refused(folder, old, new, message):
    (folder / "mech.csv").write_text(MECHAPHLOWERS.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(gf.SceneError, match=message):
        made(folder, section="mech.csv", catalogue="cables.csv", conductor="ASTER600",
             stringing_percent=None)  # fmt: skip


def test_line_angle_at_an_end_and_columns_without_use_are_accepted(folder):
    text = MECHAPHLOWERS.replace("0,A,False,30.0,0.0,0.0", "0,A,False,30.0,0.0,-19.1")
    text = text.replace("sagging_temperature", "support_height")
    (folder / "mech.csv").write_text(text, encoding="utf-8")
    line = made(folder, section="mech.csv", stringing_percent=None)
    assert line.notes == ("mech.csv: column support_height is not used",)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"span": 300.0}, r"span = 300\.0: a section has its spans in the table of towers"),
        ({"conductor": "ASTER600"}, r"'ASTER600' is not a code word .* needs its catalogue"),
        (
            {"catalogue": "cables.csv", "conductor": "ASTER60"},
            r"cables\.csv: has no cable 'ASTER60'; closest: ASTER600",
        ),
        ({"catalogue": "cables.csv", "conductor": "Twice"}, r"'Twice' is in rows 4 and 5"),
        (
            {"catalogue": "cables.csv", "conductor": "BAD"},
            r"diameter in row 6 is -29\.56; must be greater than 0",
        ),
        (
            {"catalogue": "towers.csv"},
            r"towers\.csv: not a cable catalogue of mechaphlowers, as it has no column name",
        ),
        ({"stringing_parameter": 2000.0}, r"stringing_parameter and stringing_percent are both"),
        ({"section": "mech.csv"}, r"sagging_parameter of mech\.csv and stringing_percent are both"),
        ({"stringing_percent": None}, r"neither of stringing_tension \[N\] and stringing_percent"),
        (
            {"section": "mech.csv", "stringing_percent": None, "stringing_temperature": 10.0},
            r"stringing_temperature and sagging_temperature of mech\.csv are both given",
        ),
        ({"subconductors": 2}, r"subconductors = 2 need spacing"),
        ({"section": "none.csv"}, r"none\.csv: .*no such file"),
        ({"stringing_percent": 200.0}, r"stringing_percent = 200\.0: must be .*less than 100"),
    ],
)
def test_bad_options_are_refused(folder, options, message):
    with pytest.raises(gf.SceneError, match=message):
        made(folder, **options)


def test_too_few_towers(folder):
    (folder / "towers.csv").write_text("tower,span\nA,\n", encoding="utf-8")
    with pytest.raises(gf.SceneError, match="has 1 tower; a section needs at least two"):
        read_towers(Path(folder / "towers.csv"), 9.81)


def test_insulators_for_all_strings(folder):
    (folder / "towers.csv").write_text("tower,span\nA,300\nB,350\nC,\n", encoding="utf-8")
    line = made(folder, insulator_length=2.4, insulator_weight=600.0)
    assert (line.section.suspensions[0].length, line.section.suspensions[0].weight) == (2.4, 600.0)
    assert "level: no attachment heights given" in line.sources["section.spans"]
    assert math.isclose(line.section.spans[1].height_difference, 0.0)


def test_without_coefficients_a_section_in_wind_has_the_assumed_curve(folder):
    line = made(folder, ice_thickness=0.006, wind_speed=4.0)
    assert line.aerodynamics.kind == "assumed"
    assert "ASSUMED, not measured" in line.sources["aerodynamics"]
    assert any("ASSUMED" in warning for warning in line.warnings)
