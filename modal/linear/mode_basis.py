"""An iced span at rest in still air: matrices and all modes from the kernel, and bases of a few shapes."""

from __future__ import annotations

from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Inputs, Model, Scene, SceneError
from modal.linear.modes import FAMILIES, Family, by_family

Array = NDArray[np.float64]

ELEMENTS = 16
"""Finest mesh that is reduced; finer ones change the amplitudes by less than 0.1 %."""

KEPT: dict[Family, int] = {"vertical": 3, "horizontal": 3, "torsional": 3}
"""Mode shapes of each family and symmetry, the lowest ones."""

PROBE = 1e-3
"""Step along a mode for differences of the tangent [modal coordinate]; the tangent is quadratic, so any will do."""

PARALLEL = 1e-3
"""Part of a shape outside the basis below which it adds nothing."""


@dataclass(frozen=True)
class Rest:
    """The model at rest in still air: element tangents and all natural modes, from the kernel."""

    model: Model
    frequencies: Array  # (mode,) rad/s
    shapes: Array  # (mode, node, 4), mass-normalised
    family: list[Family]
    symmetric: NDArray[np.bool_]
    mass: Array  # (4 nodes, 4 nodes)
    damping: Array
    stiffness: Array
    free: NDArray[np.bool_]  # (4 nodes,)

    def first(self, family: Family) -> int:
        """Number of the first symmetric mode of a family."""
        for number, (found, symmetric) in enumerate(zip(self.family, self.symmetric, strict=True)):
            if found == family and symmetric:
                return number
        raise SceneError(
            f"the span has no symmetric {family} mode on a mesh of {self.model.elements} elements"
        )


def assemble(elements: Array) -> Array:
    """Dense matrix (4 nodes, 4 nodes) of element matrices (element, 12, 12)."""
    size = 8 * len(elements) + 4
    total = np.zeros((size, size))
    for e, element in enumerate(elements):
        total[8 * e : 8 * e + 12, 8 * e : 8 * e + 12] += element
    return total


def at_rest(scene: Scene, elements: int = ELEMENTS) -> Rest:
    """Matrices and all modes about the initial equilibrium, on a mesh of at most so many elements."""
    from scipy.linalg import eigh

    if scene.numerics.elements > elements:
        coarse = scene.numerics.model_copy(update={"elements": elements})
        scene = scene.model_copy(
            update={"numerics": coarse}
        )  # a valid number: the check of a whole scene takes 10 ms
    model = Model(scene)
    air = Inputs.still(scene)
    springs = np.zeros((model.nodes, 4))
    free = np.ones((model.nodes, 4), dtype=np.bool_)
    for end, stiffness in zip((0, -1), model.equilibrium().support_stiffness, strict=True):
        springs[end, [0, 2]] = stiffness
        free[end] = springs[end] > 0.0
    mass = assemble(model.tangent(mass=1.0, inputs=air))
    damping = assemble(model.tangent(damping=1.0, inputs=air))
    stiffness = assemble(model.tangent(stiffness=1.0, inputs=air)) + np.diag(springs.ravel())
    kept = np.flatnonzero(free)
    squares, vectors = eigh(stiffness[np.ix_(kept, kept)], mass[np.ix_(kept, kept)])
    if squares[0] <= 0.0:
        raise SceneError(
            "the initial equilibrium is unstable, so it has no natural modes; see"
            " natural_modes(scene)"
        )
    shapes = np.zeros((len(squares), 4 * model.nodes))
    shapes[:, kept] = vectors.T
    parts = shapes.reshape(len(squares), model.nodes, 4)
    turned = by_family(scene, parts)
    masses = mass.reshape(model.nodes, 4, model.nodes, 4)
    energy = np.stack(
        [
            np.einsum("mi,ij,mj->m", turned[:, :, f], masses[:, f, :, f], turned[:, :, f])
            for f in range(4)
        ],
        axis=1,
    )
    dominant = np.argmax(energy, axis=1)
    mirror = turned[:, ::-1] * np.array([-1.0, 1.0, 1.0, 1.0])
    middle = np.sum(turned * mirror, axis=(1, 2))
    sign = np.sign(turned[np.arange(len(parts)), parts.shape[1] // 2, dominant] + 1e-12)
    return Rest(
        model, np.sqrt(squares), parts * sign[:, None, None], [FAMILIES[i] for i in dominant], middle > 0.0,
        mass, damping, stiffness, free.ravel(),
    )  # fmt: skip


def tension_derivative(rest: Rest, along: int) -> Array:
    """Derivative of the stiffness (4 nodes, 4 nodes) along a mode, from the kernel's tangent."""
    step = PROBE * rest.shapes[along]
    air = Inputs.still(rest.model.scene)
    ahead, back = (rest.model.tangent(u, stiffness=1.0, inputs=air) for u in (step, -step))
    return assemble((ahead - back) / (2.0 * PROBE))


def mirrored(scene: Scene) -> bool:
    """Whether the span is its own mirror image about mid-span."""
    return scene.span.height_difference == 0.0 and scene.supports.left == scene.supports.right


def choose(rest: Rest, symmetric: tuple[bool, ...]) -> list[int]:
    """Numbers of the lowest modes of each family and of the symmetry asked for."""
    chosen: list[int] = []
    for family, count in KEPT.items():
        for kind in symmetric:
            alike = [
                i for i, f in enumerate(rest.family) if f == family and rest.symmetric[i] == kind
            ]
            chosen += alike[:count]
    return chosen


def with_stretching(rest: Rest, chosen: list[int]) -> Array:
    """Chosen shapes, and the static answers to the tension that the pair sets up: orthonormal in the mass."""
    free = np.flatnonzero(rest.free)
    stiffness = rest.stiffness[np.ix_(free, free)]
    shapes = rest.shapes.reshape(len(rest.shapes), -1)
    loads = []
    families: tuple[Family, ...] = ("vertical", "horizontal")
    for family in families:
        change = tension_derivative(rest, rest.first(family))
        others = [i for i in chosen if rest.family[i] in ("vertical", "horizontal")]
        if family == "horizontal":
            others = [i for i in others if rest.family[i] == "horizontal"]
        loads += [change @ shapes[i] for i in others]
    answers = np.zeros((len(loads), shapes.shape[1]))
    answers[:, free] = np.linalg.solve(stiffness, np.array(loads)[:, free].T).T
    basis = list(shapes[chosen])
    for answer in answers:
        size = np.sqrt(answer @ rest.mass @ answer)
        for _ in range(2):  # twice is enough (Kahan)
            for known in basis:
                answer = answer - (known @ rest.mass @ answer) * known
        left = np.sqrt(answer @ rest.mass @ answer)
        if left > PARALLEL * size:
            basis.append(answer / left)
    return cast(Array, np.array(basis).reshape(len(basis), -1, 4))
