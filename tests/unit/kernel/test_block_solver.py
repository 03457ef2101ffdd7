"""The kernel's direct solver of a chain, against a dense solution by NumPy."""

import ctypes
import shlex
import subprocess
import sysconfig
from pathlib import Path

import numpy as np
import pytest

KERNEL = Path(__file__).parents[3] / "gallop_fmu" / "kernel"
# An element tangent's blocks: left-left, left-middle, left-right, middle-middle, middle-right,
# right-right; `part` tells real weights from imaginary ones by their c.
SHIM = """
#include "solver.h"
typedef struct { int elements, n; const double *block; } source; /* (parts, elements, 6, n, n) */
static void blocks(const void *from, int index, tangent_weights mix, lanes out[6][16])
{
    const source *s = from;
    const int size = 6 * s->n * s->n, first = (int)mix.c * s->elements;
    for (int k = 0; k < LANES; k++) {
        const int e = LANES * index + k, last = s->elements - 1;
        const double *block = s->block + size * (first + (e < last ? e : last));
        for (int i = 0; i < size; i++)
            LANE(out[i / (s->n * s->n)][i % (s->n * s->n)], k) = block[i];
    }
}
#define SETUP                                                                                     \\
    const tangent_weights mix[2] = {{1.0, 0.0, 1.0}, {0.0, 1.0, 0.0}};                            \\
    const source from = {elements, n, block};                                                     \\
    const kept_corner ends_kept[2] = {{0, 0}, {elements, 1}};                                     \\
    const int strips = (elements + LANES - 1) / LANES;                                            \\
    int start[64];                                                                                \\
    for (int k = 0; k < strips; k++) start[k] = LANES * k;                                        \\
    start[strips] = elements;                                                                     \\
    const solver_chain chain = {.elements = elements, .unknowns = n, .strips = strips,            \\
                                .strip_start = start, .kept_corners = 2, .ends = ends,            \\
                                .kept = ends ? NULL : ends_kept, .blocks = blocks,                \\
                                .source = &from};                                                 \\
    double *store = malloc(parts * solver_room(elements, strips, 1, true) * sizeof(double))
int solve(int parts, int elements, int n, const double *block, const bool *fixed,
          const double *tangent, double *rhs)
{
    chain_ends acting, *ends = &acting;
    memcpy(acting.fixed, fixed, sizeof acting.fixed);
    memcpy(acting.tangent, tangent, sizeof acting.tangent);
    SETUP;
    bool good = parts == 1 ? solver_real_factor(&chain, mix, store)
                           : solver_complex_factor(&chain, mix, store);
    if (good && parts == 1) solver_real_solve(&chain, store, rhs);
    if (good && parts == 2) solver_complex_solve(&chain, store, rhs);
    free(store);
    return good;
}
typedef double pairs[2][2][4][4];
/* rhs holds loads; where the ends' solution belongs, `moved` brings it between the two stages. */
int reduce(int parts, int elements, int n, const double *block, pairs *schur, const double *moved,
           double *rhs, double *end_loads)
{
    const chain_ends *ends = NULL;
    SETUP;
    const int last = 8 * parts * elements, size = 4 * parts;
    bool good = parts == 1 ? solver_real_reduce(&chain, mix, store)
                           : solver_complex_reduce(&chain, mix, store);
    if (good && parts == 1) solver_real_ends(&chain, store, 0, schur);
    if (good && parts == 2) solver_complex_ends(&chain, store, 0, schur);
    if (good && parts == 1) solver_real_to_ends(&chain, store, rhs);
    if (good && parts == 2) solver_complex_to_ends(&chain, store, rhs);
    for (int i = 0; i < size; i++) {
        end_loads[i] = rhs[i];
        end_loads[size + i] = rhs[last + i];
        rhs[i] = moved[i];
        rhs[last + i] = moved[size + i];
    }
    if (good && parts == 1) solver_real_from_ends(&chain, store, rhs);
    if (good && parts == 2) solver_complex_from_ends(&chain, store, rhs);
    free(store);
    return good;
}
"""


def compiled(folder, *flags):
    (folder / "shim.c").write_text(SHIM)
    sources = [folder / "shim.c", KERNEL / "solver_real.c", KERNEL / "solver_complex.c"]
    compiler = shlex.split(sysconfig.get_config_var("CC") or "cc")
    options = ["-std=c11", "-O0", "-DGALLOP_ONE_PATH", "-shared", "-fPIC", f"-I{KERNEL}", *flags]
    library = folder / "shim.so"
    subprocess.run([*compiler, *options, "-o", library, *sources, "-lm"], check=True)
    return ctypes.CDLL(str(library))


@pytest.fixture(scope="module")
def lanes(tmp_path_factory):
    return compiled(tmp_path_factory.mktemp("lanes"))


@pytest.fixture(scope="module")
def one_lane(tmp_path_factory):
    """Compiled as by a compiler without vector types."""
    return compiled(tmp_path_factory.mktemp("one_lane"), "-DGALLOP_ONE_LANE")


