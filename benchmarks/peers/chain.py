"""The span as a chain of two-node elements, compiled by numba: the model that the peers share.

Engineering strain on equal rest lengths, chosen so that the sag of the mesh is the scene's.  Arrays
of nodes are (3, nodes), so that loops over them vectorise.  Mass is lumped at the nodes, or
consistent with linear shape functions.
"""

from __future__ import annotations

from collections import namedtuple

import numba
import numpy as np
from scenes import INTERVAL, LOADED_POINTS, Array, Problem
from scipy.optimize import root

Chain = namedtuple(
    "Chain",
    "position rest stiffness node_mass weight load rise fall_start fall damping"
    " wind pressure attack_angle lift drag tributary normal consistent",
)
"""Input of the compiled functions.

`pressure` is rho d / 2, `tributary` the initial length [m] at each node, `normal` (2, nodes) the
direction (x1, x2) across the conductor in the plane of the span.
"""


def equilibrium(problem: Problem, elements: int) -> tuple[Array, float, float]:
    """Node positions (3, nodes), rest length [m] and mass [kg] of an element, from the bar forces.

    The scene's mass counts per metre of the hanging cable, not per metre of rest length.
    """
    below = 0.5 * (elements - 1) - np.arange(elements)

    def pieces(unknown: Array) -> Array:
        horizontal, rest, mass = unknown * scale
        vertical = mass * problem.gravity * below
        tension = np.hypot(horizontal, vertical)
        length = rest * (1.0 + tension / problem.axial_stiffness)
        return np.array([length * horizontal / tension, -length * vertical / tension])

    def gap(unknown: Array) -> Array:
        dx, dy = pieces(unknown)
        mass = problem.mass * np.hypot(dx, dy).sum() / elements
        drop = -dy[: elements // 2].sum()
        return (
            np.array(
                [dx.sum() / problem.length, drop / problem.sag, mass / (unknown[2] * scale[2])]
            )
            - 1.0
        )

    parabola = problem.mass * problem.gravity * problem.length**2 / (8.0 * problem.sag)
    scale = np.array(
        [parabola, problem.length / elements, problem.mass * problem.length / elements]
    )
    found = root(gap, np.ones(3), tol=1e-14)
    assert np.abs(gap(found.x)).max() < 1e-12, found.message
    x = np.concatenate([np.zeros((2, 1)), np.cumsum(pieces(found.x), axis=1)], axis=1)
    _, rest, mass = found.x * scale
    return np.array([x[0], x[1], np.zeros(elements + 1)]), float(rest), float(mass)


def chain(problem: Problem, elements: int = LOADED_POINTS + 1, consistent: bool = False) -> Chain:
    """The chain of a scene; the loaded points are nodes of every mesh."""
    position, rest, mass = equilibrium(problem, elements)
    loaded = np.zeros(elements + 1)
    loaded[:: elements // (LOADED_POINTS + 1)] = 1.0
    lengths = np.linalg.norm(np.diff(position, axis=1), axis=0)
    tributary = np.zeros(elements + 1)
    tributary[:-1] += 0.5 * lengths
    tributary[1:] += 0.5 * lengths
    wind = problem.wind
    chords = np.diff(position, axis=1)
    tangent = np.zeros((2, elements + 1))
    tangent[:, :-1] += chords[:2]
    tangent[:, 1:] += chords[:2]
    tangent /= np.linalg.norm(tangent, axis=0)
    return Chain(
        position=position,
        rest=rest,
        stiffness=problem.axial_stiffness,
        node_mass=mass,
        weight=mass * problem.gravity,
        load=np.outer(problem.load, loaded),
        rise=problem.law.rise,
        fall_start=problem.law.fall_start,
        fall=problem.law.fall,
        damping=problem.mass_damping,
        wind=wind.speed if wind else 0.0,
        pressure=0.5 * wind.density * wind.diameter if wind else 0.0,
        attack_angle=wind.attack_angle - wind.centre if wind else 0.0,
        lift=_cubic(wind.lift if wind else ()),
        drag=_cubic(wind.drag if wind else ()),
        tributary=tributary,
        normal=np.array([-tangent[1], tangent[0]]),
        consistent=consistent,
    )


def _cubic(coefficients: tuple[float, ...]) -> Array:
    return np.array([*coefficients, 0.0, 0.0, 0.0, 0.0][:4])


compiled = numba.njit(cache=True, fastmath=True, error_model="numpy")


@compiled
def amplitude(t, c):
    x = min(max(t / c.rise, 0.0), 1.0)
    y = min(max((t - c.fall_start) / c.fall, 0.0), 1.0)
    return x * x * x * (10.0 - 15.0 * x + 6.0 * x * x) - y * y * y * (10.0 - 15.0 * y + 6.0 * y * y)


@compiled
def section_force(v2, v3, c):
    """Aerodynamic force per length [N/m], across the conductor and downwind, from velocities."""
    w2, w3 = -v2, c.wind - v3
    a = c.attack_angle + np.arctan2(w2, w3)
    lift = c.lift[0] + a * (c.lift[1] + a * (c.lift[2] + a * c.lift[3]))
    drag = c.drag[0] + a * (c.drag[1] + a * (c.drag[2] + a * c.drag[3]))
    q = c.pressure * np.sqrt(w2 * w2 + w3 * w3)
    return q * (lift * w3 + drag * w2), q * (drag * w3 - lift * w2)


@compiled
def accelerate(t, u, v, c, a, force):
    """Accelerations `a` of the motion u, v; `force` (3, elements) is working memory."""
    elements = force.shape[1]
    x = c.position
    for e in range(elements):
        d1 = x[0, e + 1] - x[0, e] + u[0, e + 1] - u[0, e]
        d2 = x[1, e + 1] - x[1, e] + u[1, e + 1] - u[1, e]
        d3 = u[2, e + 1] - u[2, e]
        tension = c.stiffness * (1.0 / c.rest - 1.0 / np.sqrt(d1 * d1 + d2 * d2 + d3 * d3))
        force[0, e] = tension * d1
        force[1, e] = tension * d2
        force[2, e] = tension * d3
    factor, inverse = amplitude(t, c), 1.0 / c.node_mass
    for k in range(3):
        weight = c.weight if k == 1 else 0.0
        for i in range(1, elements):
            a[k, i] = (force[k, i] - force[k, i - 1] + factor * c.load[k, i] - weight) * inverse
    if c.wind > 0.0:
        for i in range(1, elements):
            n1, n2 = c.normal[0, i], c.normal[1, i]
            up, along = section_force(n1 * v[0, i] + n2 * v[1, i], v[2, i], c)
            a[0, i] += up * n1 * c.tributary[i] * inverse
            a[1, i] += up * n2 * c.tributary[i] * inverse
            a[2, i] += along * c.tributary[i] * inverse
    if c.consistent:
        _divide_by_consistent_mass(a, force[0])
    if c.damping > 0.0:
        for k in range(3):
            for i in range(1, elements):
                a[k, i] -= c.damping * v[k, i]


@compiled
def _divide_by_consistent_mass(a, upper):
    """Solve tridiagonal (1, 4, 1)/6 for the interior nodes, all three directions."""
    last = a.shape[1] - 2
    for k in range(3):
        upper[1] = 0.25
        a[k, 1] *= 6.0 * 0.25
        for i in range(2, last + 1):
            upper[i] = 1.0 / (4.0 - upper[i - 1])
            a[k, i] = (6.0 * a[k, i] - a[k, i - 1]) * upper[i]
        for i in range(last - 1, 0, -1):
            a[k, i] -= upper[i] * a[k, i + 1]


def extrapolated(problem: Problem, coarse: int, step: float) -> Array:
    """Response extrapolated to zero mesh size (order 2), from `coarse` and twice the elements."""
    every, records = round(INTERVAL / step), len(problem.times)
    once = velocity_verlet(chain(problem, coarse), step, every, records)
    twice = velocity_verlet(chain(problem, 2 * coarse), 0.5 * step, 2 * every, records)
    return (4.0 * twice - once) / 3.0


@compiled
def velocity_verlet(c, step, every, records):
    """Velocity Verlet (explicit, order 2); mid-span u2, u3.

    Forces that depend on velocity use the predicted velocity.
    """
    nodes = c.position.shape[1]
    middle = nodes // 2
    u, v, a, guess = (
        np.zeros((3, nodes)),
        np.zeros((3, nodes)),
        np.zeros((3, nodes)),
        np.zeros((3, nodes)),
    )
    force, out = np.empty((3, nodes - 1)), np.empty((records, 2))
    accelerate(0.0, u, v, c, a, force)
    moving_air = c.wind > 0.0 or c.damping > 0.0
    for record in range(records):
        for k in range(every):
            for j in range(3):
                for i in range(1, nodes - 1):
                    v[j, i] += 0.5 * step * a[j, i]
                    u[j, i] += step * v[j, i]
            if moving_air:
                for j in range(3):
                    for i in range(1, nodes - 1):
                        guess[j, i] = v[j, i] + 0.5 * step * a[j, i]
            accelerate((record * every + k + 1) * step, u, guess, c, a, force)
            for j in range(3):
                for i in range(1, nodes - 1):
                    v[j, i] += 0.5 * step * a[j, i]
        out[record, 0], out[record, 1] = u[1, middle], u[2, middle]
    return out


@compiled
def runge_kutta(c, step, every, records):
    """Classical Runge-Kutta of order 4 (explicit).  Mid-span u2, u3."""
    nodes = c.position.shape[1]
    middle = nodes // 2
    u, v, force = np.zeros((3, nodes)), np.zeros((3, nodes)), np.empty((3, nodes - 1))
    at_u, at_v, a = np.zeros((3, nodes)), np.zeros((3, nodes)), np.zeros((3, nodes))
    sum_u, sum_v, out = np.zeros((3, nodes)), np.zeros((3, nodes)), np.empty((records, 2))
    for record in range(records):
        for k in range(every):
            t = (record * every + k) * step
            for j in range(3):
                for i in range(1, nodes - 1):
                    at_u[j, i], at_v[j, i], sum_u[j, i], sum_v[j, i] = (
                        u[j, i],
                        v[j, i],
                        u[j, i],
                        v[j, i],
                    )
            for stage in range(4):
                ahead = 1.0 if stage == 2 else 0.5
                share = step / 6.0 if stage == 0 or stage == 3 else step / 3.0
                accelerate(
                    t + (0.0 if stage == 0 else 1.0 if stage == 3 else 0.5) * step,
                    at_u,
                    at_v,
                    c,
                    a,
                    force,
                )
                for j in range(3):
                    for i in range(1, nodes - 1):
                        sum_u[j, i] += share * at_v[j, i]
                        sum_v[j, i] += share * a[j, i]
                        at_u[j, i] = u[j, i] + ahead * step * at_v[j, i]
                        at_v[j, i] = v[j, i] + ahead * step * a[j, i]
            for j in range(3):
                for i in range(1, nodes - 1):
                    u[j, i], v[j, i] = sum_u[j, i], sum_v[j, i]
        out[record, 0], out[record, 1] = u[1, middle], u[2, middle]
    return out


@compiled
def right_hand_side(t, y, c, dy, u, v, a, force):
    """First-order form, six unknowns a node (u1 u2 u3 v1 v2 v3): band 11 below, 5 above."""
    inner = y.shape[0] // 6
    for i in range(inner):
        for k in range(3):
            u[k, i + 1], v[k, i + 1] = y[6 * i + k], y[6 * i + 3 + k]
    accelerate(t, u, v, c, a, force)
    for i in range(inner):
        for k in range(3):
            dy[6 * i + k], dy[6 * i + 3 + k] = v[k, i + 1], a[k, i + 1]


@compiled
def jacobian(y, c, rows, columns, values):
    """Entries of d(dy)/dy for lumped mass, always in the same order; returns their number.

    Without `rows` only the values are written.
    """
    inner, count, where = y.shape[0] // 6, 0, rows.shape[0] > 0
    left, right, d = np.zeros((3, 3)), np.zeros((3, 3)), np.empty(3)
    inverse = 1.0 / c.node_mass
    for e in range(inner + 1):
        for k in range(3):
            ahead = y[6 * e + k] if e < inner else 0.0
            behind = y[6 * (e - 1) + k] if e > 0 else 0.0
            d[k] = c.position[k, e + 1] - c.position[k, e] + ahead - behind
        length = np.sqrt(d[0] ** 2 + d[1] ** 2 + d[2] ** 2)
        for j in range(3):
            for k in range(3):
                right[j, k] = inverse * c.stiffness * d[j] * d[k] / length**3
            right[j, j] += inverse * c.stiffness * (1.0 / c.rest - 1.0 / length)
        node = e - 1
        if node >= 0:
            if where:
                _places(node, inner, count, rows, columns)
            for j in range(3):
                values[count] = 1.0
                count += 1
                for k in range(3):
                    if node > 0:
                        values[count] = left[j, k]
                        count += 1
                    values[count] = -left[j, k] - right[j, k]
                    count += 1
                    if node < inner - 1:
                        values[count] = right[j, k]
                        count += 1
                    values[count] = -c.damping if j == k else 0.0
                    if c.wind > 0.0:
                        values[count] += (
                            _section_slope(y, node, j, k, c) * c.tributary[node + 1] * inverse
                        )
                    count += 1
        left[:] = right
    return count


@compiled
def _places(node, inner, count, rows, columns):
    for j in range(3):
        rows[count], columns[count] = 6 * node + j, 6 * node + 3 + j
        count += 1
        for k in range(3):
            for neighbour in range(node - 1, node + 2):
                if 0 <= neighbour < inner:
                    rows[count], columns[count] = 6 * node + 3 + j, 6 * neighbour + k
                    count += 1
            rows[count], columns[count] = 6 * node + 3 + j, 6 * node + 3 + k
            count += 1


@compiled
def _section_slope(y, node, j, k, c):
    """Derivative of the wind force along j by the velocity along k, by a central difference."""
    n1, n2, small = c.normal[0, node + 1], c.normal[1, node + 1], 1e-5
    v2 = n1 * y[6 * node + 3] + n2 * y[6 * node + 4]
    v3 = y[6 * node + 5]
    d2, d3 = (0.0, small) if k == 2 else (small, 0.0)
    up, along = section_force(v2 + d2, v3 + d3, c)
    low_up, low_along = section_force(v2 - d2, v3 - d3, c)
    share = (n1, n2, 1.0)
    change = along - low_along if j == 2 else up - low_up
    return share[j] * share[k] * change / (2.0 * small)
