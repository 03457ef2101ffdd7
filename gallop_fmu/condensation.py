r"""A span condensed to a few modes, with the tension constant along it.

Derivation.  S is the arc length of the initial equilibrium X(S), a prime d/dS, c = X1' the cosine of its slope.  Axial
inertia is left out, so the horizontal tension H = T p1 is the same along the span.  With the strain
``X'.u' + u'.u'/2`` and springs k_l, k_r along x1 at the ends it follows, to second order in the slopes u',

    H = H0 + k (e + Q),       1/k = 1/k_c + 1/k_l + 1/k_r,    1/k_c = int dS / (EA c^2),
    e = int X2' u2' / c dS,   Q = 1/2 int (u2'^2 / c^3 + u3'^2 / c) dS,

where u1' = - X2' u2' / c of the static longitudinal motion is in the c^3 of Q.  The energy k (e + Q)^2 / 2 gives the
linear stiffness k e e, and the quadratic and cubic forces.  (Irvine's theory is its limit for a shallow parabola, rigid
ends and e alone.)

Modes.  Everything linear is the element's: mass, damping and stiffness matrices come from its mesh, the longitudinal
displacements follow statically (their mass is kept), the lowest shapes of vertical, horizontal and twisting motion
alone form a basis, in which the coupled eigenvalue problem is solved: eccentric ice couples the three.

The vertical shapes that are left out answer statically to the pull k Q: with their e_i and frequencies w_i the tension
becomes H0 + k (e + r Q), r = 1 - k sum e_i^2 / w_i^2, and the energy's last part k r Q^2 / 2.  In a slack span, whose
low modes hardly stretch, little of 1 is left in r.

Damping.  The element's Rayleigh damping is built once from the initial state, so it damps the strain that is linear in
the displacements, which differs from the true one by s = (u2'^2/c^2 + u3'^2)/2.  Quasi-statically its rate is
dH/dt / EA - ds/dt, which costs the power b2 EA int (dH/dt / EA - ds/dt)^2 dS.  Its linear part is in the matrix; the
rest is small for rigid ends, but takes a tenth off the amplitude of large galloping between longitudinal springs.

Wind and ice.  The full quasi-steady load with the scene's coefficient curve, and the turned ice's inertia and weight,
at eight Gauss sections of the span.

Error.  Against the element (`benchmarks/condensed.md`), steady amplitudes of Examples 2 and 3 of Liu et al. (2009)
differ by less than 1 %, the swing at half the frequency included; of ten drawn scenes that gallop, the vertical
amplitude by at most 2 % in eight and 4 % in all, the horizontal one by at most 4 % in six of seven that exceed 5 mm; in
galloping of 4 m it is 13 % off.  Where a swing comes and goes for ever, as in Example 3 with sags of 0.019 to 0.021 of
the span in 7 m/s, the amplitudes of one stretch of time say nothing of the other's.  With a sag above 0.024 of the
span the modes left out take part: 10 to 30 %, and such spans are refused.  The ends of the curve's range are watched at
the sections, of which none is at mid-span, so that a growing motion leaves it some seconds later than in the element.

In time the linear part of each mode is exact, the rest is integrated by an exponential Runge-Kutta scheme of order four
(Cox, Matthews 2002, J. Comput. Phys. 176, 430-455).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu.condensed_engine import CONDENSED_MODES, CONDENSED_SECTIONS
from gallop_fmu.engine import Inputs, Model
from gallop_fmu.errors import SceneError
from gallop_fmu.laws import Harmonic, Law
from gallop_fmu.scene import Scene

Array = NDArray[np.float64]

VERTICAL, HORIZONTAL, TORSIONAL = 7, 4, 5
"""Shapes of each direction, the lowest ones, symmetric and antisymmetric."""

ELEMENTS = 12
"""Finest mesh that is condensed: against 15 elements the first frequencies of the paper's examples differ by 1e-5."""

DEEPEST_SAG = 0.024
STEEPEST_CHORD = 0.5
"""Sag and height difference over the span's length up to which a scene is accepted: beyond, errors exceed 5 %."""


