"""The slope that galloping needs: neutral in the whole linear model, and closed forms."""

import math

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from support.line_scenes import section
from support.square_prism import FORCE, limit_cycles, onset_wind_speed, prism
from support.taut_span import taut_span

NEUTRAL = 1e-7
"""Growth over the damping in still air of a mode that is neutral (observed 1e-10)."""

RATIOS = {"low_ratio": 0.004, "low_frequency": 0.2, "high_ratio": 0.006, "high_frequency": 2.0}
TWIST = {"low_ratio": 0.02, "low_frequency": 1.0, "high_ratio": 0.02, "high_frequency": 8.0}
DAMPED = {"damping": {"translation": RATIOS, "twist": TWIST}}


def curve(attack_angle_deg, drag, lift_slope, moment_slope):
    """Straight lines through the attack angle."""
    return {
        "kind": "polynomial",
        "centre_deg": attack_angle_deg,
        "valid_from_deg": attack_angle_deg - 10.0,
        "valid_to_deg": attack_angle_deg + 10.0,
        "lift": [0.0, lift_slope],
        "drag": [drag],
        "moment": [0.0, moment_slope],
    }


def drawn_span(seed):
    """Level or inclined, between rigid or sprung ends, with eccentric ice."""
    random = np.random.default_rng(seed)
    length = random.uniform(100.0, 400.0)
    ends = {"kind": "rigid"}
    if seed % 2:
        ends = {"kind": "springs", "stiffness_x1": 2e5, "stiffness_x3": 5e4}
    return taut_span(
        span={
            "length": length,
            "height_difference": random.uniform(0.1, 0.4) * length if seed % 3 == 1 else 0.0,
            "horizontal_tension": random.uniform(15e3, 40e3),
        },
        conductor={"torsional_stiffness": random.uniform(100.0, 400.0)},
        ice={
            "mass_per_length": random.uniform(0.0, 1.5),
            "torsional_inertia": 1e-4,
            "first_moment_x2": random.uniform(-1e-3, 1e-3),
            "first_moment_x3": random.uniform(-1e-3, 1e-3),
            "attack_angle_deg": random.uniform(-180.0, 180.0),
        },
        supports={"left": ends, "right": ends},
        numerics={"elements": 10},
        **DAMPED,
    )


def drawn_line(seed):
    """A section of three spans, single or twin."""
    random = np.random.default_rng(seed)
    tables = {}
    if seed % 2:
        tables["bundle"] = {"subconductors": 2, "spacing": 0.4, "spacers": 3}
    return section(
        random.uniform(20e3, 35e3),
        random.uniform(150.0, 400.0, 3).tolist(),
        16.0,
        29e6,
        torsion=(159.0, 2e-4),
        elements=8,
        ice={"mass_per_length": random.uniform(0.0, 1.0), "attack_angle_deg": 20.0},
        **tables,
        **DAMPED,
    )


def growth(scene, number, wind, aerodynamics):
    """Least modulus of a damping ratio among the lowest modes of a scene in wind."""
    changed = scene.with_values({"aerodynamics": aerodynamics, "wind.speed": wind})
    modes = modal.natural_modes(changed, number, "mean")
    return min(abs(mode.damping_ratio) for mode in modes)


@pytest.mark.parametrize("scene", [*map(drawn_span, range(4)), *map(drawn_line, range(2))])
def test_a_curve_with_the_slope_is_neutral(scene):
    winds, moment_slope = [3.0, 6.0], -0.4
    found = modal.required_slope(scene, winds, count=3, moment_slope=moment_slope, drag=1.2)
    ice = scene.ice if isinstance(scene, gf.Scene) else scene.ice_of_span(1)
    data, tested = found.dataset, 0
    for wind in winds:
        for mode in data.mode.values[:3]:
            at = data.sel(mode=mode, wind_speed=wind)
            if math.isnan(at.slope):
                continue
            neutral = curve(ice.attack_angle_deg, 1.2, at.slope.item() - 1.2, moment_slope)
            assert growth(scene, 6, wind, neutral) < NEUTRAL * at.damping_ratio.item()
            tested += 1
    assert tested >= 2


