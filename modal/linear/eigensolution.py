"""Eigenvalues and eigenvectors of M q'' + C q' + K q = 0, sparse or dense."""

from __future__ import annotations

from typing import TYPE_CHECKING, cast

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import SceneError

if TYPE_CHECKING:
    from scipy.sparse import csc_array

Array = NDArray[np.float64]
ComplexArray = NDArray[np.complex128]

MIN_OSCILLATION = 1e-9
"""Imaginary part of an eigenvalue, relative to its modulus, below which nothing oscillates."""

MAX_SPARSE_SHARE = 0.3
"""Eigenvalues over unknowns from which dense matrices are faster, if `growth_bound` needs many."""

MIN_GROWTH_BOUND = 0.25
"""First bound [1/s] of real eigenvalues; it is raised until no motion can grow faster."""
MAX_GROWTH_BOUND = 1e6
"""Bound [1/s] from which all eigenvalues are computed."""


MAX_DENSE = 200
"""Unknowns up to which natural modes are computed from dense matrices: up to four times as fast."""


def is_stable(stiffness: csc_array) -> bool:
    """True if no pivot of a factorisation is negative.

    In still air the number of negative eigenvalues is that of negative pivots (Sylvester). In wind
    the matrix is not symmetric; with an odd number of negative pivots the determinant is negative,
    and one eigenvalue of the motion is real and positive.
    """
    from scipy.sparse.linalg import splu

    factors = splu(
        stiffness,
        permc_spec="MMD_AT_PLUS_A",
        diag_pivot_thresh=0.0,
        options={"SymmetricMode": True},
    )
    return bool(np.all(factors.U.diagonal() > 0.0))


def lowest(mass: csc_array, stiffness: csc_array, count: int) -> tuple[Array, Array]:
    """Squared angular frequencies [1/s2], ascending, and mass-normalised vectors (columns)."""
    unknowns = mass.shape[0]
    if unknowns > MAX_DENSE and count < unknowns - 1:
        from scipy.sparse.linalg import eigsh

        squares, vectors = eigsh(stiffness, count, mass, sigma=0.0, v0=_start(unknowns))
        order = np.argsort(squares)
        return squares[order], vectors[:, order]
    from scipy.linalg import eigh

    # Of the inverse problem: rounding errors are small relative to the lowest frequencies.
    inverses, vectors = eigh(
        mass.toarray(), stiffness.toarray(), subset_by_index=(unknowns - count, unknowns - 1)
    )
    return 1.0 / inverses[::-1], (vectors / np.sqrt(inverses))[:, ::-1]


def oscillating(
    matrices: tuple[csc_array, csc_array, csc_array], count: int, *, every: bool, divergence: str
) -> tuple[ComplexArray, ComplexArray]:
    """Compute the oscillating modes with the smallest moduli.

    Parameters
    ----------
    matrices
        Mass, damping and stiffness.
    count
        Number of modes.
    every
        True: also compute all real eigenvalues that can be positive, so that no motion that grows
        without oscillation is missed.
    divergence
        Message of the error if a motion grows without oscillation.

    Returns
    -------
    ndarray, ndarray
        Eigenvalues [1/s] with positive imaginary part by modulus, and mass-normalised vectors.

    Raises
    ------
    SceneError
        If a motion grows without oscillation, or fewer modes oscillate.
    """
    unknowns = matrices[0].shape[0]
    wanted, reach = 2 * count + 4, growth_bound(*matrices) if every else 0.0
    while True:
        dense = wanted >= (MAX_SPARSE_SHARE if every else 1.0) * unknowns
        values, vectors = eigenpairs(*matrices) if dense else nearest_to_zero(*matrices, wanted)
        oscillates = np.abs(values.imag) > MIN_OSCILLATION * np.abs(values)
        if np.any(values.real[~oscillates] > 0.0):
            raise SceneError(divergence)
        chosen = np.flatnonzero(oscillates & (values.imag > 0.0))
        if dense or (len(chosen) >= count and np.abs(values).max() > reach):
            break
        wanted *= 2
    if len(chosen) < count:
        raise SceneError(
            f"count = {count}: only {len(chosen)} modes of this mesh oscillate; lower count"
        )
    chosen = chosen[np.argsort(np.abs(values[chosen]))][:count]
    return values[chosen], normalised(vectors[:unknowns, chosen], matrices[0])


def growth_bound(mass: csc_array, damping: csc_array, stiffness: csc_array) -> float:
    """Upper bound [1/s] of the real eigenvalues of M s^2 + C s + K.

    A real eigenvalue s has a real vector q with q'P(s)q = 0, where P(s) is the symmetric part of
    M s^2 + C s + K. If P(S) and its derivative 2 M S + C are positive definite, so are both at all
    s > S, as M is; hence no real eigenvalue is larger than S.
    """
    damping, stiffness = ((each + each.T).tocsc() / 2.0 for each in (damping, stiffness))
    bound = MIN_GROWTH_BOUND
    while bound < MAX_GROWTH_BOUND and not (
        is_stable(bound**2 * mass + bound * damping + stiffness)
        and is_stable(2.0 * bound * mass + damping)
    ):
        bound *= 1.5
    return bound


def nearest_to_zero(
    mass: csc_array, damping: csc_array, stiffness: csc_array, count: int
) -> tuple[ComplexArray, ComplexArray]:
    """Eigenpairs of M s^2 + C s + K with the smallest |s|.

    They are the largest ones of the inverse of the first-order form, by Arnoldi's method.
    """
    from scipy.sparse.linalg import LinearOperator, eigs, splu

    unknowns = mass.shape[0]
    factors = splu(stiffness)

    def inverse(y: Array) -> Array:
        y = y.ravel()
        return np.concatenate(
            [-factors.solve(damping @ y[:unknowns] + mass @ y[unknowns:]), y[:unknowns]]
        )

    operator = LinearOperator((2 * unknowns, 2 * unknowns), matvec=inverse, dtype=np.float64)
    inverses, vectors = eigs(operator, count, which="LM", v0=_start(2 * unknowns))
    return 1.0 / inverses, vectors


def eigenpairs(
    mass: csc_array, damping: csc_array, stiffness: csc_array
) -> tuple[ComplexArray, ComplexArray]:
    """All eigenvalues [1/s] of M s^2 + C s + K, and vectors of displacements and velocities."""
    return cast(
        tuple[ComplexArray, ComplexArray],
        tuple(np.linalg.eig(state_matrix(mass, damping, stiffness))),
    )


def state_matrix(mass: csc_array, damping: csc_array, stiffness: csc_array) -> Array:
    """First-order form of M q'' + C q' + K q = 0 for displacements and velocities, dense."""
    unknowns = mass.shape[0]
    matrix = np.zeros((2 * unknowns, 2 * unknowns))
    matrix[:unknowns, unknowns:] = np.eye(unknowns)
    matrix[unknowns:] = -np.linalg.solve(
        mass.toarray(), np.hstack([stiffness.toarray(), damping.toarray()])
    )
    return matrix


def _start(size: int) -> Array:
    """Start vector of an iteration, always the same, for reproducible results."""
    return np.random.default_rng(0).standard_normal(size)


def normalised(vectors: ComplexArray, mass: csc_array) -> ComplexArray:
    """Scale vectors to modal mass 1, at the phase with the largest real part."""
    weighted = mass @ vectors
    size = np.sqrt(np.einsum("im,im->m", vectors.conj(), weighted).real)
    phase = np.exp(-0.5j * np.angle(np.einsum("im,im->m", vectors, weighted)))
    return cast(ComplexArray, vectors * phase / size)
