"""Real eigenvalues that grow: their bound, and none of them missed by the sparse solver."""

import numpy as np
import pytest
from scipy.sparse import csc_array, diags_array

from gallop_fmu import SceneError
from modal.linear.eigensolution import eigenpairs, growth_bound, oscillating


def test_no_real_eigenvalue_is_beyond_the_bound():
    """Systems that are not symmetric, as in wind, drawn by a seed, against all eigenvalues."""
    random = np.random.default_rng(16)
    ratios = []
    for _ in range(40):
        mass = csc_array(np.diag(random.uniform(0.5, 2.0, 12)))
        damping, stiffness = (csc_array(random.normal(0.0, size, (12, 12))) for size in (0.5, 4.0))
        values, _ = eigenpairs(mass, damping, stiffness)
        real = values.real[np.abs(values.imag) < 1e-9]
        ratios.append(real.max(initial=0.0) / growth_bound(mass, damping, stiffness))
    assert 0.8 < max(ratios) <= 1.0  # found: 0.89


@pytest.mark.parametrize("growth", [3.0, None])
def test_a_motion_that_grows_fast_is_not_missed(growth):
    """Among 600 slower oscillators, one without oscillation has the eigenvalues -3 and 3 1/s."""
    squares = np.linspace(0.1, 40.0, 600)
    if growth is not None:
        squares[300] = -(growth**2)
    matrices = tuple(
        csc_array(diags_array(values)) for values in (np.ones(600), 0.01 * np.ones(600), squares)
    )

    def found():
        return oscillating(matrices, 4, every=True, divergence="it diverges")[0]

    if growth is None:
        assert np.abs(found()) == pytest.approx(np.sqrt(squares[:4]), rel=1e-6)
    else:
        with pytest.raises(SceneError, match="it diverges"):
            found()