@pytest.mark.parametrize("seed", range(2))
def test_a_torsional_mode_is_neutral_too(seed):
    scene, wind = drawn_span(seed), 6.0
    data = modal.required_slope(scene, [wind], lift_slope=-1.5, drag=1.2).dataset
    at = data.isel(mode=-1, wind_speed=0)
    assert at.family == "torsional"
    neutral = curve(scene.ice.attack_angle_deg, 1.2, -1.5, at.moment_slope.item())
    assert growth(scene, 70, wind, neutral) < NEUTRAL * at.damping_ratio.item()


@pytest.fixture(scope="module")
def stiff():
    """A taut span without sag and eccentric ice, whose shapes are sines."""
    return taut_span(span={"gravity": 0.01}, **DAMPED)


def test_estimates_are_den_hartogs_and_nigols(stiff):
    wind, air, size, inertia = 8.0, 1.225, 0.028, 1.5e-4
    data = modal.required_slope(stiff, [wind]).dataset.isel(wind_speed=0)
    vertical = data.isel(mode=int((data.family == "vertical").argmax("mode")))
    pair = 4.0 * 1.5 * 2.0 * math.pi * (vertical.still_air_hz * vertical.damping_ratio).item()
    assert vertical.slope_estimate.item() == pytest.approx(-pair / (air * wind * size), rel=1e-6)
    assert vertical.slope.item() == pytest.approx(
        vertical.slope_estimate.item(), rel=1e-3
    )  # observed 4e-5
    twist = data.isel(mode=-1)
    pair = 4.0 * inertia * 2.0 * math.pi * (twist.still_air_hz * twist.damping_ratio).item()
    nigol = -pair / (air * wind * size**2 * 0.5 * size)
    assert twist.moment_slope_estimate.item() == pytest.approx(nigol, rel=1e-6)
    omega = 2.0 * math.pi * twist.still_air_hz.item()
    diverges = 2.0 * inertia * omega**2 / (air * wind**2 * size**2)
    assert data.divergence_moment_slope.item() == pytest.approx(diverges, rel=2e-3)


@pytest.mark.parametrize("moment_slope", [-40.0, 1.0])
def test_coupled_slope_is_that_of_the_flutter_determinant(stiff, moment_slope):
    """Vertical motion and twist of a section: det = 0 at s = i w, solved over w apart from the
    program. The moment moves the torsional frequency, 5 Hz in still air."""
    wind, drag = 12.0, 1.0
    data = modal.required_slope(stiff, [wind], moment_slope=moment_slope).dataset
    vertical = data.isel(mode=int((data.family == "vertical").argmax("mode")), wind_speed=0)
    mass, inertia, size = 1.5, 1.5e-4, 0.028
    w_v, w_t = (
        2.0 * math.pi * hz for hz in (vertical.still_air_hz.item(), data.still_air_hz[-1].item())
    )
    xi_v, xi_t = vertical.damping_ratio.item(), data.damping_ratio[-1].item()
    load, arm = 0.5 * 1.225 * wind * size, 0.5 * size

    def slope(w):
        """Complex lift slope at which the determinant, linear in it, vanishes."""
        s = 1j * w
        v = mass * s**2 + (2.0 * mass * xi_v * w_v + load * drag) * s + mass * w_v**2
        t = inertia * s**2 + 2.0 * inertia * xi_t * w_t * s + inertia * w_t**2
        t += load * size * moment_slope * (arm * s - wind)
        by_v = load * size * moment_slope * s
        # (v + load p s) t - by_v (load p (arm s - wind) + load drag arm s) = 0
        return -(v * t - by_v * load * drag * arm * s) / (
            load * s * t - by_v * load * (arm * s - wind)
        )

    w = np.linspace(0.9 * w_v, 1.1 * w_v, 200001)
    found = slope(w)
    at = np.flatnonzero(np.diff(np.sign(found.imag)))
    assert len(at) == 1
    assert vertical.slope.item() == pytest.approx(
        drag + found[at[0]].real, rel=1e-3
    )  # observed 2e-4
    assert vertical.frequency_hz.item() == pytest.approx(w[at[0]] / 2.0 / math.pi, rel=1e-4)


def test_a_mode_that_grows_above_a_slope_is_said(stiff):
    found = modal.required_slope(stiff, [12.0], moment_slope=30.0)
    assert np.isnan(found.dataset.slope.sel(mode=2))
    (remark,) = (text for text in found.remarks if text.startswith("mode 2"))
    assert "at 12 m/s it grows where CD + dCL/dalpha is above 21.3 1/rad" in remark


