"""Linear theory about the equilibrium in wind, with rotated ice, against the simulation."""

import numpy as np
import pytest

import gallop_fmu as gf
import modal

SEED = 11
PRECISE = {"numerics.newton_tolerance": 1e-14, "initial.wind": "mean_wind_equilibrium"}


def drawn(random):
    """A sloping span with eccentric ice that wind rotates by 0.2 to 1 rad; its modes in wind."""
    while True:
        length, diameter = random.uniform(80.0, 350.0), random.uniform(0.018, 0.032)
        mass, ice = random.uniform(1.0, 2.0), random.uniform(0.2, 1.0)
        arm, direction = random.uniform(0.2, 0.5) * diameter, random.uniform(0.0, 2.0 * np.pi)
        values = {
            "span.length": length,
            "span.sag": random.uniform(0.008, 0.03) * length,
            "span.horizontal_tension": None,
            "span.height_difference": random.uniform(-0.3, 0.3) * length,
            "conductor.diameter": diameter,
            "conductor.mass_per_length": mass,
            "conductor.torsional_stiffness": random.uniform(80.0, 300.0),
            "conductor.torsional_inertia": mass * diameter**2 / 8.0,
            "conductor.axial_stiffness": random.uniform(1e7, 4e7),
            "ice.mass_per_length": ice,
            "ice.torsional_inertia": ice * (arm**2 + diameter**2 / 16.0),
            "ice.attack_angle_deg": random.uniform(140.0, 220.0),
            "ice.first_moment_x2": ice * arm * np.sin(direction),
            "ice.first_moment_x3": ice * arm * np.cos(direction),
            "wind.speed": random.uniform(5.0, 16.0),
            "numerics.elements": 12,
        }
        try:
            scene = gf.load_scene("example3").with_values(values | PRECISE)
            turn = np.abs(gf.Model(scene).rest().motion()[0][:, 3]).max()
            if not 0.2 < turn < 1.0:
                continue
            modes = modal.natural_modes(scene, 16, wind="mean")
            if (
                max(mode.eigenvalue.real for mode in modes) < 0.5
            ):  # 1/s; else it is over before it can be seen
                return scene, modes
        except (gf.SceneError, gf.SimulationError):  # no equilibrium, or off the curve
            continue


def rates_seen(scene, seconds):
    """Eigenvalues [1/s] about the mean-wind equilibrium, by dynamic mode decomposition of a run."""
    seeds = {
        "initial.seed_vertical": 1e-6,
        "initial.seed_horizontal": 7e-7,
        "initial.seed_twist": 1e-6,
    }
    data = gf.simulate(
        scene.with_values(seeds),
        stop_time=seconds,
        record_every=8,
        record_nodes="all",
        on_failure="return",
    ).dataset
    motion = np.concatenate([data[name].values for name in ("u1", "u2", "u3", "theta")], axis=1)
    motion = (motion - gf.Model(scene).rest().motion()[0].T.ravel())[int(0.4 * len(motion)) :].T
    motion = motion[::4]  # a quarter of the unknowns distinguishes all modes
    left, size, right = np.linalg.svd(motion[:, :-1], full_matrices=False)
    kept = slice(min(12, int(np.sum(size > 1e-10 * size[0]))))
    step = left[:, kept].T @ motion[:, 1:] @ right[kept].T / size[kept]
    return np.log(np.linalg.eigvals(step).astype(complex)) / (
        data.time.values[1] - data.time.values[0]
    )


def test_slowest_decay_of_drawn_spans_is_that_of_the_simulation():
    """Release 0.1.0 took the untwisted section's mass matrix: damping off by up to 7 times."""
    random = np.random.default_rng(SEED)
    for _ in range(10):
        scene, modes = drawn(random)
        lead = max((mode.eigenvalue for mode in modes), key=lambda value: value.real)
        seen = rates_seen(scene, min(150.0, 7.0 / lead.real) if lead.real > 0.0 else 150.0)
        nearest = seen[np.argmin(np.abs(seen - lead))]
        assert nearest.real == pytest.approx(
            lead.real, rel=0.02
        )  # observed 1e-4 to 2e-3, once 1.3e-2
        assert nearest.imag == pytest.approx(lead.imag, rel=1e-3)


@pytest.mark.parametrize(("angle", "right"), [(160.0, [6.7080, 11.0987]), (150.0, [12.280])])
def test_critical_winds_with_the_mass_of_the_rotated_section(angle, right):
    """An independent patch of release 0.1.0 with the mass matrix at the equilibrium."""
    scene = gf.load_scene("example3").with_values(
        {"ice.attack_angle_deg": angle, "ice.first_moment_angle_deg": angle, "wind.speed": 6.0}
    )
    onsets = modal.critical_wind_speed(scene, count=4, highest_wind=13.0)
    found = sorted(onset.wind_speed for onset in onsets if onset.wind_speed is not None)
    assert found[: len(right)] == pytest.approx(
        right, rel=3e-3
    )  # observed up to 2.3e-3: lift is vertical there


@pytest.mark.parametrize("angle", [150.0, 160.0, 200.0])
def test_critical_wind_of_example_3_at_other_attack_angles(angle):
    """The growth rate of the full model passes zero."""
    scene = gf.load_scene("example3").with_values(
        {"ice.attack_angle_deg": angle, "numerics.elements": 12} | PRECISE
    )
    onset = min(
        (
            c
            for c in modal.critical_wind_speed(scene, count=3, highest_wind=13.0)
            if c.wind_speed is not None
        ),
        key=lambda c: c.wind_speed,
    )
    target, winds, growth = (
        2j * np.pi * onset.frequency_hz,
        np.array([0.95, 1.05]) * onset.wind_speed,
        [],
    )
    for wind in winds:
        seen = rates_seen(scene.with_values({"wind.speed": float(wind)}), 150.0)
        growth.append(seen[np.argmin(np.abs(seen - target))].real)
    assert growth[0] < 0.0 < growth[1]
    zero = winds[0] - growth[0] * (winds[1] - winds[0]) / (growth[1] - growth[0])
    assert zero == pytest.approx(onset.wind_speed, rel=0.01)
