"""Parameters set before the end of initialisation: bit for bit the FMU of the changed scene."""

import numpy as np
import pytest

import gallop_fmu as gf
from gallop_fmu.fmu.enumerations import ENUMERATIONS
from gallop_fmu.fmu.variables import Origin, fmu_variables

NODE = {
    f"midspan.{name}": channel
    for name, channel in (("x1", "u1"), ("x2", "u2"), ("x3", "u3"), ("theta", "theta"))
}
NODE |= {
    "midspan.omega": "omega",
    "midspan.tension": "tension",
    "angle_of_attack": "angle_of_attack",
}
SPAN = {
    f"support.{end}.f{axis}": f"{end}_f{axis}" for end in ("left", "right") for axis in (1, 2, 3)
}


def rich_scene():
    """All kinds of numbers: springs, adjacent span, ice, load laws, dampings, a seed."""
    data = (
        gf.load_scene("example3")
        .with_values({"numerics.elements": 4, "numerics.time_step": 0.02})
        .model_dump()
    )
    data["span"] |= {"sag": None, "height_difference": 3.0}
    data["ice"] |= {"mass_per_length": 0.1, "torsional_inertia": 2e-5}
    data["aerodynamics"]["reference_radius"] = 0.012
    data["supports"] = {
        "left": {"kind": "springs", "stiffness_x1": 8e4, "stiffness_x3": 1500.0},
        "right": {"kind": "adjacent_span", "adjacent_span": 130.0, "adjacent_tension": 15000.0,
        "insulator_length": 2.0,
                  "insulator_weight": 200.0},
    }  # fmt: skip
    laws = (
        {"kind": "ramp", "initial": 0.1, "final": 1.0, "start": 0.1, "duration": 0.5},
        {
            "kind": "pulse",
            "initial": 0.0,
            "peak": 1.0,
            "start": 0.1,
            "rise": 0.2,
            "fall_start": 0.5,
            "fall": 0.3,
        },
        {
            "kind": "harmonic",
            "mean": 0.5,
            "amplitude": 0.4,
            "frequency_hz": 1.0,
            "phase_deg": 15.0,
            "start": 0.1,
        },
        {"kind": "constant", "value": 0.7},
    )
    data["loads"] = [
        {
            "force": (0.0, 5.0, 3.0),
            "torque": 0.5,
            "law": law,
            **({"evenly_spaced": 3} if k else {"position": 0.4}),
        }
        for k, law in enumerate(laws)
    ]
    data["initial"] |= {"seed_twist": 1e-3}
    data["sources"] = {}
    return gf.Scene.from_dict(data)


SCENES = {
    "prescribed": gf.load_scene("example3").with_values({"numerics.elements": 4}),
    "rich": rich_scene(),
}
CASES = [
    (kind, variable.name)
    for kind, scene in SCENES.items()
    for variable in fmu_variables(scene)
    if variable.origin is Origin.PARAMETER
    and (kind == "rich" or variable.key.startswith(("span", "supports")))
]


@pytest.fixture(scope="module")
def fmus(unpack):
    return {kind: unpack(scene) for kind, scene in SCENES.items()}


def changed_scene(scene, variable):
    """The scene with another value of a parameter; the names of integrators are the scene's."""
    value = changed(variable.start)
    if variable.enumeration:
        names = {item.value: item.name for item in ENUMERATIONS[variable.enumeration]}
        value = names[value]
    return scene.with_values({variable.key: value})


def changed(value):
    return value + 1 if isinstance(value, int) else value * 1.01 if value else 0.01


def run(instance, step, count):
    """Times are those of simulate(), multiples of the step: differences and sums are exact."""
    rows = {name: [] for name in (*NODE, *SPAN)}
    for k in range(count):
        assert instance.do_step(k * step, (k + 1) * step - k * step) == 0, instance.log
        for name, values in rows.items():
            values.append(instance[name])
    return rows


