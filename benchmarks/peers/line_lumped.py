"""Galloping of sections and bundles: a lumped chain with explicit time steps.

Own model, without anything of gallop_fmu: straight bars with engineering strain, lumped masses,
twist at the nodes, velocity Verlet (central differences). Quasi-steady wind force in the plane
across the conductor's tangent at the start. Strings are stiff bars with a third of their mass and
half of their weight at the clamp; spacers are frames that are stiff in their plane, massless, with
torsional springs between frame and conductors. Damping is proportional to the mass of the
conductor; devices and strings have none.

Twist is right-handed about x1: a point (x2, x3) of a section moves by (-x3, x2) times the twist.
"""

from __future__ import annotations

import itertools
from collections import namedtuple
from dataclasses import dataclass, field

import numba
import numpy as np
from line_strung import Array, hang

GRAVITY = 9.81
STIFF = 4e6
"""Stiffness [N/m] of strings, frames and interphase spacers; as an element, so no smaller step."""


SMALL = 1e-6
"""Displacement [m, rad] of the differences behind a frequency."""


@dataclass(frozen=True)
class Conductor:
    """Values per metre of rest length (SI); first moments of the ice [kg] about the axis."""

    mass: float
    axial_stiffness: float
    torsional_stiffness: float
    inertia: float
    diameter: float
    first_moment_x2: float = 0.0
    first_moment_x3: float = 0.0


@dataclass(frozen=True)
class Wind:
    """Speed [m/s], yaw from the normal of the line, attack angle [rad]; curves: powers of x [rad].

    x is the angle of attack less `centre` [rad].
    """

    speed: float
    attack_angle: float
    lift: tuple[float, ...]
    drag: tuple[float, ...]
    moment: tuple[float, ...] = ()
    centre: float = 0.0
    density: float = 1.2929
    yaw: float = 0.0


@dataclass(frozen=True)
class Frame:
    """Spacer of all subconductors of a bundle at a station of every span."""

    station: float
    clamp_stiffness: float


@dataclass(frozen=True)
class Case:
    """A section; `conductors` are offsets (x2, x3) [m]; `pendulums`: station, mass [kg], arm [m].

    `bars`: stations of interphase spacers, massless. `strings`: length [m], weight [N]. Damping
    [1/s] of translations and twist; `seed` (u2, u3) [m] of sin(pi x/L) in every span.
    """

    conductor: Conductor
    tension: float
    spans: tuple[float, ...]
    wind: Wind
    damping: tuple[float, float]
    elements: int
    rises: tuple[float, ...] = ()
    strings: tuple[tuple[float, float], ...] = ()
    conductors: tuple[tuple[float, float], ...] = ((0.0, 0.0),)
    frames: tuple[Frame, ...] = ()
    bars: tuple[float, ...] = ()
    pendulums: tuple[tuple[float, float, float], ...] = ()
    seed: tuple[float, float] = (1e-3, 1e-3)


Tables = namedtuple(
    "Tables",
    "x fixed mass weight inertia s2 s3 damped damped_twist length n2 n3"  # of nodes
    " left right rest ea gj"  # of elements
    " bar_a bar_b bar_rest string_node string_top string_rest frame_node frame_arm frame_spring"
    " stiff wind pressure attack lift drag moment diameter",
)