def test_a_curve_crosses_its_needed_slope_at_the_critical_wind():
    """Not exactly: the lift, moment and slope of the drag of the curve are not in the model."""
    scene = gf.load_scene("example3")
    critical = modal.critical_wind_speed(scene, 2, 6.0)[1].wind_speed
    found = modal.required_slope(scene, [0.99 * critical, 1.01 * critical], moment_slope=-0.3)
    own = scene.aerodynamics.curve().den_hartog(math.pi)
    before, after = found.decisive().values
    assert before < own < after


def test_amplitude_is_that_of_a_cubic_force():
    """Simulated amplitude at twice the slope that is needed."""
    wind, saturation_deg = 2.0 * onset_wind_speed(), 15.0
    cubic = (FORCE[0], -FORCE[0] / math.tan(math.radians(saturation_deg)) ** 2)
    found = modal.required_slope(prism(wind, 0.0), [wind], saturation_deg=saturation_deg)
    estimate = found.amplitude(-FORCE[0]).sel(mode=2).item()
    result = gf.simulate(prism(wind, 1.1 * estimate, force=cubic))
    u2 = np.ravel(result.dataset.u2.values)[-1000:]
    assert 0.5 * (u2.max() - u2.min()) == pytest.approx(estimate, rel=5e-3)
    assert found.amplitude(0.9 * found.decisive().item()).sel(mode=2).item() == 0.0


def test_amplitude_limit_of_the_square_prism():
    """Its force vanishes again at 15.2 deg; the limit is 8 % below the amplitude in strong wind."""
    polynomial = np.polynomial.Polynomial(FORCE)
    roots = polynomial.roots()
    again = math.sqrt(min(roots.real[(np.abs(roots.imag) < 1e-12) & (roots.real > 0.0)]))
    wind = 50.0 * onset_wind_speed()
    scene = prism(wind, 0.0)
    found = modal.required_slope(scene, [wind], saturation_deg=math.degrees(math.atan(again)))
    (amplitude,) = limit_cycles(50.0)
    assert found.dataset.amplitude_limit.sel(mode=2).item() == pytest.approx(amplitude, rel=0.3)


def test_results_have_units_and_a_table():
    scene = drawn_line(0)
    found = modal.required_slope(scene, [4.0, 8.0], count=4)
    frame = found.to_dataframe()
    assert len(frame) == 2 * found.dataset.sizes["mode"]
    assert frame.attrs["units"]["slope"] == "1/rad"
    assert set(found.by_span().dims) == {"span", "wind_speed"}
    assert found.by_span().max("span").values == pytest.approx(found.decisive().values)
    assert "the drag coefficient is assumed to be 1" in found.remarks
    for name, values in found.dataset.data_vars.items():
        assert values.dtype.kind in "USO" or "units" in values.attrs, name


def test_without_damping_any_negative_slope_is_enough():
    undamped = taut_span(span={"gravity": 0.01})
    found = modal.required_slope(undamped, [5.0], count=2)
    assert found.decisive().item() == pytest.approx(0.0, abs=1e-3)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"wind_speeds": []}, "at least one wind speed"),
        ({"wind_speeds": [3.0, 0.0]}, "0.0 m/s: must be a finite, positive"),
        ({"wind_speeds": [3.0, 2.0]}, "must increase"),
        ({"wind_speeds": [math.nan]}, "must be a finite, positive"),
        ({"drag": -1.0}, "drag = -1.0: must be"),
        ({"moment_slope": math.inf}, "moment_slope = inf"),
        ({"saturation_deg": 90.0}, "saturation_deg = 90.0: must be"),
        ({"count": 0}, "count = 0: must be"),
    ],
)
def test_bad_arguments_are_named(stiff, options, message):
    with pytest.raises(gf.SceneError, match=message):
        modal.required_slope(stiff, **options)


def test_an_amplitude_needs_a_negative_slope(stiff):
    with pytest.raises(gf.SceneError, match=r"slope = 0\.5 1/rad: must be a negative"):
        modal.required_slope(stiff, [5.0], count=1).amplitude(0.5)