def simulated(scene, count):
    result = gf.simulate(scene, stop_time=count * scene.numerics.time_step, record_every=1)
    midspan, rows = result.midspan(), {}
    for name, channel in NODE.items():
        rows[name] = midspan[channel].values[1:]
    for name, channel in SPAN.items():
        rows[name] = result.dataset[channel].values[1:]
    return rows


@pytest.mark.parametrize(("kind", "name"), CASES)
def test_a_parameter_means_the_changed_scene(fmus, instance, kind, name):
    scene = SCENES[kind]
    variable = next(v for v in fmu_variables(scene) if v.name == name)
    value = changed(variable.start)
    other = changed_scene(scene, variable)
    count = round(1.0 / other.numerics.time_step)
    fmu = instance(fmus[kind])
    assert fmu[name] == variable.start
    fmu.start(**{name.replace(".", "__"): value})
    found, wanted = run(fmu, other.numerics.time_step, count), simulated(other, count)
    for output, values in wanted.items():
        assert np.array_equal(found[output], values), output  # observed: every bit, in all cases


@pytest.mark.parametrize("kind", SCENES)
def test_parameters_are_felt(fmus, kind):
    """Most parameters of the test above change the motion."""
    scene = SCENES[kind]
    plain = simulated(scene, 50)["midspan.x2"][-1]
    idle = []
    for variable in fmu_variables(scene):
        if variable.origin is Origin.PARAMETER and variable.key != "numerics.time_step":
            other = changed_scene(scene, variable)
            if simulated(other, 50)["midspan.x2"][-1] == plain:
                idle.append(variable.key)
    allowed = ("numerics.max", "numerics.newton", "aerodynamics.valid", "supports.")
    assert [key for key in idle if not key.startswith(allowed)] == []


def test_parameters_are_read_back_as_set_and_as_exported(fmus, instance):
    fmu = instance(fmus["rich"])
    for variable in fmu_variables(SCENES["rich"]):
        if variable.start is not None:
            assert fmu[variable.name] == variable.start, variable.name
    for degrees in (15.0, 29.3, 30.0, 122.7, 180.0, 254.0):
        fmu["aerodynamics.centre_deg"] = degrees
        assert fmu["aerodynamics.centre_deg"] == degrees


def test_reset_restores(fmus, instance):
    fmu = instance(fmus["rich"])
    before = {name: fmu[name] for name, v in fmu.fmu.variables.items() if v.causality != "output"}
    plain = run(fmu.start(), 0.02, 20)
    fmu.insist("Reset")
    fmu.start(span__length=120.0, wind_speed=9.0, numerics__elements=6, support__left__x1=0.02)
    assert run(fmu, 0.02, 20) != plain
    fmu.insist("Reset")
    assert {name: fmu[name] for name in before} == before
    assert run(fmu.start(), 0.02, 20) == plain


def test_a_wind_history_starts_the_input(unpack, instance):
    law = {"kind": "table", "time": [-1.0, 1.0], "value": [2.0, 6.0]}
    scene = SCENES["prescribed"].with_values({"wind.speed": None, "wind.history": law})
    fmu = instance(unpack(scene))
    declared = next(v.start for v in fmu_variables(scene) if v.name == "wind_speed")
    assert fmu["wind_speed"] == declared == 4.0


def test_parameters_that_make_no_span_are_refused_and_can_be_corrected(fmus, instance):
    fmu = instance(fmus["prescribed"])
    assert fmu.set_up() == 0
    fmu.insist("EnterInitializationMode")
    fmu["span.horizontal_tension"] = 30000.0  # the sag is prescribed, and belongs to half of it
    assert fmu.call("ExitInitializationMode") == 3
    assert "the parameters do not make a span" in fmu.log[-1]
    assert fmu["status"] != 0
    fmu["span.horizontal_tension"] = 15000.0
    fmu.insist("ExitInitializationMode")
    assert fmu["status"] == 0
    fmu.step(0.01)
