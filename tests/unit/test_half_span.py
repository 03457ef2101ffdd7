"""A symmetric span computed up to mid-span moves as the whole span does, and shows what it is not asked to hide.

Both computations solve the same equations with the same mesh, each step to the Newton tolerance.
"""

import ctypes as c

import numpy as np
import pytest
from typer.testing import CliRunner

import gallop_fmu as gf
import modal
from gallop_fmu.channels import NODE_INDEX
from gallop_fmu.cli import app
from gallop_fmu.energy import MOTION_CHANNELS, energy_balance
from gallop_fmu.engine import Model
from gallop_fmu.fmu.export import ExportError
from gallop_fmu.library import kernel
from gallop_fmu.loads import Load
from gallop_fmu.outcome import Outcome
from gallop_fmu.structures import CLoad, CReport, Packed

GALLOPING = {
    "numerics.elements": 20,
    "numerics.time_step": 0.02,
    "numerics.newton_tolerance": 1e-14,
    "initial.seed_vertical": 0.3,
    "initial.seed_horizontal": 0.1,
}
CALM = {"wind.speed": 0.0, "initial.seed_horizontal": 0.0, "ice.first_moment_x2": 0.0, "ice.first_moment_x3": 0.0}
DAMPED = {"low_ratio": 0.01, "low_frequency": 0.5, "high_ratio": 0.02, "high_frequency": 1.0}  # else axial modes ring
PULSE = {"kind": "pulse", "peak": 1.0, "rise": 1.0, "fall_start": 1.0, "fall": 0.5}


def example3(*changes):
    values = dict(GALLOPING)
    for change in changes:
        values |= change
    return gf.load_scene("example3").with_values(values)


def example1(**load):
    scene = gf.load_scene("example1").with_values(
        {
            "numerics.newton_tolerance": 1e-14,
            "damping.translation": DAMPED,
            "damping.twist": DAMPED,
            "numerics.time_step": 0.01,
        }
    )
    return scene.model_copy(update={"loads": (Load.model_validate(load | {"law": PULSE}),)})


def halved(scene):
    return scene.with_values({"numerics.mesh": "half_span"})


CASES = {
    "ice that turns, wind at once": example3({"ice.first_moment_x3": 1e-3}),
    "mean wind in equilibrium": example3({"initial.wind": "mean_wind_equilibrium"}),
    "from the sag, 26 elements": example3({"span.horizontal_tension": None, "numerics.elements": 26}),
    "four elements": example3({"numerics.elements": 4}),
    "springs": gf.load_scene("example2").with_values(GALLOPING),
    "in the plane": example3(CALM),
    "Gauss": example3({"numerics.integrator": "gauss6"}),
    "generalised alpha": example3({"numerics.integrator": "generalised_alpha"}),
    "slack": example3(
        {"conductor.slack": "tension_only", "initial.seed_vertical": 2.2, "aerodynamics.outside": "hold"}
    ),
    "a load at mid-span": example1(position=0.5, force=(0.0, 30.0, 20.0), torque=5.0),
    "an odd number of loads": example1(evenly_spaced=39, force=(0.0, 10.0, 20.0), torque=1.0),
    "an even number of loads": example1(evenly_spaced=38, force=(0.0, 10.0, 20.0), torque=1.0),
}


@pytest.mark.parametrize("name", CASES)
def test_half_a_span_moves_as_the_whole(name):
    """Relative to the largest value of the same unit, at all nodes and all times."""
    whole, half = (
        gf.simulate(scene, 5.0, record_nodes="all", channels=(*MOTION_CHANNELS[:8], "tension")).dataset
        for scene in (CASES[name], halved(CASES[name]))
    )
    assert np.array_equal(half.x1, whole.x1)
    assert half.attrs["lowest_tension"] == pytest.approx(whole.attrs["lowest_tension"], rel=1e-12)  # observed 2e-14
    largest, difference = {}, {}
    for channel, values in whole.drop_vars(["newton_iterations", "substeps"]).items():
        unit = values.attrs["units"]
        largest[unit] = max(largest.get(unit, 0.0), np.abs(values).max().item())
        difference[unit] = max(difference.get(unit, 0.0), np.abs(half[channel] - values).max().item())
    assert largest["m"] > 0.01
    for unit, value in difference.items():
        bound = 1e-11 if unit.endswith("/s") else 1e-12  # observed 5.5e-13 and 1.3e-13
        assert value <= bound * largest[unit], unit


