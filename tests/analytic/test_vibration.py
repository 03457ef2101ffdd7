"""Small free vibration of a taut span: frequency of string and shaft, decay by Rayleigh's ratio."""

import numpy as np
import pytest

from gallop_fmu.engine.model import Model
from gallop_fmu.foundation.channels import NODE_INDEX
from support.taut_span import taut_span

STEP = 0.01
NODE = np.array([NODE_INDEX["u3"], NODE_INDEX["theta"]], np.int32)
HORIZONTAL = np.sqrt(92000.0 / 1.5) / 200.0  # sqrt(H/m) / (2 L), 1.238 Hz
TWIST = np.sqrt(150.0 / 1.5e-4) / 200.0  # sqrt(GJ/I) / (2 L), 5 Hz


def motion(ratio, count):
    """Mid-span u3 and twist at every step, 100 m with a sag of 0.2 m; small, so independent."""
    damping = {
        name: {
            "low_ratio": ratio,
            "low_frequency": f,
            "high_ratio": 2.0 * ratio,
            "high_frequency": 3.0 * f,
        }
        for name, f in (("translation", HORIZONTAL), ("twist", TWIST))
    }
    model = Model(
        taut_span(
            damping=damping if ratio else {},
            initial={"seed_horizontal": 1e-4, "seed_twist": 1e-3},
            numerics={"time_step": STEP, "newton_tolerance": 1e-14},
        )
    )
    state = model.start()
    values = state.run(count, 1, NODE, np.array([model.middle], np.int32)).node_values[:, :, 0]
    return np.vstack([[1e-4, 1e-3], values])


def frequency_and_ratio(values):
    """Frequency of a decaying oscillation, from the recurrence y(n+1) = 2 c d y(n) - d^2 y(n-1)."""
    (p, q), *_ = np.linalg.lstsq(
        np.column_stack([values[1:-1], values[:-2]]), values[2:], rcond=None
    )
    pole = np.log(np.roots([1.0, -p, -q])[0].astype(complex)) / STEP
    return abs(pole.imag) / (2.0 * np.pi), -pole.real / abs(pole)


def newmark(frequency, ratio):
    """An oscillator under Newmark's rule (beta 1/4): the pole s becomes (2/h) atanh(s h/2)."""
    pole = 2.0 * np.pi * frequency * (-ratio + 1j * np.sqrt(1.0 - ratio**2))
    pole = 2.0 / STEP * np.arctanh(0.5 * STEP * pole)
    return abs(pole.imag) / (2.0 * np.pi), -pole.real / abs(pole)


@pytest.mark.parametrize(
    ("channel", "exact", "bound"),
    [(0, HORIZONTAL, 3e-6), (1, TWIST, 3e-5)],
    ids=["horizontal", "twist"],
)
@pytest.mark.parametrize("asked", [0.0, 0.02])
def test_frequency_and_decay(channel, exact, bound, asked):
    """The remainder is the sag, 0.2 %: it lengthens the conductor by (8/3) (sag / L)^2 = 1e-5.

    The ratio is asked for at the mode's own frequency; the second frequency has another, so that b1
    and b2 differ.
    """
    frequency, ratio = frequency_and_ratio(motion(asked, 400)[:, channel])
    expected_frequency, expected_ratio = newmark(exact, asked)
    assert frequency == pytest.approx(expected_frequency, rel=bound)  # observed 9e-7 and 9e-6
    assert ratio == pytest.approx(expected_ratio, abs=4e-7)  # observed 1e-7
