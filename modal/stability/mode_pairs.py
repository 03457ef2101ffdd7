"""Pairs of modes of a line near internal resonance: 2:1, and 1:1.

Let q_i be the coordinates of the mass-normalised modes p_i about the initial equilibrium, and V
the potential energy of conductors (strain energy and weight) and devices. Its third and fourth
derivatives along the modes,

    c_ijk = d3V/dq_i dq_j dq_k,    k_iijj = d4V/dq_i2 dq_j2,                                     (1)

couple them. For a conductor with the Green strain e = X'.u' + u'.u'/2 and the energy
int (T0 e + EA e2/2) dS they are, with the longitudinal strain e_i = X'.p_i' of a mode,

    c_ijk = int EA (e_i p_j'.p_k' + e_j p_i'.p_k' + e_k p_i'.p_j') dS,                           (2)
    k_iijj = int EA (p_i'.p_i' p_j'.p_j' + 2 (p_i'.p_j')2) dS;                                   (3)

for a vertical mode v and a horizontal mode h of a level span, e_h = 0 and c_vhh = int EA e_v
|h'|2 dS: the change of tension of v acts on the slope of h. The program takes c_ijk from
differences of the tangent stiffness along a mode, which include strings, spacers and ice, and
k_iijj from (3) and second differences of the tangents of the devices. Stiff strings and spacers
contribute large terms to (5) that cancel almost; differences are therefore of the fourth order.

**2:1.** Mode i moves as q_i = a cos W t. Then mode j obeys Mathieu's equation

    q_j'' + 2 xi w q_j' + w2 (1 + e cos W t) q_j = 0,    e = a c_ijj / w2.                       (4)

Near W = 2 w it starts above e = 4 sqrt(xi2 + D2), D = W / (2 w) - 1 (Nayfeh and Mook 1979, section
5.3). The *threshold* is this amplitude a, as displacement where the mode i is largest.

**1:1.** The quadratic forces of mode i move all others at zero frequency and at 2 W,

    z0 = -K^-1 f_ii / 4,    z2 = -(K - 4 W2 M)^-1 f_ii / 4    per a2,    f_ij = dK/dq_i p_j,

and those of i and j together move them by y0, y2: the same of f_ij, with 1/2 in place of 1/4. By
harmonic balance of the first order in q_j = P cos W t + Q sin W t, mode j has the squared frequency
w_j2 + a2 S_c in phase with i, and w_j2 + a2 S_s a quarter of a period apart from it,

    S_c = f_ij.(y0 + y2/2) + f_jj.(z0 + z2/2) + 3/8 k_iijj,                                      (5)
    S_s = f_ij.y2/2 + f_jj.(z0 - z2/2) + 1/8 k_iijj,

and mode i itself w_i2 + a2 S_i, S_i = f_ii.(z0 + z2/2) + k_iiii/8. Mode j starts where, with
s = w_j2 - w_i2,

    (s + a2 (S_c - S_i)) (s + a2 (S_s - S_i)) + (2 xi w_j2)2 = 0,                                (6)

the lowest positive a2; without one there is no threshold. (4) and (6) hold for small amplitudes:
changes of frequency with the amplitude are left out of (4).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import SceneError
from gallop_fmu.input.scene_like import LineLike, as_line
from modal.foundation.one_thread import one_thread
from modal.linear.line_modes import LineMode, line_modes
from modal.linear.linearise import Linearised, SmallMotion

if TYPE_CHECKING:
    from scipy.sparse import csc_array

Array = NDArray[np.float64]
Kind = Literal["2:1", "1:1"]

SEARCHED_MODES = 24
"""Default number of modes, the lowest ones."""

BANDS: dict[Kind, float] = {"2:1": 0.2, "1:1": 0.05}
"""Default relative distances from the resonance up to which a pair is listed."""

TANGENT_STEP = 1e-3
"""Largest displacement [m], or twist [rad], in differences of the tangent along a mode."""

DEVICE_STEP = 2e-3
"""The same in second differences of the tangents of devices."""

MIN_MODULATION = 1e-3
"""Relative change of stiffness per metre below which a pair is not coupled."""

MAX_SPEED_RATIO = 1.5
"""Largest ratio of the speed of galloping to the wind speed."""

MAX_SAG_RATIO = 1.2
"""Amplitude of galloping over the sag of a conductor as long as one loop, for scenes without wind.

