"""Packaged scenes, reading and writing, changing values, and the units of everything."""

import tomllib
import unicodedata

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.input.scene_files import load_scene, packaged_scenes
from gallop_fmu.scene.dotted_paths import has_path, leaves
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.supports import RigidSupport
from gallop_fmu.scene.time_functions import Constant, Harmonic, Pulse, Ramp, TimeTable

PACKAGED = ["example1", "example2", "example3", "zebra"]


def test_packaged_scenes_are_listed_with_titles():
    assert list(packaged_scenes()) == PACKAGED
    assert all(packaged_scenes().values())


@pytest.mark.parametrize("name", PACKAGED)
def test_packaged_scene_survives_saving_and_loading(name, tmp_path):
    scene = load_scene(name)
    scene.save(tmp_path / "copy.toml")
    assert load_scene(tmp_path / "copy.toml") == scene


@pytest.mark.parametrize("name", PACKAGED)
def test_every_value_of_a_packaged_scene_has_a_source(name):
    scene = load_scene(name)
    given_values = [leaf.path for leaf in leaves(scene) if was_given(scene, leaf.path)]
    texts = ("title", "description", "notes", "sources")
    bare = [
        path
        for path in given_values
        if path not in texts
        and not any(path == s or path.startswith(s + ".") for s in scene.sources)
    ]
    assert len(given_values) > 20
    assert bare == []


@pytest.mark.parametrize("name", PACKAGED)
def test_a_scene_has_the_paths_of_its_leaves_and_of_the_sections_above_them(name):
    scene = load_scene(name)
    paths = {leaf.path for leaf in leaves(scene)}
    for path in list(paths):
        while "." in path:
            path = path.rpartition(".")[0]
            paths.add(path)
    assert all(has_path(scene, path) for path in paths)
    others = {f"{path}{end}" for path in paths for end in ("x", ".x", ".0", ".00", ".9", ".")}
    assert not [path for path in others - paths if has_path(scene, path)]


def was_given(scene, path):
    """Check that the scene file itself sets the value."""
    node = scene
    for key in path.split("."):
        if isinstance(node, tuple):
            node = node[int(key)]
            continue
        if key not in node.model_fields_set:
            return False
        node = getattr(node, key)
    return True


@pytest.mark.parametrize("name", ["example1", "example2", "example3"])
def test_reconstructions_of_lost_figures_are_called_so(name):
    scene = load_scene(name)
    assert "RECONSTRUCTION" in scene.description
    assert any("RECONSTRUCTION" in text for text in scene.sources.values())


@pytest.mark.parametrize(
    ("name", "state"),
    [
        ("example1", "from_sag"),
        ("example2", "held"),
        ("example3", "held"),
        ("zebra", "from_tension"),
    ],
)
def test_initial_state_follows_from_the_given_values(name, state):
    assert load_scene(name).span.initial_state == state


def test_example1_section_is_the_solid_round_one_of_the_paper():
    conductor = load_scene("example1").conductor
    area, polar = np.pi * 0.02763**2 / 4, np.pi * 0.02763**4 / 32
    # Observed: 2.2e-16, the order of multiplication.
    assert conductor.axial_stiffness == pytest.approx(69e9 * area, rel=5e-16)
    assert conductor.torsional_stiffness == pytest.approx(69e9 / 2.6 * polar, rel=5e-16)
    assert conductor.mass_per_length == pytest.approx(2519 * area, rel=5e-16)
    assert conductor.torsional_inertia == pytest.approx(2519 * polar, rel=5e-16)


def test_every_number_has_a_unit_and_every_field_a_meaning():
    for name in PACKAGED:
        for leaf in leaves(load_scene(name)):
            assert leaf.meaning, leaf.path
            is_number = isinstance(leaf.value, (int, float)) and not isinstance(leaf.value, bool)
            if is_number or (isinstance(leaf.value, tuple) and leaf.value):
                assert leaf.unit, leaf.path


def test_numbers_have_value_unit_and_meaning_in_order_of_declaration():
    numbers = load_scene("example2").numbers()
    assert numbers["wind.speed"][:2] == (4.1, "m/s")
    assert numbers["numerics.elements"] == (15, "1", "number of three-node elements")
    assert numbers["supports.left.stiffness_x3"][0] == 1361.6
    assert "span.height_difference" in numbers
    assert "aerodynamics.lift" not in numbers
    assert "aerodynamics.reference_radius" not in numbers
    assert list(numbers)[:3] == ["span.length", "span.height_difference", "span.sag"]


