"""Stretches with their own coefficient curve, and interphase spacers between bundles, at rest."""

import numpy as np
import pytest

from gallop_fmu.engine.model import Model
from support.sections import section

SPEED, LENGTH, TENSION, AIR, DIAMETER = 3.0, 300.0, 25e3, 1.225, 0.02814
STEADY = {"kind": "constant", "value": 1.0}


def curve(drag):
    return {
        **{"kind": "polynomial", "lift": [0.0], "drag": [drag], "moment": [0.0]},
        **{"valid_from_deg": -90.0, "valid_to_deg": 90.0},
    }


def blown(start, stop, drag):
    """Deflection downwind of a span whose drag coefficient is 1, and `drag` on a stretch."""
    spoiler = {
        **{"kind": "interval", "span": 1, "from_station": start, "to_station": stop},
        "aerodynamics": curve(drag),
    }
    scene = section(
        (LENGTH,),
        tension=TENSION,
        wind={"speed": SPEED, "air_density": AIR},
        aerodynamics=curve(1.0),
        devices=[spoiler] if drag != 1.0 else [],
        initial={"wind": "mean_wind_equilibrium"},
        numerics={"elements": 20},
    )
    model = Model(scene)
    return model.equilibrium().x[:, 0] / LENGTH, model.start().motion()[0][:, 2]


def deflection(x, start, stop, drag):
    """H u3'' = -f(x) of a taut conductor, for a load f on its whole length and on a stretch.

    At x a unit load at s deflects it by L/H times min(x, s) (1 - max(x, s)), x and s over L.
    """
    force = 0.5 * AIR * DIAMETER * SPEED**2

    def whole(a, b):
        left, right = np.clip(x, a, b), np.clip(x, a, b)
        of_left = 0.5 * (left**2 - a**2) * (1.0 - x)
        of_right = x * ((b - right) - 0.5 * (b**2 - right**2))
        return (of_left + of_right) * LENGTH**2 / TENSION

    return force * (whole(0.0, 1.0) + (drag - 1.0) * whole(start, stop))


@pytest.mark.parametrize("drag", [1.0, 0.4, 3.0])
def test_a_stretch_has_the_wind_force_of_its_own_curve(drag):
    """Observed 0.08 %: the sag makes the conductor longer than its chord."""
    x, found = blown(0.2, 0.6, drag)
    wanted = deflection(x, 0.2, 0.6, drag)
    assert found == pytest.approx(wanted, abs=1.5e-3 * wanted.max())
    assert wanted.max() > 0.03


def test_an_interphase_spacer_between_bundles_holds_the_subconductors_it_is_clamped_to():
    """Phases of twins are pushed apart; they rotate, since the bar is not at their centre."""
    phases = [{"name": "a"}, {"name": "b", "offset": [5.0, 0.0]}]
    twin = {"subconductors": 2, "spacing": 0.4, "spacers": 3, "clamp_torsional_stiffness": 500.0}
    loads = [
        {"span": 1, "phase": 1 + k, "position": 0.5, "force": [0.0, force, 0.0], "law": STEADY}
        for k, force in enumerate((-150.0, 150.0))
    ]
    bar = {"kind": "interphase_spacer", "span": 1, "station": 0.5, "phases": [1, 2]}
    apart = {}
    for name, devices in (("bar", [bar]), ("none", [])):
        scene = section((LENGTH,), phases=phases, bundle=twin, loads=loads, devices=devices)
        model = Model(scene)
        place = model.equilibrium().x + model.rest().motion()[0][:, :3]
        middle = {
            (phase, part): place[model.map.chain(1, phase, part).middle]
            for phase in (1, 2)
            for part in (1, 2)
        }
        apart[name] = [np.linalg.norm(middle[1, k] - middle[2, k]) for k in (1, 2)]
        tilt = middle[2, 2] - middle[2, 1]
        apart[name].append(abs(np.arctan2(tilt[1], abs(tilt[2]))))
    assert apart["bar"][0] == pytest.approx(5.0, abs=2e-4)  # 300 N on a bar of 5 MN/m
    assert apart["none"][0] > 5.3
    assert apart["bar"][1] > 5.05
    assert apart["bar"][2] > 0.1 > apart["none"][2]
    assert "rotates the bundles" in " ".join(scene.with_values({"devices": [bar]}).warnings)
