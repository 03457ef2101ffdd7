"""Compiled part of the lumped chain: forces, accelerations, velocity Verlet.

`t` are the `Tables` of line_lumped.py; `u`, `v`, `a`, `f` have a row (u1, u2, u3, twist) a node.
"""

import numba
import numpy as np

GRAVITY = 9.81

compiled = numba.njit(cache=True, error_model="numpy")


@compiled
def _bar(u, t, a, b, pull, f):
    """Add the force of a bar with `pull` = (stiffness k, rest length) between two nodes."""
    d1 = t.x[b, 0] - t.x[a, 0] + u[b, 0] - u[a, 0]
    d2 = t.x[b, 1] - t.x[a, 1] + u[b, 1] - u[a, 1]
    d3 = t.x[b, 2] - t.x[a, 2] + u[b, 2] - u[a, 2]
    length = np.sqrt(d1 * d1 + d2 * d2 + d3 * d3)
    n = pull[0] * (length - pull[1]) / length
    f[a, 0] += n * d1
    f[a, 1] += n * d2
    f[a, 2] += n * d3
    f[b, 0] -= n * d1
    f[b, 1] -= n * d2
    f[b, 2] -= n * d3


@compiled
def _frame(u, t, k, f):
    """Best fit of a frame: stiff arms, and springs between the twists and the turn of the frame."""
    nodes, arms = t.frame_node[k], t.frame_arm[k]
    n = nodes.shape[0]
    c2, c3 = 0.0, 0.0
    for i in range(n):
        c2 += (t.x[nodes[i], 1] + u[nodes[i], 1]) / n
        c3 += (t.x[nodes[i], 2] + u[nodes[i], 2]) / n
    a, b = 0.0, 0.0
    for i in range(n):
        y2 = t.x[nodes[i], 1] + u[nodes[i], 1] - c2
        y3 = t.x[nodes[i], 2] + u[nodes[i], 2] - c3
        a += arms[i, 0] * y2 + arms[i, 1] * y3
        b += arms[i, 0] * y3 - arms[i, 1] * y2
    turn = np.arctan2(b, a)
    cos, sin, square = np.cos(turn), np.sin(turn), a * a + b * b
    torque = 0.0
    for i in range(n):
        m = t.frame_spring[k] * (u[nodes[i], 3] - turn)
        f[nodes[i], 3] -= m
        torque += m
    for i in range(n):
        r2, r3 = arms[i, 0], arms[i, 1]
        y2 = t.x[nodes[i], 1] + u[nodes[i], 1] - c2
        y3 = t.x[nodes[i], 2] + u[nodes[i], 2] - c3
        f[nodes[i], 1] -= t.stiff * (y2 - cos * r2 + sin * r3)
        f[nodes[i], 2] -= t.stiff * (y3 - sin * r2 - cos * r3)
        f[nodes[i], 1] += torque * (-a * r3 - b * r2) / square
        f[nodes[i], 2] += torque * (a * r2 - b * r3) / square


@compiled
def _string_force(u, t, e, f):
    """Pull of a string on the mean position of its nodes."""
    nodes = t.string_node[e]
    share = 1.0 / nodes.shape[0]
    d1, d2, d3 = t.string_top[e, 0], t.string_top[e, 1], t.string_top[e, 2]
    for i in nodes:
        d1 -= share * (t.x[i, 0] + u[i, 0])
        d2 -= share * (t.x[i, 1] + u[i, 1])
        d3 -= share * (t.x[i, 2] + u[i, 2])
    length = np.sqrt(d1 * d1 + d2 * d2 + d3 * d3)
    n = share * t.stiff * (length - t.string_rest[e]) / length
    for i in nodes:
        f[i, 0] += n * d1
        f[i, 1] += n * d2
        f[i, 2] += n * d3


@compiled
def _string_inertia(t, e, a):
    """Third of the string's mass at the mean position: the accelerations become smaller.

    (D + mu 1 1^T) a' = D a with mu = mass/3/n^2. Ice must not couple a free twist to it.
    """
    nodes = t.string_node[e]
    mu = t.string_mass[e] / nodes.shape[0] ** 2
    inverse = 0.0
    for i in nodes:
        inverse += 1.0 / t.mass[i]
    for k in range(3):
        total = 0.0
        for i in nodes:
            total += a[i, k]
        for i in nodes:
            a[i, k] -= mu * total / (t.mass[i] * (1.0 + mu * inverse))