def test_under_a_tolerance_the_steps_differ_and_the_motion_is_within_it():
    """Sizes of errors are means over the nodes computed, which are others."""
    tolerance = 1e-6
    scene = example3({"numerics.tolerance": tolerance})
    whole, half = (gf.simulate(each, 5.0) for each in (scene, halved(scene)))
    for channel in ("u2", "u3", "theta"):
        difference = np.abs(half.dataset[channel] - whole.dataset[channel]).max()
        assert difference <= 0.3 * tolerance * np.abs(whole.dataset[channel]).max()  # observed 0.11 of the tolerance


def test_static_equilibrium():
    scene = example3({"loads": [{"position": 0.5, "force": [0.0, -200.0, 30.0]}], "wind.speed": 20.0})
    forces = slice(1, 7)
    whole, half = (Model(each, inputs=False).rest() for each in (scene, halved(scene)))
    for node in range(41):
        one, other = half.observe_node(node), whole.observe_node(node)
        assert one[:4] == pytest.approx(other[:4], rel=1e-12, abs=1e-14)
        assert one[NODE_INDEX["tension"]] == pytest.approx(other[NODE_INDEX["tension"]], rel=1e-12)
    assert half.observe_span()[forces] == pytest.approx(whole.observe_span()[forces], rel=1e-12)  # observed 4e-15


ANTISYMMETRIC = example3(
    {"span.sag": 3.2, "span.horizontal_tension": None, "wind.speed": 5.0, "initial.seed_vertical": 0.01}
)
"""Two loops gallop (0.62 Hz, -0.5 % damping in this wind), the symmetric modes do not (from 0.81 Hz, +0.2 %)."""


def test_it_hides_galloping_in_two_loops():
    push = {"position": 0.25, "force": [0.0, 1.0, 0.0], "law": PULSE}
    options = {"record_nodes": [10, 20, 30], "record_every": 5}
    whole = gf.simulate(ANTISYMMETRIC.with_values({"loads": [push]}), 600.0, **options).dataset
    half = gf.simulate(halved(ANTISYMMETRIC), 600.0, **options).dataset
    left, middle, right = (whole.u2.values[-500:, node] - whole.u2.values[-500:, node].mean() for node in range(3))
    assert np.ptp(left) / 2.0 == pytest.approx(0.262, abs=0.002)
    assert np.ptp(middle) < 0.01 * np.ptp(left)  # observed 0.0044
    assert np.corrcoef(left, right)[0, 1] < -0.9  # observed -0.954
    assert np.ptp(half.u2.values[-500:], axis=0).max() < 2e-4  # observed 1.3e-4 m, dying out


def test_the_toolkit_looks_at_the_whole_span():
    modes = modal.natural_modes(halved(ANTISYMMETRIC), count=6, wind="mean")
    unstable = [mode for mode in modes if mode.damping_ratio < 0.0]
    assert [(mode.family, mode.loops, mode.symmetric) for mode in unstable] == [("vertical", 2, False)]
    assert unstable[0].damping_ratio == pytest.approx(-0.0046, abs=2e-4)


def test_a_model_with_inputs_is_whole():
    """A host may move one tower alone."""
    scene = halved(example3())
    whole, half = Model(scene), Model(scene, inputs=False)
    assert half.state_size < 0.6 * whole.state_size
    assert whole.residual().shape == (half.nodes, 4)
    for call in (half.residual, half.tangent):
        with pytest.raises(ValueError, match="inputs=True"):
            call()


@pytest.mark.parametrize("runtime", ["native", "python"])
def test_an_fmu_is_refused(runtime, tmp_path):
    with pytest.raises(ExportError, match=r'half_span": an FMU needs the whole span.*set numerics.mesh'):
        gf.export_fmu(halved(example3()), tmp_path / "half.fmu", runtime)
    assert not list(tmp_path.iterdir())


def test_provenance_says_what_is_hidden():
    scene = example3()
    assert gf.simulate(scene, 0.1).dataset.attrs["hidden"] == ""
    assert gf.simulate(halved(scene), 0.1).dataset.attrs["hidden"] == "antisymmetric motion"


