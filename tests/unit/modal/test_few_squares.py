"""Quadratic forms of products as sums of few squares."""

import numpy as np
import pytest

from modal.motions import span_model
from modal.motions.span_model import few_squares


@pytest.mark.parametrize("rank", [20, 100, 150, 500])
def test_squares_have_the_value_of_the_form(rank, monkeypatch):
    """Also of a form that is not symmetric, and of one with a high rank, which takes all of it."""
    draw = np.random.default_rng(rank)
    n = 40
    rows, columns = np.triu_indices(n)
    parts = draw.standard_normal((rank, len(rows)))
    form = (parts.T * draw.choice([-1.0, 1.0], rank)) @ parts
    skew = draw.standard_normal(form.shape)
    whole, sizes = np.linalg.eigh, list[int]()
    monkeypatch.setattr(
        span_model.np.linalg, "eigh", lambda of: (sizes.append(len(of)), whole(of))[1]
    )
    found = few_squares(form + skew - skew.T, n)
    assert sizes == [{20: 128, 100: 128, 150: 256, 500: len(rows)}[rank]]
    q = draw.standard_normal((3, n))
    products = np.where(rows == columns, 1.0, 2.0) * q[:, rows] * q[:, columns]
    values = (products @ form * products).sum(axis=1)
    squares = np.einsum("ika,ia->ik", found.times(q), q) ** 2 @ found.signs
    np.testing.assert_allclose(squares, values, rtol=1e-9)  # observed 2e-12
