r"""The span as a linear state-space model, for control engineers: what linear theory says of galloping, and no more.

About the static equilibrium in mean wind the free unknowns q, the displacements p of the two tower
points, the wind speed u and the attack angle a obey, all as differences from that equilibrium,

    M q'' + C q' + K q = -Mp p'' - Cp p' - Kp p + bu u + ba a.

Mp, Cp, Kp are the columns of the ends that are held; where an end hangs on a spring k instead, -Kp
is k and Mp, Cp vanish. To have the displacement p as input, and not its acceleration, let G = M^-1
Mp, D = M^-1 (C G - Cp),

    r = q + G p,        w = r' - D p.

Then M r'' + C r' + K r = (K G - Kp) p + (C G - Cp) p' + ..., and the derivative of w takes up the
term with p':

    r' = w + D p,
    w' = -M^-1 (K r + C w) + M^-1 (K G - Kp - C D) p + M^-1 (bu u + ba a),
    q  = r - G p,
    q' = w + D p - G p'.

This is exact but for the last term: a velocity responds to p' at once, because the mass matrix is
consistent. G is the inertia of neighbours and decays by a factor of about 6 from element to
element, so at mid-span it is only a trace (6e-7 with 15 elements); `linear_model` leaves it out,
and refuses a mesh on which it is more than a thousandth.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import control
import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Scene, SceneError
from modal.linear.linearise import Linearised, SmallMotion, linearised
from modal.linear.mode_tracking import SPARE, Snapshot, follow
from modal.linear.modes import AT_REST, modes_of, state_matrix

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

UNKNOWNS = ("u1", "u2", "u3", "theta")
VELOCITIES = ("v1", "v2", "v3", "omega")

INPUTS = (
    "wind_speed",
    "attack_angle",
    *(f"support_{end}_x{i}" for end in ("left", "right") for i in (1, 2, 3)),
)
"""Inputs of `linear_model`: differences from the mean [m/s], [rad], [m]. python-control allows no dots in names."""

OUTPUTS = tuple(f"midspan_{name}" for name in (*UNKNOWNS, *VELOCITIES))
"""Outputs of `linear_model`: mid-span differences from the equilibrium [m, rad, m/s, rad/s]."""

DIRECT = 1e-3
"""Part of a support's velocity that may appear at once in a mid-span velocity and is left out."""


def linear_model(scene: Scene, modes: int | None = None) -> control.StateSpace:
    """The span, linearised about its equilibrium in mean wind (structure and aerodynamics), as a state-space model.

    Parameters
    ----------
    scene
        The span; a wind speed of 0 gives the span in still air.
    modes
        Number of lowest modes kept, as pairs of real states; None keeps all unknowns. What the
        other modes would add at frequency zero is kept as a direct term (static correction), so
        that the static gain is that of the full model. The velocity of that quasi-static part
        cannot be kept: velocities need more modes than displacements.

    Returns
    -------
    control.StateSpace
        Inputs `INPUTS`, outputs `OUTPUTS`, all as differences from the equilibrium. States: of the
        full model r and w of the module's text, which are displacement and velocity where supports
        stand still; of a truncated one the in-phase and quadrature coordinates of each mode.

    Raises
    ------
    SceneError
        If there is no equilibrium in the mean wind or it is statically unstable, `modes` is not
        possible, or the mesh is too coarse for support motion as an input.

    Examples
    --------
    Poles, Bode and step response are python-control's own:

    >>> import control, gallop_fmu as gf, modal
    >>> model = modal.linear_model(gf.load_scene("example3"), modes=6)
    >>> growing = [pole for pole in model.poles() if pole.real > 0 and pole.imag > 0]
    >>> len(growing)
    2
    >>> response = control.step_response(model["midspan_u3", "wind_speed"], 10.0)
    >>> magnitude, phase, omega = control.frequency_response(model["midspan_u2", "attack_angle"], [1.0, 2.0])

    ``control.bode_plot(model["midspan_u2", "wind_speed"])`` draws.
    """
    equations = linearised(scene, "mean")
    modes_of(equations, scene, 1)  # refuses a statically unstable equilibrium
    full = _full_order(equations)
    if modes is not None:
        full = _truncated(full, modes, scene)
    return control.ss(
        full.a,
        full.b,
        full.c,
        full.d,
        inputs=list(INPUTS),
        outputs=list(OUTPUTS),
        states=full.states,
        name="span",
    )