def test_the_command_line_says_it_too():
    words = ["run", "example3", "--until", "1", "--set", "numerics.elements=6", "--set", "numerics.mesh=half_span"]
    shown = CliRunner().invoke(app, words)
    assert shown.exit_code == 0
    assert "hidden, since numerics.mesh asks for half of the span: antisymmetric motion" in shown.stdout


def test_energy_balance():
    """That of a result, which holds all nodes; the towers' work and the springs' energy count twice as well."""
    scene = gf.load_scene("example2").with_values(GALLOPING | {"run.record_every": 1})
    whole, half = (
        energy_balance(gf.simulate(each, 2.0, record_nodes="all", channels=MOTION_CHANNELS))
        for each in (scene, halved(scene))
    )
    assert half.kinetic.max() > 1.0
    assert half.worst == pytest.approx(whole.worst, rel=1e-9)  # observed 1e-14


SPRINGS = {"kind": "springs", "stiffness_x1": 1e5, "stiffness_x3": 1e3}
MOVING = {"kind": "rigid", "motion": {"x2": {"kind": "harmonic", "amplitude": 0.1, "frequency_hz": 0.4}}}
UNEVEN = {
    "odd mesh": ({"numerics.elements": 15}, "numerics.elements = 15: .*choose 16, or set"),
    "two elements": ({"numerics.elements": 2}, "numerics.elements = 2: .*choose 4, or set"),
    "inclined": ({"span.height_difference": 1.0}, "span.height_difference = 1.0 m: .*level span.*change it, or set"),
    "one end on springs": ({"supports.right": SPRINGS}, "supports.left and supports.right differ: .*or set"),
    "one tower moves": ({"supports.right": MOVING}, "supports.right.motion is given: .*remove it, or set"),
    "both towers move": ({"supports.left": MOVING, "supports.right": MOVING}, "supports.left.motion is given: "),
    "load aside": (
        {"loads": [{"position": 0.25, "force": [0.0, 1.0, 0.0]}]},
        "loads.0.position = 0.25: .*position = 0.5, or evenly_spaced; change it, or set",
    ),
    "load along the span": (
        {"loads": [{"position": 0.5, "force": [0.0, 1.0, 0.0]}, {"evenly_spaced": 3, "force": [1.0, 0.0, 0.0]}]},
        r"loads.1.force = \[1.0, 0.0, 0.0\] N: .*no force along the span.*make it 0, or set",
    ),
}


@pytest.mark.parametrize("name", UNEVEN)
def test_what_is_not_symmetric_is_refused(name):
    change, message = UNEVEN[name]
    scene = example3(change)
    with pytest.raises(gf.SceneError, match=message + ".*"):
        halved(scene)


def loaded(scene, **numbers):
    load = (CLoad * 1)()
    for name, value in numbers.items():
        setattr(load[0], name, value)
    scene.load, scene.load_count = c.cast(load, c.POINTER(CLoad)), 1
    return load


def unlike(scene):
    scene.support[1].stiffness_x1 = 1.0


def moving(scene):
    scene.support[0].motion[1].initial = 0.1


@pytest.mark.parametrize(
    ("change", "field"),
    [
        (lambda scene: setattr(scene, "laws_only", 0), "half span, which inputs could move unevenly"),
        (lambda scene: setattr(scene, "elements", 15), "number of elements, not even or below 4, for half a span"),
        (lambda scene: setattr(scene, "elements", 2), "number of elements, not even or below 4, for half a span"),
        (lambda scene: setattr(scene, "height_difference", 1.0), "height difference on half a span"),
        (unlike, "right support on half a span, unlike the left"),
        (moving, "motion of a support on half a span"),
        (lambda scene: loaded(scene, position=0.3), "position of a load on half a span"),
        (lambda scene: loaded(scene, position=0.5, force=(1.0, 0.0, 0.0)), "force of a load along half a span"),
        (lambda scene: loaded(scene, position=0.5), ""),
    ],
)
def test_the_kernel_refuses_by_itself(change, field):
    packed, report, handle = Packed(example3()), CReport(), c.c_void_p()
    packed.scene.half_span = packed.scene.laws_only = 1
    kept = change(packed.scene)
    code = kernel.gallop_model_create(c.byref(packed.scene), c.byref(handle), c.byref(report))
    assert Outcome.from_code(code) is (Outcome.INVALID_SCENE if field else Outcome.COMPLETED), kept
    assert (report.field or b"").decode() == field
    if handle.value is not None:
        kernel.gallop_model_free(handle)