def test_a_law_has_the_unit_of_its_target(minimal):
    minimal["loads"] = [{"force": [0, 1, 0], "position": 0.5}]
    minimal["supports"] = {
        "left": {"kind": "rigid", "motion": {"x3": {"kind": "constant", "value": 0.1}}}
    }
    scene = Scene.from_dict(minimal)
    assert scene.unit_of("loads.0.law.value") == "1"
    assert scene.unit_of("supports.left.motion.x3.value") == "m"
    assert scene.unit_of("wind.history") == "m/s"
    assert scene.unit_of("loads.0.force") == "N"
    assert scene.unit_of("title") == ""
    with pytest.raises(
        SceneError, match=r"wind\.sped: unknown key; the closest valid one is wind\.speed"
    ):
        scene.unit_of("wind.sped")


def test_with_values_gives_a_changed_copy_and_honest_sources():
    scene = load_scene("example3")
    faster = scene.with_values(
        {"wind.speed": np.float64(6.0), "supports.left": RigidSupport(), "numerics.elements": 20}
    )
    assert (faster.wind.speed, faster.numerics.elements, scene.wind.speed) == (6.0, 20, 5.5)
    assert faster.sources["wind.speed"] == "set by the user"
    assert faster.sources["conductor"] == scene.sources["conductor"]
    assert "supports.left" not in faster.sources  # the same support as before
    assert scene.with_values({}) == scene


def test_with_values_removes_optional_values_and_reaches_into_lists():
    scene = load_scene("example2").with_values({"span.sag": None})
    assert scene.span.initial_state == "from_tension"
    twice = load_scene("example1").with_values({"loads.0.torque": 2, "loads.0.force.1": 0.5})
    assert twice.loads[0].torque == 2.0
    assert twice.loads[0].force == (0.0, 0.5, 2.0)
    gust = load_scene("example3").with_values(
        {"wind.speed": None, "wind.history": Constant(value=3.0)}
    )
    assert gust.wind.mean_speed == 3.0


def test_a_section_can_be_added_by_its_values():
    pair = {"low_ratio": 0.01, "low_frequency": 1.0, "high_ratio": 0.01, "high_frequency": 2.0}
    scene = load_scene("example1").with_values(
        {f"damping.twist.{key}": value for key, value in pair.items()}
    )
    assert scene.damping.twist.high_frequency == 2.0


def test_no_wind_means_calm(minimal):
    wind = Scene.from_dict(minimal).wind
    assert (wind.speed, wind.mean_speed, wind.can_blow) == (0.0, 0.0, False)


def test_unquoted_source_keys_are_joined(minimal):
    minimal["sources"] = tomllib.loads(
        'span.sag = "survey"\n"span.length" = "map"\nconductor = "catalogue"'
    )
    assert Scene.from_dict(minimal).sources == {
        "span.sag": "survey",
        "span.length": "map",
        "conductor": "catalogue",
    }


def test_coefficient_and_wind_files_are_read_into_the_scene(tmp_path, minimal):
    (tmp_path / "ice.csv").write_text(
        "# tunnel\nangle_deg,lift,drag,moment\n0,0.5,1,0\n\n90,0.25,2,0.1\n", "utf-8-sig"
    )
    (tmp_path / "wind.csv").write_text("time,value\n0,4.0\n10,8.0\n")
    minimal["aerodynamics"] = {"kind": "table", "file": "ice.csv"}
    minimal["wind"] = {"history": {"kind": "table", "file": "wind.csv"}}
    scene = Scene.from_dict(minimal, folder=tmp_path)
    assert scene.aerodynamics.angle_deg == (0.0, 90.0)
    assert scene.aerodynamics.drag == (1.0, 2.0)
    assert scene.wind.mean_speed == 6.0
    assert "csv" not in scene.to_toml()
    assert Scene.from_dict(tomllib.loads(scene.to_toml())) == scene


TIMES = np.array([-0.5, 0.0, 0.5, 1.0, 1.25, 5.0])


@pytest.mark.parametrize(
    ("law", "values", "mean", "extremes"),
    [
        (Constant(value=2.0), [2, 2, 2, 2, 2, 2], 2, (2, 2)),
        (Ramp(initial=1, final=3, duration=1), [1, 1, 2, 3, 3, 3], 3, (1, 3)),
        (Ramp(initial=1, final=3, duration=0), [1, 3, 3, 3, 3, 3], 3, (1, 3)),
        (Pulse(peak=2, rise=1, fall_start=1, fall=0.5), [0, 0, 1, 2, 1, 0], 0, (0, 2)),
        (Harmonic(mean=1, amplitude=2, frequency_hz=0.5), [1, 1, 3, 1, 1 - 2**0.5, 1], 1, (-1, 3)),
        (TimeTable(time=[0, 1, 2], value=[0, 4, 0]), [0, 0, 2, 4, 3, 0], 2, (0, 4)),
    ],
)
def test_law_values(law, values, mean, extremes):
    # Observed: 1.3e-15, the sine of five half turns.
    np.testing.assert_allclose(law.at(TIMES), values, rtol=0, atol=3e-15)
    assert law.at(0.5).shape == ()
    assert law.mean_value == mean
    assert law.extremes == extremes