@dataclass(frozen=True)
class CondensedSpan:
    """A span in the coordinates of its coupled modes; arrays are padded with empty modes to 16.

    Attributes
    ----------
    model : Model
        The element model that was condensed.
    frequency_hz : ndarray, shape (mode,)
        Natural frequencies [Hz] of the modes that are not empty.
    shapes : ndarray, shape (16, node, 4)
        Displacements u1, u2, u3, theta per unit coordinate at the model's nodes.
    values : dict
        What the kernel needs, by the names of ``gallop_condensed``; without the time step.
    start : ndarray, shape (16,)
        Coordinates of the scene's initial seed.
    """

    model: Model
    frequency_hz: Array
    shapes: Array
    values: dict[str, float | Array]
    start: Array

    @property
    def vertical_hz(self) -> float:
        """Frequency [Hz] of the mode that moves mid-span most, up or down."""
        middle = np.abs(self.shapes[: len(self.frequency_hz), self.model.middle, 1])
        return float(self.frequency_hz[np.argmax(middle > 0.5 * middle.max())])

    def horizontal_tension(self, q: Array) -> float:
        """H0 + k (e + r Q) [N] at the coordinates q."""
        number = self.values
        square = 0.5 * q @ number["stretch"] @ q
        elongation = number["elongation"] @ q + number["remaining"] * square
        return float(number["horizontal_tension"] + number["stiffness"] * elongation)


def condense(scene: Scene) -> CondensedSpan:
    """Reduce a span to its lowest modes.

    Raises
    ------
    SceneError
        If the scene is outside the range of the condensed model; the message says why.
    SimulationError
        If no initial equilibrium exists.
    """
    _check_scene(scene)
    if scene.numerics.elements > ELEMENTS:
        coarse = scene.numerics.model_copy(update={"elements": ELEMENTS})
        scene = scene.model_copy(update={"numerics": coarse})
    model = Model(scene)
    rest = model.equilibrium()
    if rest.sag > DEEPEST_SAG * scene.span.length:
        raise SceneError(
            _refused(f"its sag is {rest.sag / scene.span.length:.3f} of its length, above {DEEPEST_SAG:g}")
        )
    air = Inputs(time=0.0, wind_speed=0.0, attack_angle=0.0, support=np.zeros((2, 3)))
    mass, damping, stiffness = (model.tangent(**{name: 1.0}, inputs=air) for name in ("mass", "damping", "stiffness"))
    basis, left_out, left_out_squares, lowest_left_out = _basis(model, mass, stiffness)
    squares, vectors = _eigen(_projected(stiffness, basis) + _springs(model, basis), _projected(mass, basis))
    if squares[0] <= 0.0:
        raise SceneError(_refused("its initial equilibrium is unstable"))
    _check_laws(scene, lowest_left_out)
    empty = CONDENSED_MODES - len(squares)
    shapes = np.einsum("bk,bni->kni", vectors, basis)
    shapes = np.concatenate([shapes, np.zeros((empty, *shapes.shape[1:]))])
    coupling = _projected(damping, shapes)
    values: dict[str, float | Array] = {
        "horizontal_tension": rest.horizontal_tension,
        "damping_time": rest.translation_damping[1],
        "frequency": np.concatenate([np.sqrt(squares), np.ones(empty)]),
        "damping": np.diag(coupling),
        "coupling": coupling - np.diag(np.diag(coupling)),
        **_stretching(model, shapes, left_out, left_out_squares),
        **_at_sections(model, shapes),
        "load": _loads(model, shapes),
    }
    start = scene.initial
    wave = np.sin(np.pi * rest.x[:, 0] / scene.span.length)
    seed = wave[:, None] * [0.0, start.seed_vertical, start.seed_horizontal, start.seed_twist]
    q = np.einsum("kei,eij,ej->k", _by_element(shapes), mass, _by_element(seed[None])[0])
    return CondensedSpan(model, np.sqrt(squares) / (2.0 * np.pi), shapes, values, q)


def _refused(reason: str) -> str:
    return f"the condensed model does not take this span: {reason}; use simulate(scene)"


def _check_scene(scene: Scene) -> None:
    rise = abs(scene.span.height_difference)
    if rise > STEEPEST_CHORD * scene.span.length:
        raise SceneError(
            _refused(
                f"span.height_difference is {rise / scene.span.length:.3f} of its length, above {STEEPEST_CHORD:g}"
            )
        )
    for name in ("left", "right"):
        motion = getattr(scene.supports, name).motion
        if motion is not None and any(getattr(motion, axis) is not None for axis in ("x1", "x2", "x3")):
            raise SceneError(_refused(f"supports.{name}.motion moves a tower, and towers stand still in it"))
    for index, load in enumerate(scene.loads):
        if load.force[0] != 0.0:
            raise SceneError(_refused(f"loads.{index}.force pulls along the span, where its tension is constant"))