class Chain:
    """Random blocks, of which each element's diagonal ones dominate; n unknowns of a node."""

    def __init__(self, parts, elements, n):
        random = np.random.default_rng(100 * elements + 10 * n + parts)
        self.parts, self.elements, self.n, self.nodes = parts, elements, n, 2 * elements + 1
        self.block = random.uniform(-1.0, 1.0, (parts, elements, 6, n, n))
        self.block[0, :, [0, 3, 5]] += 4.0 * n * np.eye(n)
        self.loads = random.uniform(-1.0, 1.0, (self.nodes, parts, 4))
        self.loads[:, :, n:] = 0.0
        self.moved = random.uniform(-1.0, 1.0, (2, parts, 4))
        self.moved[:, :, n:] = 0.0

    def dense(self):
        """The tangent of all nodes."""
        value = self.numbers(self.block, axis=0)
        whole = np.zeros((self.nodes, self.n, self.nodes, self.n), value.dtype)
        for e in range(self.elements):
            pairs = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]
            for (a, b), block in zip(pairs, value[e], strict=True):
                whole[2 * e + a, :, 2 * e + b] += block
                if a != b:  # blocks (a, b) and (b, a) are equal
                    whole[2 * e + b, :, 2 * e + a] += block
        return whole.reshape(self.nodes * self.n, self.nodes * self.n)

    def numbers(self, values, axis):
        """Real or complex numbers, from an array with their parts along an axis."""
        parts = np.moveaxis(values, axis, 0)
        return parts[0] + 1j * parts[1] if self.parts == 2 else parts[0]

    def vector(self, values):
        """Unknowns of nodes (nodes, parts, 4), one after the other."""
        return self.numbers(values, axis=1)[:, : self.n].ravel()

    def size(self):
        return self.parts, self.elements, self.n, pointer(self.block)


def pointer(array):
    assert array.flags.c_contiguous
    return array.ctypes.data_as(ctypes.c_void_p)


SIZES = [
    (parts, elements, n) for parts in (1, 2) for n in (4, 2) for elements in (2, 3, 4, 5, 9, 40)
]


def solved(library, chain):
    fixed = np.zeros((2, 4), bool)
    fixed[0, 0] = fixed[1, 1] = True
    tangent = np.random.default_rng(1).uniform(-1.0, 1.0, (2, 2, 4, 4)) + 4.0 * np.eye(4)
    rhs = chain.loads.copy()
    good = library.solve(*chain.size(), pointer(fixed), pointer(tangent), pointer(rhs))
    assert good
    return rhs, fixed, tangent


def reduced(library, chain):
    ends, end_loads = np.empty((chain.parts, 2, 2, 4, 4)), np.empty((2, chain.parts, 4))
    rhs = chain.loads.copy()
    assert library.reduce(*chain.size(), *(pointer(y) for y in (ends, chain.moved, rhs, end_loads)))
    return ends, end_loads, rhs


@pytest.mark.parametrize(("parts", "elements", "n"), SIZES)
def test_solution_of_a_chain_alone(lanes, parts, elements, n):
    chain = Chain(parts, elements, n)
    rhs, fixed, tangent = solved(lanes, chain)
    whole, loads = chain.dense(), chain.vector(chain.loads)
    for end, node in ((0, 0), (1, chain.nodes - 1)):
        own = slice(node * n, node * n + n)
        whole[own, own] += chain.numbers(tangent[end], axis=0)[:n, :n]
        for i in range(n):
            row = node * n + i
            if fixed[end, i]:
                whole[row], loads[row] = np.eye(len(loads))[row], 0.0
    exact = np.linalg.solve(whole, loads)
    assert np.abs(chain.vector(rhs) - exact).max() < 1e-13 * np.abs(exact).max()
    assert not rhs[:, :, n:].any()


SINGLE = [(parts, 1, n) for parts in (1, 2) for n in (4, 2)]


@pytest.mark.parametrize(("parts", "elements", "n"), SIZES + SINGLE)
def test_reduction_to_both_ends(lanes, parts, elements, n):
    chain = Chain(parts, elements, n)
    ends, end_loads, rhs = reduced(lanes, chain)
    whole, loads = chain.dense(), chain.vector(chain.loads)
    outer = np.r_[:n, len(loads) - n : len(loads)]
    inner = np.arange(n, len(loads) - n)
    between = whole[np.ix_(inner, inner)]
    by_outer = np.linalg.solve(between, whole[np.ix_(inner, outer)])
    by_loads = np.linalg.solve(between, loads[inner])
    schur = whole[np.ix_(outer, outer)] - whole[np.ix_(outer, inner)] @ by_outer
    found = chain.numbers(ends, axis=0)[..., :n, :n].transpose(0, 2, 1, 3).reshape(2 * n, 2 * n)
    assert np.abs(found - schur).max() < 1e-13 * np.abs(schur).max()
    left = loads[outer] - whole[np.ix_(outer, inner)] @ by_loads
    assert np.abs(chain.vector(end_loads) - left).max() < 1e-13 * np.abs(left).max()
    moved = by_loads - by_outer @ chain.vector(chain.moved)
    assert np.abs(chain.vector(rhs)[inner] - moved).max() < 1e-13 * np.abs(moved).max()
    assert np.array_equal(rhs[[0, -1]], chain.moved)


@pytest.mark.parametrize(("parts", "elements", "n"), SIZES)
def test_same_result_without_vector_types(lanes, one_lane, parts, elements, n):
    chain = Chain(parts, elements, n)
    one, other = (
        (solved(library, chain)[0], *reduced(library, chain)) for library in (lanes, one_lane)
    )
    for x, y in zip(one, other, strict=True):
        assert np.abs(x - y).max() <= 1e-14 * np.abs(x).max()


@pytest.mark.parametrize("parts", [1, 2])
@pytest.mark.parametrize("block", [0, 3])
@pytest.mark.parametrize("bad", [-50.0, np.nan, np.inf])
def test_tangent_that_is_not_positive_definite_is_refused(lanes, parts, block, bad):
    chain = Chain(parts, 5, 4)
    chain.block[0, 4, block, 2, 2] = bad
    nothing = np.zeros((2, 2, 4, 4))
    fixed, rhs = np.zeros((2, 4), bool), chain.loads.copy()
    assert not lanes.solve(*chain.size(), pointer(fixed), pointer(nothing), pointer(rhs))
    assert np.array_equal(rhs, chain.loads)