@dataclass
class Model:
    """Tables for the compiled code, and nodes by conductor, span and element corner."""

    case: Case
    tables: Tables
    nodes: list[list[Array]]
    seed: Array

    def middle(self, conductor: int, span: int) -> int:
        return int(self.nodes[conductor][span][self.case.elements // 2])

    def clamps(self, conductor: int) -> list[int]:
        return [int(nodes[-1]) for nodes in self.nodes[conductor][:-1]]


@dataclass
class _Builder:
    case: Case
    columns: dict[str, list] = field(default_factory=dict)

    def add(self, **values: object) -> int:
        for name, value in values.items():
            self.columns.setdefault(name, []).append(value)
        return len(self.columns[next(iter(values))]) - 1


def build(case: Case) -> Model:
    """The strung state as masses and bars."""
    builder, nodes = _Builder(case), []
    for offset in case.conductors:
        nodes.append(_conductor(builder, offset))
    columns = builder.columns
    x = np.array(columns["x"])
    for station in case.bars:
        at = [int(chains[0][_corner(case, station)]) for chains in nodes]
        for a, b in itertools.pairwise(at):
            builder.add(bar_a=a, bar_b=b, bar_rest=float(np.linalg.norm(x[a] - x[b])))
    for span in range(len(case.spans)):
        for frame in case.frames:
            at = [int(chains[span][_corner(case, frame.station)]) for chains in nodes]
            arms = x[at][:, 1:] - x[at][:, 1:].mean(axis=0)
            builder.add(frame_node=at, frame_arm=arms, frame_spring=frame.clamp_stiffness)
        for station, mass, arm in case.pendulums:
            for chains in nodes:
                node = int(chains[span][_corner(case, station)])
                columns["mass"][node] += mass
                columns["weight"][node] += mass * GRAVITY
                columns["s3"][node] -= mass * arm
                columns["inertia"][node] += mass * arm**2
    return Model(case, _tables(case, columns), nodes, _seed(case, x, nodes))


def _corner(case: Case, station: float) -> int:
    corner = round(station * case.elements)
    assert abs(corner - station * case.elements) < 1e-9, f"station {station} is not a node"
    return corner


def _conductor(builder: _Builder, offset: tuple[float, float]) -> list[Array]:
    """Nodes of one conductor; ends and clamps have no twist."""
    case, c = builder.case, builder.case.conductor
    weight = c.mass * GRAVITY
    rises = case.rises or (0.0,) * len(case.spans)
    chains = [
        hang(length, rise, case.tension, weight, c.axial_stiffness, case.elements)
        for length, rise in zip(case.spans, rises, strict=True)
    ]
    at = np.array([0.0, *offset])
    tags: list[Array] = []
    last = _node(builder, at, (True, True, True, True))
    for k, chain in enumerate(chains):
        own = [last]
        for corner in range(1, case.elements + 1):
            end = corner == case.elements
            tower = end and k + 1 == len(chains)
            x = at + np.array([*chain.position[:, corner], 0.0])
            own.append(_node(builder, x, (tower, tower, tower, end)))
        for a, b in itertools.pairwise(own):
            _element(builder, a, b, chain.rest)
        last = own[-1]
        at = at + np.array([case.spans[k], rises[k], 0.0])
        if k + 1 < len(chains):
            pull = chain.right + chains[k + 1].left
            _string(builder, last, at, case.strings[k], pull)
        tags.append(np.array(own))
    return tags


def _node(builder: _Builder, x: Array, fixed: tuple[bool, bool, bool, bool]) -> int:
    return builder.add(
        x=x, fixed=fixed, mass=0.0, weight=0.0, inertia=0.0, s2=0.0, s3=0.0, damped=0.0,
        damped_twist=0.0, length=0.0, tangent=np.zeros(3),
    )  # fmt: skip


def _element(builder: _Builder, a: int, b: int, rest: float) -> None:
    c, columns = builder.case.conductor, builder.columns
    builder.add(
        left=a, right=b, rest=rest, ea=c.axial_stiffness, gj=c.torsional_stiffness / rest
    )  # fmt: skip
    chord = columns["x"][b] - columns["x"][a]
    for node in (a, b):
        columns["mass"][node] += 0.5 * c.mass * rest
        columns["weight"][node] += 0.5 * c.mass * rest * GRAVITY
        columns["inertia"][node] += 0.5 * c.inertia * rest
        columns["damped"][node] += 0.5 * builder.case.damping[0] * c.mass * rest
        columns["damped_twist"][node] += 0.5 * builder.case.damping[1] * c.inertia * rest
        columns["s3"][node] += 0.5 * c.first_moment_x2 * rest
        columns["s2"][node] += 0.5 * c.first_moment_x3 * rest
        columns["length"][node] += 0.5 * float(np.linalg.norm(chord))
        columns["tangent"][node] = columns["tangent"][node] + chord


def _string(
    builder: _Builder, node: int, at: Array, string: tuple[float, float], pull: float
) -> None:
    length, weight = string
    columns = builder.columns
    columns["mass"][node] += weight / GRAVITY / 3.0
    columns["weight"][node] += 0.5 * weight
    builder.add(
        string_node=node,
        string_top=at + np.array([0.0, length, 0.0]),
        string_rest=length - (pull + 0.5 * weight) / STIFF,
    )


def _seed(case: Case, x: Array, nodes: list[list[Array]]) -> Array:
    shape = np.zeros((len(x), 4))
    for chains in nodes:
        for span, tags in enumerate(chains):
            s = (x[tags, 0] - x[tags[0], 0]) / case.spans[span]
            shape[tags, 1] = case.seed[0] * np.sin(np.pi * s)
            shape[tags, 2] = case.seed[1] * np.sin(np.pi * s)
    return shape


def _tables(case: Case, columns: dict[str, list]) -> Tables:
    wind = case.wind
    tangent = np.array(columns["tangent"])
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    n3 = np.array([0.0, 0.0, 1.0]) - tangent[:, 2:] * tangent
    n3 /= np.linalg.norm(n3, axis=1)[:, None]
    n2 = np.cross(n3, tangent)
    speed = wind.speed * np.array([np.sin(wind.yaw), 0.0, np.cos(wind.yaw)])
    power = [np.array([*c, 0.0, 0.0, 0.0, 0.0][:4]) for c in (wind.lift, wind.drag, wind.moment)]
    kind = {"fixed": np.bool_} | {
        name: np.int64 for name in ("left", "right", "bar_a", "bar_b", "string_node", "frame_node")
    }
    empty = {"string_top": (0, 3), "frame_node": (0, 1), "frame_arm": (0, 1, 2)}
    names = [name for name in Tables._fields if name in columns or name.split("_")[0] in
             ("bar", "string", "frame")]  # fmt: skip
    arrays = {
        name: np.array(columns[name], dtype=kind.get(name, np.float64))
        if name in columns
        else np.zeros(empty.get(name, (0,)), dtype=kind.get(name, np.float64))
        for name in names
    }
    return Tables(
        **arrays,
        n2=n2,
        n3=n3,
        stiff=STIFF,
        wind=speed,
        pressure=0.5 * wind.density * case.conductor.diameter,
        attack=wind.attack_angle - wind.centre,
        lift=power[0],
        drag=power[1],
        moment=power[2],
        diameter=case.conductor.diameter,
    )


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
        i = t.string_node[e]
        d1 = t.string_top[e, 0] - t.x[i, 0] - u[i, 0]
        d2 = t.string_top[e, 1] - t.x[i, 1] - u[i, 1]
        d3 = t.string_top[e, 2] - t.x[i, 2] - u[i, 2]
        length = np.sqrt(d1 * d1 + d2 * d2 + d3 * d3)
        n = t.stiff * (length - t.string_rest[e]) / length
        f[i, 0] += n * d1
        f[i, 1] += n * d2
        f[i, 2] += n * d3
    for k in range(t.frame_spring.shape[0]):
        _frame(u, t, k, f)
    for i in range(t.x.shape[0]):
        if t.fixed[i, 0]:
            continue
        f[i, 1] -= t.weight[i]
        if windy:
            _wind(u, v, t, i, f)
        _node_acceleration(u, v, t, i, f, a)


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
    moment = f[i, 3] + 9.81 * (c3 - t.s2[i]) + (c3 * f[i, 1] - c2 * f[i, 2]) / mass
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


def largest_step(case: Case) -> float:
    """Six tenths of the stability limit of the stiffest oscillation of a single element."""
    c = case.conductor
    rest = min(case.spans) / case.elements
    axial = 4.0 * c.axial_stiffness / (c.mass * rest**2)
    stiff = 4.0 * STIFF / (c.mass * rest) if case.frames or case.bars else 0.0
    clamp = max((frame.clamp_stiffness for frame in case.frames), default=0.0)
    inertia = c.inertia - (c.first_moment_x2**2 + c.first_moment_x3**2) / c.mass
    twist = (4.0 * c.torsional_stiffness / rest**2 + clamp / rest) / inertia
    return 0.6 * 2.0 / float(np.sqrt(max(axial + stiff, twist)))


def settled(model: Model, step: float) -> Model:
    """Equilibrium without wind: motion with strong damping, which is then taken away."""
    t = model.tables
    tables = t._replace(damped=2.0 * t.mass, damped_twist=20.0 * t.inertia)
    u, v = np.zeros((len(tables.x), 4)), np.zeros((len(tables.x), 4))
    march(u, v, tables, False, step, round(60.0 / step), 1, np.zeros(1, np.int64))
    x = tables.x + u[:, :3]
    return Model(model.case, model.tables._replace(x=x), model.nodes, model.seed)


def frequencies(model: Model, count: int) -> tuple[Array, Array]:
    """Frequencies [Hz] without wind and damping, and shapes (mode, node, 4); by differences."""
    t = model.tables
    free = np.argwhere(~t.fixed)
    still, zero, force = (np.zeros((len(t.x), 4)) for _ in range(3))
    calm = t._replace(damped=zero[:, 0], damped_twist=zero[:, 0])
    jacobian = np.empty((len(free), len(free)))
    for column, (node, direction) in enumerate(free):
        change = []
        for sign in (1.0, -1.0):
            u, a = still.copy(), np.zeros((len(t.x), 4))
            u[node, direction] = sign * SMALL
            accelerate(u, still, calm, False, force, a)
            change.append(a[free[:, 0], free[:, 1]])
        jacobian[:, column] = (change[1] - change[0]) / (2.0 * SMALL)
    values, vectors = np.linalg.eig(jacobian)
    order = np.argsort(values.real)[:count]
    shapes = np.zeros((count, len(t.x), 4))
    shapes[:, free[:, 0], free[:, 1]] = vectors[:, order].real.T
    return np.sqrt(values[order].real) / (2.0 * np.pi), shapes


def simulate(
    model: Model, duration: float, watched: list[int], step: float = 0.0, interval: float = 0.05
) -> tuple[Array, Array]:
    """Times and displacements (record, watched node, 4) from rest with the seed, in wind."""
    step = step or largest_step(model.case)
    every = int(np.ceil(interval / step))
    u, v = model.seed.copy(), np.zeros((len(model.tables.x), 4))
    records = round(duration / interval)
    out = march(
        u, v, model.tables, True, interval / every, every, records, np.array(watched, np.int64)
    )
    assert np.isfinite(out).all(), "the time step is too long"
    return interval * np.arange(1, records + 1), out