Assumed: 1.43 m at a sag of 1.37 m in Example 2 of Liu et al. (2009); peak-to-peak amplitudes in the
field are 0.1 to 1 times the sag (CIGRE Technical Brochure 322).
"""

MAX_TWIST = 0.5
"""Amplitude [rad] that is assumed for galloping in a torsional mode."""

GALLOPING_FAMILIES = ("vertical", "tension-neutral", "torsional", "bundle torsion")
"""Families that wind excites by galloping."""


@dataclass(frozen=True)
class ModePair:
    """Two modes near internal resonance.

    Attributes
    ----------
    kind : str
        ``"2:1"``: the driving mode has twice the frequency of the driven one; ``"1:1"``: the same.
    driving, driven : int
        Numbers of the two modes from 1, in order of frequency.
    driving_mode, driven_mode : LineMode
        The modes.
    detuning : float
        Ratio of the frequencies, driving over driven, over 2 or 1, less 1.
    coupling : float
        Derivative c_ijj of the potential energy along the modes [1/(s2 m sqrt(kg))]: change of the
        squared frequency of the driven mode per coordinate of the driving one.
    modulation : float
        Relative change of the driven mode's stiffness per metre (or rad) of the driving mode.
    threshold : float or None
        Amplitude [m] of the driving mode, where it is largest, above which the driven mode starts;
        of a torsional driving mode the twist [rad]. None if it does not at any amplitude.
    largest_galloping : float
        Amplitude [m] that galloping in the driving mode may reach: 1.5 U/w in the scene's mean wind
        U; in a scene without wind, 1.2 times the sag of a conductor as long as one loop; 0.5 rad in
        a torsional mode. 0 if wind does not excite the family of the driving mode by galloping.
    matters : bool
        True if the threshold is at most `largest_galloping`.
    sentence : str
        The same as a sentence.
    """

    kind: Kind
    driving: int
    driven: int
    driving_mode: LineMode = field(repr=False)
    driven_mode: LineMode = field(repr=False)
    detuning: float
    coupling: float
    modulation: float
    threshold: float | None
    largest_galloping: float
    matters: bool
    sentence: str


class Expansion:
    """Derivatives of the potential energy of a line along its modes, about one equilibrium.

    Parameters
    ----------
    motion
        The line.
    equations
        Its equations of small motion in still air.
    modes
        Its modes.
    """

    def __init__(
        self, motion: SmallMotion, equations: Linearised, modes: Sequence[LineMode]
    ) -> None:
        self.mesh, self.equations, self.modes = motion.mesh, equations, modes
        leads = self.mesh.leader == np.arange(len(self.mesh.leader))
        self.kept = np.flatnonzero(equations.free)
        self.shapes = np.array([(mode.shape * leads[:, None]).ravel() for mode in modes])
        self._first: dict[int, csc_array] = {}

    def stiffness(self, u: Array) -> csc_array:
        """Tangent stiffness at a displacement (node, 4) from the initial equilibrium."""
        return self.mesh.tangent(u, stiffness=1.0, inputs=self.mesh.still)

    def first(self, mode: int) -> csc_array:
        """Derivative of the stiffness along a mode, by central differences of the fourth order.

        They are exact for the conductors, whose stiffness is quadratic in the displacement.
        """
        if mode not in self._first:
            step = TANGENT_STEP / self.modes[mode].largest
            near, far = (self._slope(mode, k * step) for k in (1.0, 2.0))
            self._first[mode] = (4.0 * near - far) / 3.0
        return self._first[mode]

    def _slope(self, mode: int, step: float) -> csc_array:
        moved = step * self.modes[mode].shape
        return (self.stiffness(moved) - self.stiffness(-moved)) / (2.0 * step)

    def quartic(self, i: int, j: NDArray[np.intp]) -> Array:
        """Derivatives k_iijj of equation (3) of the module, with those of the devices."""
        product = np.einsum("pk,jpk->jp", self._slopes[i], self._slopes[j])
        squares = np.einsum("jpk,jpk->jp", self._slopes[j], self._slopes[j])
        own = np.sum(self._slopes[i] ** 2, axis=1)
        conductors = (own * squares + 2.0 * product**2) @ self._weight
        if not self.mesh.model.devices:
            return np.asarray(conductors)
        step = DEVICE_STEP / self.modes[i].largest
        near, far = (self._device_curvature(i, k * step) for k in (1.0, 2.0))
        devices = (4.0 * near - far) / 3.0
        shapes = np.array([self.modes[k].shape.ravel() for k in j])
        return np.asarray(conductors + np.einsum("ja,aj->j", shapes, devices @ shapes.T))

    def _device_curvature(self, mode: int, step: float) -> csc_array:
        """Second difference of the tangents of the devices along a mode."""
        moved = step * self.modes[mode].shape
        ahead, here, back = (
            self.mesh.device_tangents(k * moved, stiffness=1.0, inputs=self.mesh.still)
            for k in (1.0, 0.0, -1.0)
        )
        return (ahead + back - 2.0 * here) / step**2

    @cached_property
    def _slopes(self) -> Array:
        """Derivatives of the modes by the arc length, shape (mode, point, 3)."""
        points = self.mesh.strain_points
        return np.array([points.slope(mode.shape)[:, :3] for mode in self.modes])

    @cached_property
    def _weight(self) -> Array:
        """Axial stiffness times length [N m] of each strain point."""
        stiffness = self.mesh.model.scene.conductor.axial_stiffness
        return stiffness * self.mesh.strain_points.length

    def response(self, omega: float, loads: Array) -> Array:
        """Amplitudes (load, 4 node) of the undamped line under harmonic loads [N, N m].

        Parameters
        ----------
        omega
            Angular frequency [rad/s].
        loads : ndarray, shape (load, 4 node)
            Amplitudes of the loads.
        """
        from scipy.sparse.linalg import splu

        mass, _, stiffness = self.equations.of_free()
        found = np.zeros_like(loads)
        found[:, self.kept] = (
            splu((stiffness - omega**2 * mass).tocsc()).solve(loads[:, self.kept].T).T
        )
        return found


@one_thread
def mode_pairs(
    scene: LineLike,
    count: int = SEARCHED_MODES,
    band: float = BANDS["2:1"],
    one_to_one_band: float = BANDS["1:1"],
) -> list[ModePair]:
    """Find the pairs of modes of a line near 2:1 and 1:1, with their coupling.

    Parameters
    ----------
    scene
        The line.
    count
        Number of modes, the lowest ones.
    band, one_to_one_band
        Relative distance of the frequency ratio from 2 and from 1 up to which a pair is listed.

    Returns
    -------
    list of ModePair
        First those that matter, then 2:1 before 1:1, then by the threshold over the amplitude that
        galloping may reach. Pairs that are not coupled are left out.

    Raises
    ------
    SceneError
        If a band is not a positive number, `count` is not possible, or the equilibrium is unstable.
    SimulationError
        If no initial equilibrium exists.
    """
    for name, width in (("band", band), ("one_to_one_band", one_to_one_band)):
        if not (np.isfinite(width) and 0.0 < width < 1.0):
            raise SceneError(f"{name} = {width}: must be greater than 0 and less than 1")
    line = as_line(scene, "mode_pairs", "use modal.frequency_ratio")
    motion = SmallMotion(line)
    equations = motion.in_still_air()
    modes = line_modes(equations, motion.mesh, count)
    expansion = Expansion(motion, equations, modes)
    limit = _GallopingLimit(line.wind.mean_speed, _largest_sag(expansion))
    frequency = np.array([mode.frequency_hz for mode in modes])
    found = []
    for i in range(len(modes)):
        two = np.flatnonzero(np.abs(frequency[i] / (2.0 * frequency) - 1.0) <= band)
        one = np.flatnonzero(np.abs(frequency[i] / frequency - 1.0) <= one_to_one_band)
        one = one[one != i]
        if len(two) or len(one):
            found += _driven_by(expansion, i, two, one, limit)
    return sorted(found, key=_order)


def _order(pair: ModePair) -> tuple[bool, bool, float, float]:
    """Place of a pair in the list."""
    severity = np.inf
    if pair.threshold is not None:
        severity = pair.threshold / (pair.largest_galloping or 1.0)
    return not pair.matters, pair.kind != "2:1", severity, abs(pair.detuning)


@dataclass(frozen=True)
class _GallopingLimit:
    """Largest amplitude of galloping in a mode.

    Attributes
    ----------
    wind_speed : float
        Mean wind speed of the scene [m/s].
    sag : float
        Largest sag [m].
    """

    wind_speed: float
    sag: float

    def of(self, mode: LineMode) -> float:
        """Amplitude [m, rad]; 0 if wind does not excite the family of the mode."""
        if mode.family not in GALLOPING_FAMILIES:
            return 0.0
        if mode.family == "torsional":
            return MAX_TWIST
        if self.wind_speed != 0.0:
            return MAX_SPEED_RATIO * abs(self.wind_speed) / _omega(mode)
        return MAX_SAG_RATIO * self.sag / max(mode.loops) ** 2


def _driven_by(
    expansion: Expansion,
    i: int,
    two: NDArray[np.intp],
    one: NDArray[np.intp],
    limit: _GallopingLimit,
) -> list[ModePair]:
    """Pairs in which mode i drives modes at half its frequency and at its frequency."""
    modes, shapes = expansion.modes, expansion.shapes
    first = expansion.first(i)
    pairs = []
    for j in two:
        coupling = float(shapes[j] @ (first @ shapes[j]))
        modulation = coupling / (_omega(modes[j]) ** 2 * modes[i].largest)
        if abs(modulation) < MIN_MODULATION:
            continue
        detuning = modes[i].frequency_hz / (2.0 * modes[j].frequency_hz) - 1.0
        damping = modes[j].damping_ratio
        threshold = 4.0 * float(np.hypot(damping, detuning)) / abs(modulation)
        pairs.append(_pair("2:1", i, int(j), modes, coupling, threshold, limit))
    if len(one):
        pairs += _one_to_one(expansion, i, one, first, limit)
    return pairs


def _one_to_one(
    expansion: Expansion, i: int, driven: NDArray[np.intp], first: csc_array, limit: _GallopingLimit
) -> list[ModePair]:
    """Pairs of mode i with modes at its frequency: equation (6) of the module."""
    modes, shapes = expansion.modes, expansion.shapes
    pairs = []
    for j, changes in zip(driven.tolist(), one_to_one_changes(expansion, i, driven), strict=True):
        squared = _omega(modes[j]) ** 2
        if abs(changes.in_phase - changes.quadrature) < (
            MIN_MODULATION * squared * modes[i].largest ** 2
        ):
            continue
        amplitude = _lowest_amplitude(
            squared - _omega(modes[i]) ** 2,
            changes.in_phase - changes.own,
            changes.quadrature - changes.own,
            2.0 * modes[j].damping_ratio * squared,
        )
        threshold = None if amplitude is None else amplitude * modes[i].largest
        coupling = float(shapes[j] @ (first @ shapes[j]))
        pairs.append(_pair("1:1", i, j, modes, coupling, threshold, limit))
    return pairs


class Changes(NamedTuple):
    """Changes of squared frequencies per squared coordinate of a mode [1/(s2 m2 kg)].

    Attributes
    ----------
    own : float
        Of the mode itself: S_i of the module.
    in_phase, quadrature : float
        Of another mode that moves in phase with it, or a quarter of a period apart: S_c and S_s.
    """

    own: float
    in_phase: float
    quadrature: float


def one_to_one_changes(expansion: Expansion, i: int, driven: NDArray[np.intp]) -> list[Changes]:
    """Compute equation (5) of the module for mode i and each of the other modes."""
    shapes = expansion.shapes
    first, quartic = expansion.first(i), expansion.quartic(i, np.array([i, *driven]))
    loads = (first @ shapes[[i, *driven]].T).T  # f_ii, then f_ij
    slow = expansion.response(0.0, loads)
    fast = expansion.response(2.0 * _omega(expansion.modes[i]), loads)
    z0, z2 = -0.25 * slow[0], -0.25 * fast[0]
    own = loads[0] @ (z0 + 0.5 * z2) + quartic[0] / 8.0
    found = []
    for k, j in enumerate(driven, start=1):
        of_j = expansion.first(int(j)) @ shapes[j]
        y0, y2 = -0.5 * slow[k], -0.5 * fast[k]
        in_phase = loads[k] @ (y0 + 0.5 * y2) + of_j @ (z0 + 0.5 * z2) + 0.375 * quartic[k]
        quadrature = 0.5 * loads[k] @ y2 + of_j @ (z0 - 0.5 * z2) + 0.125 * quartic[k]
        found.append(Changes(float(own), float(in_phase), float(quadrature)))
    return found


def _lowest_amplitude(apart: float, first: float, second: float, damping: float) -> float | None:
    """Lowest amplitude a with (s + a2 f) (s + a2 g) + d2 = 0; None if there is none."""
    roots = np.roots([first * second, apart * (first + second), apart**2 + damping**2])
    real = roots.real[(np.abs(roots.imag) <= 1e-12 * np.abs(roots)) & (roots.real > 0.0)]
    return float(np.sqrt(real.min())) if len(real) else None


def _pair(
    kind: Kind,
    i: int,
    j: int,
    modes: Sequence[LineMode],
    coupling: float,
    threshold: float | None,
    limit: _GallopingLimit,
) -> ModePair:
    driving, driven = modes[i], modes[j]
    ratio = 2.0 if kind == "2:1" else 1.0
    detuning = driving.frequency_hz / (ratio * driven.frequency_hz) - 1.0
    largest = limit.of(driving)
    return ModePair(
        kind=kind,
        driving=i + 1,
        driven=j + 1,
        driving_mode=driving,
        driven_mode=driven,
        detuning=detuning,
        coupling=coupling,
        modulation=coupling / (_omega(driven) ** 2 * driving.largest),
        threshold=threshold,
        largest_galloping=largest,
        matters=threshold is not None and threshold <= largest,
        sentence=_sentence(kind, i, j, modes, detuning, threshold, largest),
    )


def _sentence(
    kind: Kind,
    i: int,
    j: int,
    modes: Sequence[LineMode],
    detuning: float,
    threshold: float | None,
    largest: float,
) -> str:
    pair = (
        f"{kind}: {_named(i, modes[i])} and {_named(j, modes[j])},"
        f" {abs(detuning):.1%} {'above' if detuning > 0 else 'below'} {kind}"
    )
    if threshold is None:
        return f"{pair}: no amplitude of the first starts the second"
    unit = "rad" if modes[i].family == "torsional" else "m"
    start = f"{pair}: {threshold:.3g} {unit} of the first start the second"
    if largest == 0.0:
        return f"{start}, but wind does not excite the first by galloping"
    if threshold > largest:
        return f"{start}; galloping is assumed to reach {largest:.3g} {unit} at most"
    return f"{start}, and galloping may reach {largest:.3g} {unit}: this pair matters"


def _named(number: int, mode: LineMode) -> str:
    return f"mode {number + 1} ({mode.family}, {mode.frequency_hz:.4f} Hz)"


def _omega(mode: LineMode) -> float:
    return 2.0 * np.pi * mode.frequency_hz


def _largest_sag(expansion: Expansion) -> float:
    """Largest distance [m] of a conductor below its chord in the initial equilibrium."""
    model = expansion.mesh.model
    x = model.equilibrium().x
    sags = []
    for chain in model.map.chains:
        along, height = x[chain.nodes, 0], x[chain.nodes, 1]
        chord = np.interp(along, along[[0, -1]], height[[0, -1]])
        sags.append(float(np.max(chord - height)))
    return max(sags)
