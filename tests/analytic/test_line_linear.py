"""The linear model of lines against their modes and small simulated motion."""

import control
import numpy as np
import pytest

import gallop_fmu as gf
import modal
from tests.support.line_scenes import section, zebra

WIND = 5.0
AT_REST = {
    f"initial.seed_{part}": 0.0 for part in ("vertical", "horizontal", "twist")
}  # only the input moves the line


def iced(**tables):
    """Two unequal spans with eccentric ice in wind."""
    source = gf.load_scene("example3").model_dump(mode="json", exclude_none=True)
    return section(
        19785.0,
        [200.0, 300.0],
        15.9,
        44.389e6,
        elements=8,
        torsion=(150.0, 1e-3),
        aerodynamics=source["aerodynamics"],
        ice=source["ice"],
        wind={"speed": WIND},
        initial={"wind": "mean_wind_equilibrium"},
        **tables,
    )


@pytest.fixture(scope="module")
def scene():
    return iced()


@pytest.fixture(scope="module")
def model(scene):
    return modal.linear_model(scene, 30)


def test_poles_are_the_eigenvalues_of_the_modes(scene, model):
    poles = model.poles()
    poles = sorted(poles[poles.imag > 0.0], key=abs)
    modes = modal.natural_modes(scene, 30, "mean")
    assert poles == pytest.approx([mode.eigenvalue for mode in modes], rel=1e-7)


def of_line(model, scene, signal, path, mean, size):
    """Relative root mean square difference to a simulated ramp of an input, of every output."""
    law = {"kind": "ramp", "initial": mean, "final": mean + size, "start": 0.5, "duration": 1.0}
    changes = AT_REST | {"numerics.time_step": 0.01, path: law}
    if path == "wind.history":
        changes["wind.speed"] = None
    result = gf.simulate(scene.with_values(changes), 10.0)
    time = result.dataset.time.values
    x = np.clip(time - 0.5, 0.0, 1.0)
    drive = size * x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
    linear = control.forced_response(
        model, time, [drive * (k == signal) for k in model.input_labels]
    )
    found = {}
    for label, row in zip(model.output_labels, np.asarray(linear.outputs), strict=True):
        place, name = label.split("]_")
        number = int(place.split("[")[1])
        if name.startswith("f"):
            force = result.dataset[f"tower_force_x{name[1]}"].isel(tower=number)
            history = np.ravel(force.values)
        elif "theta" in name and scene.bundle.subconductors > 1:
            continue  # a bundle's rotation is not in the midspan of one subconductor
        else:
            key = name.removeprefix("midspan_").replace("x", "u")
            count = scene.bundle.subconductors
            each = [result.midspan(number, 1, k + 1)[key].values for k in range(count)]
            history = np.mean(each, axis=0)
        moved = history - history[0]
        found[label] = np.sqrt(np.mean((row - moved) ** 2) / np.mean(moved**2))
    return found


def worst(found, *names):
    """Largest of the outputs whose name ends so."""
    return max(value for label, value in found.items() if label.endswith(names))


@pytest.mark.parametrize(
    ("signal", "path", "mean", "size", "bounds"),
    [
        ("wind_speed", "wind.history", WIND, 1e-3, (2e-3, 8e-3)),
        ("tower[0]_x1", "section.left_end.motion.x1", 0.0, 1e-4, (0.01, 0.02)),
        ("tower[1]_x1", "section.suspensions.0.motion.x1", 0.0, 1e-3, (2e-3, 0.04)),
        ("tower[1]_x3", "section.suspensions.0.motion.x3", 0.0, 1e-3, (8e-3, 0.15)),
    ],
)
def test_response_is_that_of_a_small_simulated_motion(
    scene, model, signal, path, mean, size, bounds
):
    """Observed: displacements 1.0e-3, 7.3e-3, 1.3e-3, 5.1e-3; forces 5.2e-3, 0.013, 0.024, 0.11.

    Forces lack the inertia of what moves with the tower at once, and slow modes alone are kept.
    """
    found = of_line(model, scene, signal, path, mean, size)
    assert worst(found, "x2", "x3") < bounds[0]
    assert worst(found, "f1", "f2", "f3") < bounds[1]


def test_a_yoke_moves_its_bundle():
    """Two subconductors on one string with a heavy yoke, which only the string moves.

    Observed: 1.0e-3 and 0.031; 0.030 and 0.39 if the tower moves the yoke at once.
    """
    bundle = {"subconductors": 2, "spacing": 0.4, "spacers": 1, "yoke_mass": 80.0}
    scene = zebra(2, elements=6, bundle=bundle, wind={"speed": 0.0})
    model = modal.linear_model(scene, 120)
    found = of_line(model, scene, "tower[1]_x3", "section.suspensions.0.motion.x3", 0.0, 1e-3)
    assert worst(found, "midspan_x3") < 2e-3
    assert worst(found, "f3") < 0.05


def test_winds_of_the_spans_add_up_to_that_of_the_line(model):
    gain = model.dcgain()
    inputs = list(model.input_labels)
    spans = [inputs.index(f"span[{k}]_wind_speed") for k in (1, 2)]
    assert gain[:, spans].sum(axis=1) == pytest.approx(
        gain[:, inputs.index("wind_speed")], rel=1e-9, abs=1e-9
    )


def test_equal_phases_have_the_same_response():
    """Their eigenvalues are equal, and each phase has a mode of its own."""
    phases = [{"name": "a", "offset": [0.0, -4.0]}, {"name": "b", "offset": [0.0, 4.0]}]
    model = modal.linear_model(iced(phases=phases), 8)
    gain = model(1j * 1.3)
    rows = [list(model.output_labels).index(f"span[2]_phase[{k}]_midspan_x2") for k in (1, 2)]
    assert gain[rows[0]] == pytest.approx(gain[rows[1]], rel=1e-6, abs=1e-9)


@pytest.mark.parametrize("modes", [None, 0, True])
def test_a_line_needs_a_number_of_modes(scene, modes):
    with pytest.raises(gf.SceneError, match="made of its lowest modes; give their number"):
        modal.linear_model(scene, modes)
