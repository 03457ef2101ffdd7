"""FMUs of scenes with oblique, sheared and gusty wind."""

import fmpy
import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.fmu.cosim import Cosim, CosimError
from gallop_fmu.fmu.export import ExportError
from gallop_fmu.fmu.model_bin import model_bin
from gallop_fmu.fmu.variables import fmu_variables
from support.line_scenes import section
from support.windy_spans import LOGARITHMIC, TURBULENCE, windy_span

GUSTY = windy_span(
    {
        "numerics.time_step": 0.015625,
        "wind.speed": 7.0,
        "wind.direction_deg": 35.0,
        "wind.turbulence": TURBULENCE,
        "wind.profile": LOGARITHMIC,
    }
)
STEPS, STEP = 64, 0.125
"""Exact in binary, so that host and simulation read the gusts at the same bits of time."""


def run(path, outputs, start_values=None, stop=STEPS * STEP):
    return fmpy.simulate_fmu(
        str(path),
        stop_time=stop,
        output_interval=STEP,
        start_values=start_values or {},
        output=outputs,
    )


@pytest.fixture(scope="module")
def gusty(tmp_path_factory):
    path = tmp_path_factory.mktemp("wind") / "gusty.fmu"
    gf.export_fmu(GUSTY, path)
    return path


def test_the_fmu_is_the_simulation(gusty):
    """Gusts, which repeat after 4 s, profile and direction lie in the model file."""
    records = run(gusty, ["midspan.x2", "midspan.x3", "angle_of_attack", "support.left.f3"])
    result = gf.simulate(GUSTY, stop_time=STEPS * STEP, record_every=8)
    middle = result.midspan()
    assert np.array_equal(records["midspan.x2"], middle.u2.values)
    assert np.array_equal(records["midspan.x3"], middle.u3.values)
    assert np.array_equal(records["angle_of_attack"][1:], middle.angle_of_attack.values[1:])
    assert np.array_equal(records["support.left.f3"][1:], result.dataset.left_f3.values[1:])
    assert np.abs(middle.u3.values).max() > 1e-3


def started(scene, **values):
    """A running instance with other start values, and the references of its variables."""
    instance = Cosim(model_bin(scene, "wind", "0"), "wind")
    reference = {v.name: v.reference for v in fmu_variables(scene)}
    instance.set("real", [reference[name] for name in values], list(values.values()))
    instance.enter_initialization()
    instance.exit_initialization()
    return instance, reference


def test_the_host_turns_the_wind():
    """From 5 to -60 degrees before the start; then the wind turns by 180 degrees."""
    scene = GUSTY.with_values({"wind.turbulence": None, "wind.direction_deg": -60.0})
    exported = scene.with_values({"wind.direction_deg": 5.0})
    instance, reference = started(exported, wind_direction=np.radians(-60.0))
    for step in range(16):
        instance.step(step * STEP, STEP)
    result = gf.simulate(scene, stop_time=2.0, record_every=8)
    assert instance.get("real", [reference["midspan.x3"]]) == [result.midspan().u3.values[-1]]
    instance.set("real", [reference["wind_direction"]], [np.radians(120.0)])
    for step in range(16, 48):
        instance.step(step * STEP, STEP)
    assert instance.get("real", [reference["midspan.x3"]])[0] < 0.0


def test_references_of_other_variables_stay():
    plain = gf.load_scene("example3")
    before = {v.name: v.reference for v in fmu_variables(plain) if v.causality != "parameter"}
    oblique = plain.with_values({"wind.direction_deg": 20.0})
    after = fmu_variables(oblique)
    assert before.items() <= {v.name: v.reference for v in after}.items()
    [direction] = [v for v in after if v.name == "wind_direction"]
    assert direction.causality == "input"
    assert direction.start == np.radians(20.0)
    assert "wind_direction" not in before
    profile = {v.name for v in fmu_variables(GUSTY) if v.name.startswith("wind.profile")}
    assert profile == {"wind.profile.roughness_length", "wind.profile.reference_height"}


def test_a_parameter_of_the_profile_makes_another_wind(gusty):
    rough = run(gusty, ["midspan.x3"], {"wind.profile.roughness_length": 1.0}, stop=2.0)
    scene = GUSTY.with_values({"wind.profile.roughness_length": 1.0})
    result = gf.simulate(scene, stop_time=2.0, record_every=8)
    assert np.array_equal(rough["midspan.x3"], result.midspan().u3.values)


def test_a_line_has_one_direction_and_the_speeds_of_its_spans(tmp_path):
    scene = section(
        15000.0,
        (125.0, 100.0),
        15.0,
        2.0e7,
        elements=4,
        aerodynamics=windy_span().aerodynamics.model_dump(),
        wind={"speed": 5.0, "direction_deg": -25.0, "turbulence": TURBULENCE},
        ice={"attack_angle_deg": 170.0},
    ).with_values({"section.spans.1.wind": {"speed": 8.0}, "numerics.time_step": 0.015625})
    with pytest.raises(ExportError, match=r"span 2 has its own wind, .* use wind = .span."):
        gf.export_fmu(scene, tmp_path / "line.fmu")
    gf.export_fmu(scene, tmp_path / "line.fmu", wind="span")
    names = ["span[1].midspan.x3", "span[2].midspan.x3"]
    records = run(tmp_path / "line.fmu", names, stop=3.0)
    result = gf.simulate(scene, stop_time=3.0, record_every=8)
    for number, name in enumerate(names, start=1):
        found = result.bundle(number).u3.sel(time=result.dataset.time)
        assert np.array_equal(records[name], np.asarray(found).ravel())


def test_wind_from_the_other_side_is_an_input():
    scene = gf.load_scene("example3").with_values(
        {
            "aerodynamics.outside": "hold",
            "wind.speed": -4.0,
            "numerics.elements": 6,
            "numerics.time_step": 0.015625,
        }
    )
    instance, reference = started(scene)
    wind = [reference["wind_speed"]]
    assert instance.get("real", wind) == [-4.0]
    with pytest.raises(CosimError, match=r"wind_speed = -151 is refused: it must be at least -150"):
        instance.set("real", wind, [-151.0])
    for step in range(16):
        instance.step(step * STEP, STEP)
    result = gf.simulate(scene, stop_time=2.0, record_every=8)
    assert instance.get("real", [reference["midspan.x3"]]) == [result.midspan().u3.values[-1]]
    assert result.midspan().u3.values[-1] < 0.0