def root_locus(scene: Scene, speeds: Sequence[float], count: int = 6) -> xr.Dataset:
    """Eigenvalues of the lowest modes as the wind speed rises, each followed by its shape.

    Parameters
    ----------
    scene
        The span; its own wind speed does not matter.
    speeds
        Wind speeds [m/s], increasing, 0 or more.
    count
        Number of modes, the lowest at the first speed.

    Returns
    -------
    xarray.Dataset
        Over ``mode`` and ``wind_speed`` [m/s]: complex ``eigenvalue`` [1/s], ``frequency_hz`` [Hz],
        ``damping_ratio``; over ``mode``: ``family`` at the first speed.

    Raises
    ------
    SceneError
        If the speeds are not in order, or one has no equilibrium.
    """
    import xarray as xr

    if len(speeds) == 0 or speeds[0] < 0.0 or any(high <= low for low, high in pairwise(speeds)):
        raise SceneError("speeds: must be one or more increasing wind speeds, 0 m/s or more")
    motion = SmallMotion(scene)

    def at(speed: float) -> Snapshot:
        return Snapshot.of(motion, count + SPARE, speed)

    here = at(speeds[0])
    chosen = np.arange(min(count, len(here.modes)))
    rows = [here.modes[: len(chosen)]]
    for low, high in pairwise(speeds):
        there = at(high)
        chosen, _ = follow(here, chosen, there, at, low, high)
        rows.append([there.modes[k] for k in chosen])
        here = there
    over = ("mode", "wind_speed")
    return xr.Dataset(
        {
            "eigenvalue": (
                over,
                np.array([[m.eigenvalue for m in row] for row in rows]).T,
                {"units": "1/s"},
            ),
            "frequency_hz": (
                over,
                np.array([[m.frequency_hz for m in row] for row in rows]).T,
                {"units": "Hz"},
            ),
            "damping_ratio": (
                over,
                np.array([[m.damping_ratio for m in row] for row in rows]).T,
                {"units": "1"},
            ),
            "family": ("mode", [mode.family for mode in rows[0]]),
        },
        coords={
            "wind_speed": ("wind_speed", np.asarray(speeds, dtype=np.float64), {"units": "m/s"})
        },
        attrs={"title": scene.title},
    )


@dataclass(frozen=True)
class _System:
    """x' = a x + b u, y = c x + d u."""

    a: Array
    b: Array
    c: Array
    d: Array
    states: list[str]

    @property
    def static_gain(self) -> Array:
        return np.asarray(self.d - self.c @ np.linalg.solve(self.a, self.b))


def _full_order(equations: Linearised) -> _System:
    free = np.flatnonzero(equations.free)
    mass, damping, stiffness = (part.toarray() for part in equations.of_free())
    n = free.size
    ends = np.concatenate([np.arange(3), equations.free.size - 4 + np.arange(3)])
    springs = equations.spring.ravel()
    hung = springs > 0.0

    def driven(matrix: Array) -> Array:
        return np.where(hung, 0.0, matrix)

    mass_p, damping_p, stiffness_p = (
        driven(part[free][:, ends].toarray())
        for part in (equations.mass, equations.damping, equations.stiffness)
    )
    stiffness_p[np.searchsorted(free, ends[hung]), np.flatnonzero(hung)] = -springs[hung]

    g = np.linalg.solve(mass, mass_p)
    d = np.linalg.solve(mass, damping @ g - damping_p)
    force = stiffness @ g - stiffness_p - damping @ d
    b = np.zeros((2 * n, len(INPUTS)))
    loads = np.column_stack([equations.by_wind[free], equations.by_attack_angle[free], force])
    b[:n, 2:] = d
    b[n:] = np.linalg.solve(mass, loads)

    c, through = np.zeros((len(OUTPUTS), 2 * n)), np.zeros((len(OUTPUTS), len(INPUTS)))
    middle = np.searchsorted(free, 4 * equations.middle + np.arange(4))
    c[np.arange(4), middle] = 1.0
    c[4 + np.arange(4), n + middle] = 1.0
    through[:4, 2:] = -g[middle]
    through[4:, 2:] = d[middle]
    at_once = float(np.abs(g[middle]).max())
    if at_once > DIRECT:
        raise SceneError(
            f"numerics.elements = {(len(equations.free) - 1) // 2}: on this mesh {at_once:.2g} of a"
            " support's velocity appears at once at mid-span, which a state-space model cannot"
            f" hold (at most {DIRECT:g}); take 8 or more"
        )
    names = (
        [f"{UNKNOWNS[k % 4]}_node{k // 4}" for k in free],
        [f"{VELOCITIES[k % 4]}_node{k // 4}" for k in free],
    )
    return _System(state_matrix(*equations.of_free()), b, c, through, [*names[0], *names[1]])


def _truncated(full: _System, count: int, scene: Scene) -> _System:
    """The oscillating modes with the lowest |s| in real coordinates, and the static gain of the rest."""
    values, right = np.linalg.eig(full.a)
    oscillating = np.flatnonzero(values.imag > AT_REST * np.abs(values))
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= oscillating.size:
        raise SceneError(
            f"modes = {count}: must be a whole number from 1 to {oscillating.size}, the oscillating"
            f" modes of a mesh of {scene.numerics.elements} elements; None keeps all unknowns"
        )
    kept = oscillating[np.argsort(np.abs(values[oscillating]))][:count]
    left = np.linalg.solve(right, full.b)[kept]  # of the inputs on each mode
    # x = 2 Re(right z) with z' = s z + left u; the real states are twice the real and the imaginary
    # part of z
    a, b = np.zeros((2 * count, 2 * count)), np.zeros((2 * count, full.b.shape[1]))
    c = np.zeros((full.c.shape[0], 2 * count))
    for m, k in enumerate(kept):
        s, pair = values[k], slice(2 * m, 2 * m + 2)
        driven, seen = 2.0 * left[m], full.c @ right[:, k]
        a[pair, pair] = [[s.real, -s.imag], [s.imag, s.real]]
        b[pair] = [driven.real, driven.imag]
        c[:, pair] = np.column_stack([seen.real, -seen.imag])
    names = [f"mode{m + 1}_{part}" for m in range(count) for part in ("in_phase", "quadrature")]
    small = _System(a, b, c, np.zeros_like(full.d), names)
    return _System(a, b, c, full.static_gain - small.static_gain, names)