def _check_laws(scene: Scene, lowest_left_out: float) -> None:
    """Refuse excitation that the modes left out would answer to."""
    laws: dict[str, Law | None] = {f"loads.{index}.law": load.law for index, load in enumerate(scene.loads)}
    laws["wind.history"] = scene.wind.history
    for name, law in laws.items():
        if isinstance(law, Harmonic) and law.frequency_hz > 0.5 * lowest_left_out:
            limit = f"above {0.5 * lowest_left_out:.3f} Hz, half of the lowest frequency that it leaves out"
            raise SceneError(_refused(f"{name}.frequency_hz = {law.frequency_hz} Hz is {limit}"))


def _eigen(stiffness: Array, mass: Array) -> tuple[Array, Array]:
    """Squares of the natural frequencies [1/s2] and mass-normalised vectors (row, mode)."""
    inverse = np.linalg.inv(np.linalg.cholesky(mass))
    squares, vectors = np.linalg.eigh(inverse @ stiffness @ inverse.T)
    return squares, inverse.T @ vectors


def _by_element(shapes: Array) -> Array:
    """Nodal values (mode, node, 4) as (mode, element, 12)."""
    return np.concatenate([shapes[:, 0:-2:2], shapes[:, 1:-1:2], shapes[:, 2::2]], axis=2)


def _projected(elements: Array, shapes: Array) -> Array:
    """Modal matrix of element matrices (element, 12, 12)."""
    u = _by_element(shapes)
    return np.asarray(np.einsum("kei,eij->kej", u, elements).reshape(len(u), -1) @ u.reshape(len(u), -1).T)


def _springs(model: Model, shapes: Array) -> Array:
    """Modal stiffness of the supports' springs."""
    ends = shapes[:, [0, -1]][:, :, [0, 2]]
    return np.asarray(np.einsum("kei,ei,lei->kl", ends, model.equilibrium().support_stiffness, ends))


def _block(elements: Array, row: int, column: int) -> Array:
    """Matrix (node, node) of one unknown's forces by another's displacements."""
    total = np.zeros((2 * len(elements) + 1,) * 2)
    for e, element in enumerate(elements):
        total[2 * e : 2 * e + 3, 2 * e : 2 * e + 3] += element[row::4, column::4]
    return total


def _basis(model: Model, mass: Array, stiffness: Array) -> tuple[Array, Array, Array, float]:
    """Lowest shapes (mode, node, 4) of each direction alone; u1 follows statically.

    Also the vertical shapes left out, the squares of their frequencies [1/s2], and the lowest frequency [Hz] of any
    translation left out.
    """
    springs = model.equilibrium().support_stiffness
    inner = np.arange(1, model.nodes - 1)
    free = [inner] * 4
    for unknown, column in ((0, 0), (2, 1)):
        left, right = springs[:, column] > 0.0
        free[unknown] = np.arange(0 if left else 1, model.nodes - (0 if right else 1))
    along = _block(stiffness, 0, 0)
    along[[0, -1], [0, -1]] += springs[:, 0]
    inverse = np.linalg.inv(along[np.ix_(free[0], free[0])])
    shapes, lowest = [], math.inf
    for unknown, count in ((1, VERTICAL), (2, HORIZONTAL), (3, TORSIONAL)):
        own = np.ix_(free[unknown], free[unknown])
        pull = _block(stiffness, 0, unknown)[np.ix_(free[0], free[unknown])]
        follow = -inverse @ pull
        k, m = _block(stiffness, unknown, unknown), _block(mass, unknown, unknown)
        if unknown == 2:
            k[[0, -1], [0, -1]] += springs[:, 1]
        heavy = _block(mass, 0, 0)[np.ix_(free[0], free[0])]
        squares, vectors = _eigen(k[own] + pull.T @ follow, m[own] + follow.T @ heavy @ follow)
        every = np.zeros((len(squares), model.nodes, 4))
        every[:, free[unknown], unknown] = vectors.T
        every[:, free[0], 0] = (follow @ vectors).T
        shapes.append(every[:count])
        if unknown != 3:
            lowest = min(lowest, math.sqrt(squares[count]) / (2.0 * math.pi) if len(squares) > count else math.inf)
        if unknown == 1:
            left_out, left_out_squares = every[count:], squares[count:]
    return np.concatenate(shapes), left_out, left_out_squares, lowest


