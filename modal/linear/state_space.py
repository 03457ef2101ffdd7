r"""The span as a linear state-space model of python-control.

Let q be the free unknowns, p the displacements of the two supports, u the wind speed and a the
attack angle, all as differences from the static equilibrium in mean wind. They obey

    M q'' + C q' + K q = -Mp p'' - Cp p' - Kp p + bu u + ba a.

Mp, Cp, Kp are the columns of the prescribed ends; for an end on a spring k, -Kp is k and Mp, Cp
vanish. For the displacement p as input instead of its acceleration, let G = M^-1 Mp,
D = M^-1 (C G - Cp),

    r = q + G p,        w = r' - D p.

Then M r'' + C r' + K r = (K G - Kp) p + (C G - Cp) p' + ..., and the derivative of w includes the
term with p':

    r' = w + D p,
    w' = -M^-1 (K r + C w) + M^-1 (K G - Kp - C D) p + M^-1 (bu u + ba a),
    q  = r - G p,
    q' = w + D p - G p'.

This is exact. `linear_model` neglects the last term, by which a velocity responds to p' at once
because the mass matrix is consistent. G decays by a factor of about 6 from element to element and
is negligible at mid-span (6e-7 with 15 elements); a mesh on which it is more than a thousandth is
refused.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import control
import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Scene, SceneError
from gallop_fmu.input.scene_like import SceneLike, as_scene
from modal.foundation.one_thread import one_thread
from modal.linear.eigensolution import MIN_OSCILLATION, state_matrix
from modal.linear.line_modes import LineMode
from modal.linear.line_state_space import line_system
from modal.linear.linearise import Linearised, SmallMotion, linearised
from modal.linear.mode_tracking import EXTRA_MODES, Snapshot, follow
from modal.linear.modes import Mode, modes_of

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
"""Inputs of `linear_model`: differences from the mean [m/s], [rad], [m]."""

OUTPUTS = tuple(f"midspan_{name}" for name in (*UNKNOWNS, *VELOCITIES))
"""Outputs of `linear_model`: mid-span differences from the equilibrium [m, rad, m/s, rad/s]."""

MAX_FEEDTHROUGH = 1e-3
"""Largest share of a support's velocity in a mid-span velocity that is neglected."""

MIN_ELEMENTS = 8
"""Number of elements from which it is smaller."""