def test_smooth_step_is_the_polynomial():
    x = 0.3
    value = Ramp(initial=0, final=1, start=2.0, duration=4.0).at(2.0 + 4.0 * x)
    # Observed: 2.8e-17.
    assert value == pytest.approx(10 * x**3 - 15 * x**4 + 6 * x**5, abs=2e-16)


def numbers(low, high):
    return st.floats(low, high, allow_nan=False)


positive = numbers(1e-300, 1e6)
text = st.text(st.characters(codec="utf-8", exclude_categories=("Cc", "Cn")), max_size=20).map(
    lambda words: unicodedata.normalize("NFC", words)
)
laws = st.one_of(
    st.fixed_dictionaries({"kind": st.just("constant"), "value": numbers(0, 150)}),
    st.fixed_dictionaries(
        {
            "kind": st.just("ramp"),
            "initial": numbers(0, 150),
            "final": numbers(0, 150),
            "duration": numbers(0, 9),
        }
    ),
    st.lists(numbers(0, 150), min_size=2, max_size=6).map(
        lambda values: {
            "kind": "table",
            "time": [0.1 * i for i in range(len(values))],
            "value": values,
        }
    ),
)
motions = st.fixed_dictionaries({}, optional={axis: laws for axis in ("x1", "x2", "x3")})
supports = st.one_of(
    st.fixed_dictionaries({"kind": st.just("rigid")}, optional={"motion": motions}),
    st.fixed_dictionaries(
        {"kind": st.just("springs"), "stiffness_x1": positive, "stiffness_x3": positive}
    ),
    st.fixed_dictionaries(
        {
            "kind": st.just("adjacent_span"),
            "adjacent_span": numbers(1e-300, 1e3),
            "adjacent_tension": numbers(1e12, 1e15),  # bears every mass drawn below
            **{key: positive for key in ("insulator_length", "insulator_weight")},
        }
    ),
)
coefficients = st.lists(numbers(-9, 9), min_size=1, max_size=4)
curves = st.one_of(
    st.fixed_dictionaries(
        {
            "kind": st.just("polynomial"),
            "valid_from_deg": st.just(-180),
            "valid_to_deg": st.just(180),
        }
        | {key: coefficients for key in ("lift", "drag", "moment")}
    ),
    st.lists(st.tuples(numbers(-9, 9), numbers(0, 9), numbers(-9, 9)), min_size=2, max_size=5).map(
        lambda rows: (
            {"kind": "table", "outside": "hold", "angle_deg": [7.3 * i for i in range(len(rows))]}
            | {key: [row[c] for row in rows] for c, key in enumerate(("lift", "drag", "moment"))}
        )
    ),
)
loads = st.fixed_dictionaries(
    {"force": st.tuples(*[numbers(-1e6, 1e6)] * 3), "position": numbers(0, 1)},
    optional={"torque": positive, "law": laws},
)
winds = st.one_of(
    st.fixed_dictionaries({"history": laws}),
    st.fixed_dictionaries({}, optional={"speed": numbers(0, 150)}),
)
spans = st.fixed_dictionaries(
    {"length": numbers(10, 1e4), "sag": numbers(1e-6, 50)},
    optional={"height_difference": numbers(-9, 9)},
)
scenes = st.fixed_dictionaries(
    {
        "title": text,
        "description": text,
        "span": spans,
        "conductor": st.fixed_dictionaries(
            {"diameter": numbers(1e-3, 1)}
            | {key: positive for key in ("axial_stiffness", "torsional_stiffness")}
            | {key: numbers(1e-3, 1e3) for key in ("mass_per_length", "torsional_inertia")}
        ),
        "ice": st.fixed_dictionaries(
            {"first_moment_x2": numbers(-1e-4, 1e-4), "attack_angle_deg": numbers(-360, 360)}
        ),
        "wind": winds,
        "aerodynamics": curves,
        "supports": st.fixed_dictionaries({"left": supports, "right": supports}),
        "loads": st.lists(loads, max_size=2),
        "sources": st.fixed_dictionaries(
            {}, optional={"span": text, "span.length": text, "loads": text}
        ),
    }
)


@settings(max_examples=60)
@given(scenes)
def test_any_valid_scene_survives_toml_bit_for_bit(data):
    scene = Scene.from_dict(data)
    again = Scene.from_dict(tomllib.loads(scene.to_toml()))
    assert again == scene
    assert bits(again) == bits(scene)


def bits(scene):
    """All values, with floats as exact text, so that 0.0 and -0.0 differ."""
    return [(leaf.path, exact(leaf.value)) for leaf in leaves(scene)]


def exact(value):
    if isinstance(value, tuple):
        return tuple(map(exact, value))
    return value.hex() if isinstance(value, float) else value
