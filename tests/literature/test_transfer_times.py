"""Times in which disturbances of a motion grow, from its multipliers, against simulation."""

import numpy as np
import pytest

import gallop_fmu as gf
import modal
from modal.motions.full_model import RECORDS_PER_PERIOD, full_scene, run_from
from modal.screening.multipliers import disturbances
from modal.screening.span_diagram import span_diagram, span_model

SMALL, VISIBLE = 1e-3, 0.03
"""Amplitudes [m] of the disturbance between which the time is measured."""

STEPS = 150

PERIODS = 4
"""Periods of the orbit in which an amplitude is measured."""


def simulated_growth(diagram, point, shape, part):
    """Time [s] in which a disturbance of an orbit grows in the full model, by a part of the motion.

    ``part`` gives the part of the records (record, channel, node) that the orbit does not have.
    """
    model = diagram.model
    scene = full_scene(diagram.scene, "wind.speed", diagram.wind, model, STEPS)
    real = np.real(shape / np.exp(1j * np.angle(shape[np.argmax(np.abs(shape))])))
    size = np.max(np.abs(model.nodal(real[None, : model.size], real[None, : model.size])[0]))
    _, values, step = run_from(scene, model, point.states[0] + 1e-4 * real / size, 420.0)
    late = round(point.period / step)
    moved = part(values, late)
    window = PERIODS * late
    count = len(moved) // window
    envelope = 0.5 * np.ptp(moved[: count * window].reshape(count, window), axis=1)
    times = (np.arange(count) + 0.5) * window * step
    growing = slice(0, int(np.argmax(envelope > 2.0 * VISIBLE)) + 1)
    logs = np.log(envelope[growing])
    small, visible = np.interp(np.log([SMALL, VISIBLE]), logs, times[growing])
    return visible - small


@pytest.mark.parametrize(("wind", "origin"), [(5.5, "one loop"), (6.5, "one loop with swing")])
def test_a_disturbance_takes_the_predicted_time(wind, origin):
    """The swing of galloping in one loop; motion in two loops of galloping with swing."""
    scene = gf.load_scene("example3").with_values({"wind.speed": wind})
    diagram = span_diagram(span_model(scene), 1.02 * wind)
    swings = [b for b in diagram.orbits if b.origin.kind == "period doubling"]
    branch = swings[0] if "swing" in origin else diagram.orbits[0]
    (point,) = diagram.at_wind(branch)
    fastest = disturbances(point, diagram.model)[0]
    transfer = modal.Transfer(
        origin, "", float(np.log(abs(fastest.multiplier))) / point.period, 0.0
    )

    def swing(values, late):
        return 0.5 * (values[late:, 1, 1] - values[:-late, 1, 1])

    def two_loops(values, late):
        return 0.5 * (values[:, 0, 0] - values[:, 0, 2])

    found = simulated_growth(
        diagram, point, fastest.shape, two_loops if "swing" in origin else swing
    )
    assert RECORDS_PER_PERIOD * 3 == STEPS
    assert found == pytest.approx(transfer.time(SMALL, VISIBLE), rel=0.05)


def test_amplitudes_of_a_transfer_must_be_positive():
    with pytest.raises(ValueError, match="must be positive"):
        modal.Transfer("rest", "swing", 0.1, 1.0).time(0.0)