@one_thread
def linear_model(scene: SceneLike, modes: int | None = None) -> control.StateSpace:
    """Linearise a span or line about its equilibrium in mean wind, as a state-space model.

    Parameters
    ----------
    scene
        The span or line; a wind speed of 0 gives it in still air.
    modes
        Number of lowest modes, as pairs of real states; None keeps all unknowns, of a span only;
        a line needs a number. The contribution
        of the other modes at frequency zero is included as a direct term (static correction), so
        that the static gain is that of the full model. Its velocity is not included: velocities
        need more modes than displacements.

    Returns
    -------
    control.StateSpace
        Inputs `INPUTS`, outputs `OUTPUTS`, all as differences from the equilibrium. States of the
        full model: r and w of the module's text, which are displacement and velocity if the
        supports are at rest. States of a truncated model: in-phase and quadrature coordinate of
        each mode. A line has the names of its FMU with ``_`` for each dot: inputs ``wind_speed`` of
        all spans, ``span[1]_wind_speed``, ... which add to it, ``attack_angle``, ``tower[0]_x1``,
        ...; outputs ``span[1]_midspan_x2``, ... (displacement; ``theta`` is the rotation of a
        bundle), ``span[1]_midspan_v2``, ... and ``tower[0]_f1``, ...: the force on each tower,
        without the inertia and damping of what moves with it at once.

    Raises
    ------
    SceneError
        If there is no equilibrium in the mean wind or it is statically unstable, `modes` is not
        possible, or the mesh is too coarse for support motion as an input.

    Examples
    --------
    Poles, step response and frequency response by python-control:

    >>> import control, gallop_fmu as gf, modal
    >>> model = modal.linear_model(gf.load_scene("example3"), modes=6)
    >>> growing = [pole for pole in model.poles() if pole.real > 0 and pole.imag > 0]
    >>> len(growing)
    2
    >>> response = control.step_response(model["midspan_u3", "wind_speed"], 10.0)
    >>> response = control.frequency_response(model["midspan_u2", "attack_angle"], [1.0, 2.0])

    ``control.bode_plot(model["midspan_u2", "wind_speed"])`` draws.
    """
    scene = as_scene(scene)
    if isinstance(scene, LineScene):
        of_line = line_system(scene, modes)
        return control.ss(
            of_line.a,
            of_line.b,
            of_line.c,
            of_line.d,
            inputs=of_line.inputs,
            outputs=of_line.outputs,
            states=_mode_states(len(of_line.a) // 2),
            name="line",
        )
    equations = linearised(scene, "mean")
    modes_of(equations, scene, 1)  # raises if the equilibrium is statically unstable
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


@one_thread
def root_locus(scene: SceneLike, speeds: Sequence[float], count: int = 6) -> xr.Dataset:
    """Compute the eigenvalues of the lowest modes over the wind speed, tracked by shape.

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
    scene = as_scene(scene)
    motion = SmallMotion(scene)

    def at(speed: float) -> Snapshot:
        return Snapshot.of(motion, count + EXTRA_MODES, speed)

    here = at(speeds[0])
    chosen = np.arange(min(count, len(here.modes)))
    rows: list[Sequence[Mode | LineMode]] = [here.modes[: len(chosen)]]
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
    """State-space model of all free unknowns, with the matrices G and D of the module."""
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
    feedthrough = float(np.abs(g[middle]).max())
    if feedthrough > MAX_FEEDTHROUGH:
        raise SceneError(
            f"numerics.elements = {(len(equations.free) - 1) // 2}: on this mesh {feedthrough:.2g}"
            " of a support's velocity appears at once at mid-span, which a state-space model cannot"
            f" include (at most {MAX_FEEDTHROUGH:g}); set {MIN_ELEMENTS} or more elements"
        )
    names = (
        [f"{UNKNOWNS[k % 4]}_node{k // 4}" for k in free],
        [f"{VELOCITIES[k % 4]}_node{k // 4}" for k in free],
    )
    return _System(state_matrix(*equations.of_free()), b, c, through, [*names[0], *names[1]])


def _truncated(full: _System, count: int, scene: Scene) -> _System:
    """Reduce a model to its oscillating modes with the lowest |s|, with the static gain of all.

    x = 2 Re(right z) with z' = s z + left u; the real states are twice the real and the imaginary
    part of z.
    """
    values, right = np.linalg.eig(full.a)
    oscillating = np.flatnonzero(values.imag > MIN_OSCILLATION * np.abs(values))
    if isinstance(count, bool) or not isinstance(count, int) or not 1 <= count <= oscillating.size:
        raise SceneError(
            f"modes = {count}: must be a whole number from 1 to {oscillating.size}, the oscillating"
            f" modes of a mesh of {scene.elements} elements; None keeps all unknowns"
        )
    kept = oscillating[np.argsort(np.abs(values[oscillating]))][:count]
    left = np.linalg.solve(right, full.b)[kept]
    a, b = np.zeros((2 * count, 2 * count)), np.zeros((2 * count, full.b.shape[1]))
    c = np.zeros((full.c.shape[0], 2 * count))
    for m, k in enumerate(kept):
        s, pair = values[k], slice(2 * m, 2 * m + 2)
        driven, observed = 2.0 * left[m], full.c @ right[:, k]
        a[pair, pair] = [[s.real, -s.imag], [s.imag, s.real]]
        b[pair] = [driven.real, driven.imag]
        c[:, pair] = np.column_stack([observed.real, -observed.imag])
    names = _mode_states(count)
    small = _System(a, b, c, np.zeros_like(full.d), names)
    return _System(a, b, c, full.static_gain - small.static_gain, names)


def _mode_states(count: int) -> list[str]:
    return [f"mode{m + 1}_{part}" for m in range(count) for part in ("in_phase", "quadrature")]