class Interpolated(NamedTuple):
    """Shapes at points of the mesh."""

    shape: Array  # (point, mode, component)
    slope: Array  # (point, mode, component), by S
    tangent: Array  # (point, 3): X'
    length: Array  # (point,): dS by the fraction of the mesh


def interpolated(model: Model, shapes: Array, fraction: Array, side: float = 0.0) -> Interpolated:
    """Nodal values (mode, node, component) at fractions of the mesh; between elements `side` leans to one of them."""
    where = np.asarray(fraction) * model.elements
    e = np.clip(np.floor(where + side).astype(int), 0, model.elements - 1)
    xi = (2.0 * (where - e) - 1.0)[:, None]
    values = np.hstack([0.5 * xi * (xi - 1.0), 1.0 - xi**2, 0.5 * xi * (xi + 1.0)])
    slopes = np.hstack([xi - 0.5, -2.0 * xi, xi + 0.5])
    nodes = 2 * e[:, None] + np.arange(3)
    moves = shapes[:, nodes]
    tangent = np.einsum("pn,pni->pi", slopes, model.equilibrium().x[nodes])
    stretch = np.linalg.norm(tangent, axis=1, keepdims=True)
    shape, slope = (np.einsum("pn,kpni->pki", part, moves) for part in (values, slopes / stretch))
    return Interpolated(shape, slope, tangent / stretch, 2.0 * model.elements * stretch[:, 0])


def _stretching(model: Model, shapes: Array, left_out: Array, squares: Array) -> dict[str, float | Array]:
    """k, r, e and G of the derivation, at the element's Gauss points."""
    gauss = (0.5 + np.array([-0.5, 0.5]) / math.sqrt(3.0) + np.arange(model.elements)[:, None]).ravel() / model.elements
    at = interpolated(model, shapes, gauss)
    c, length = at.tangent[:, 0], at.length / len(gauss)
    by_slope = length * at.tangent[:, 1] / c
    flexibility = conductor = float(np.sum(length / c**2)) / model.scene.conductor.axial_stiffness
    flexibility += sum(1.0 / k for k in model.equilibrium().support_stiffness[:, 0] if k > 0.0)
    answering = by_slope @ interpolated(model, left_out, gauss).slope[:, :, 1]
    vertical, horizontal = at.slope[:, :, 1], at.slope[:, :, 2]
    return {
        "stiffness": 1.0 / flexibility,
        "share": conductor / flexibility,
        "remaining": 1.0 - float(np.sum(answering**2 / squares)) / flexibility,
        "elongation": by_slope @ vertical,
        "stretch": vertical.T @ (vertical * (length / c**3)[:, None])
        + horizontal.T @ (horizontal * (length / c)[:, None]),
    }


def _at_sections(model: Model, shapes: Array) -> dict[str, float | Array]:
    """Shapes and slopes at Gauss sections, alone and times what an integral over the span needs."""
    point, weight = np.polynomial.legendre.leggauss(CONDENSED_SECTIONS)
    shape, slope, tangent, per = interpolated(model, shapes, 0.5 * (point + 1.0))
    length = 0.5 * weight * per
    moves = np.moveaxis(shape[:, :, 1:], 2, 0)  # (component, section, mode)
    slopes = np.stack([slope[:, :, 1] / tangent[:, :1], slope[:, :, 2]])
    stress = model.equilibrium().translation_damping[1] * model.scene.conductor.axial_stiffness
    return {
        "shape": np.swapaxes(moves, 1, 2),
        "weighted": moves * length[:, None],
        "slope": np.swapaxes(slopes, 1, 2),
        "slope_weighted": slopes * (stress * length)[:, None],
    }


def _loads(model: Model, shapes: Array) -> Array:
    """Modal forces (load, mode) of each load at amplitude factor 1."""
    rows = np.zeros((len(model.scene.loads), len(shapes)))
    edges = np.arange(model.elements + 1) / model.elements
    middles = (np.arange(model.elements) + 0.5) / model.elements
    reached = np.append(0.0, np.cumsum(interpolated(model, shapes, middles).length)) / model.elements
    for row, load in zip(rows, model.scene.loads, strict=True):
        count = load.evenly_spaced or 0
        places = [load.position] if load.position is not None else np.arange(1, count + 1) / (count + 1)
        fraction = np.interp(np.array(places) * reached[-1], reached, edges)
        row += np.einsum("pki,i->k", interpolated(model, shapes, fraction).shape, [*load.force, load.torque])
    return rows
