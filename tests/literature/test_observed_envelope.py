"""Amplitudes with the assumed curve, compared with CIGRE 322's envelope of observed amplitudes."""

import numpy as np

from support.observed_envelope import LINES, predict


def test_predicted_amplitudes_follow_the_envelope_of_observed_ones():
    found = [predict(conductor, span) for conductor, span in LINES]
    ratios = np.array([one.ratio for one in found])
    # Sag over diameter; observed: 47 to 481.
    sags = [one.sag / one.diameter for one in found]
    assert min(sags) < 50.0
    assert max(sags) > 475.0
    # Observed: 0.996, the aim of the calibration, and 0.574 to 1.489.
    assert abs(np.exp(np.log(ratios).mean()) - 1.0) < 0.01
    assert ratios.min() > 0.56
    assert ratios.max() < 1.51