@compiled
def _wind(u, v, t, i, f):
    """Lift, drag and moment of a node in the plane across the tangent."""
    w1, w2, w3 = t.wind[0] - v[i, 0], t.wind[1] - v[i, 1], t.wind[2] - v[i, 2]
    n2, n3 = t.n2[i], t.n3[i]
    up = w1 * n2[0] + w2 * n2[1] + w3 * n2[2] - 0.5 * t.diameter * v[i, 3]
    along = w1 * n3[0] + w2 * n3[1] + w3 * n3[2]
    x = t.attack + u[i, 3] + np.arctan2(up, along)
    lift = t.lift[0] + x * (t.lift[1] + x * (t.lift[2] + x * t.lift[3]))
    drag = t.drag[0] + x * (t.drag[1] + x * (t.drag[2] + x * t.drag[3]))
    moment = t.moment[0] + x * (t.moment[1] + x * (t.moment[2] + x * t.moment[3]))
    speed = np.sqrt(up * up + along * along)
    q = t.pressure * speed * t.length[i]
    f2, f3 = q * (lift * along + drag * up), q * (drag * along - lift * up)
    for k in range(3):
        f[i, k] += f2 * n2[k] + f3 * n3[k]
    f[i, 3] += q * speed * t.diameter * moment


@compiled
def accelerate(u, v, t, windy, f, a):
    """Accelerations `a` (node, 4) of the motion u, v; `f` is working memory."""
    f[:] = 0.0
    for e in range(t.left.shape[0]):
        p, q = t.left[e], t.right[e]
        _bar(u, t, p, q, (t.ea[e] / t.rest[e], t.rest[e]), f)
        m = t.gj[e] * (u[q, 3] - u[p, 3])
        f[p, 3] += m
        f[q, 3] -= m
    for e in range(t.bar_rest.shape[0]):
        _bar(u, t, t.bar_a[e], t.bar_b[e], (t.stiff, t.bar_rest[e]), f)
    for e in range(t.string_rest.shape[0]):
        _string_force(u, t, e, f)
    for k in range(t.frame_spring.shape[0]):
        _frame(u, t, k, f)
    for i in range(t.x.shape[0]):
        if t.fixed[i, 0]:
            continue
        f[i, 1] -= t.weight[i]
        if windy:
            _wind(u, v, t, i, f)
        _node_acceleration(u, v, t, i, f, a)
    for e in range(t.string_rest.shape[0]):
        _string_inertia(t, e, a)


@compiled
def _node_acceleration(u, v, t, i, f, a):
    mass = t.mass[i]
    for k in range(3):
        f[i, k] -= t.damped[i] * v[i, k]
    f[i, 3] -= t.damped_twist[i] * v[i, 3]
    a[i, 0] = f[i, 0] / mass
    if t.fixed[i, 3]:
        a[i, 1] = f[i, 1] / mass
        a[i, 2] = f[i, 2] / mass
        return
    cos, sin = np.cos(u[i, 3]), np.sin(u[i, 3])
    c2 = t.s3[i] * cos - t.s2[i] * sin
    c3 = t.s3[i] * sin + t.s2[i] * cos
    square = v[i, 3] * v[i, 3]
    # ice hangs on the section: mass, first moments and inertia of the node are coupled
    moment = f[i, 3] + GRAVITY * (c3 - t.s2[i]) + (c3 * f[i, 1] - c2 * f[i, 2]) / mass
    turn = moment / (t.inertia[i] - (c2 * c2 + c3 * c3) / mass)
    a[i, 1] = (f[i, 1] + c3 * turn + c2 * square) / mass
    a[i, 2] = (f[i, 2] - c2 * turn + c3 * square) / mass
    a[i, 3] = turn


@compiled
def march(u, v, t, windy, step, every, records, watched):
    """Velocity Verlet; u (4) of the watched nodes at every record."""
    nodes = u.shape[0]
    a, guess, f = np.zeros((nodes, 4)), np.zeros((nodes, 4)), np.zeros((nodes, 4))
    out = np.zeros((records, watched.shape[0], 4))
    accelerate(u, v, t, windy, f, a)
    for record in range(records):
        for _ in range(every):
            for i in range(nodes):
                for k in range(4):
                    v[i, k] += 0.5 * step * a[i, k]
                    u[i, k] += step * v[i, k]
                    guess[i, k] = v[i, k] + 0.5 * step * a[i, k]
            accelerate(u, guess, t, windy, f, a)
            for i in range(nodes):
                for k in range(4):
                    v[i, k] += 0.5 * step * a[i, k]
        for j in range(watched.shape[0]):
            for k in range(4):
                out[record, j, k] = u[watched[j], k]
    return out
