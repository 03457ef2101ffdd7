"""Galloping of sections and bundles: a lumped chain with explicit time steps.

Own model, without anything of gallop_fmu: straight bars with engineering strain, lumped masses,
twist at the nodes, velocity Verlet (central differences). Quasi-steady wind force in the plane
across the conductor's tangent at the start. Strings are stiff bars with a third of their mass and
half of their weight at the clamp, or at the mean position of all clamps of a bundle, which are a
frame as in a spacer (yoke); spacers are frames that are stiff in their plane, massless, with
torsional springs between frame and conductors. Damping is proportional to the mass of the
conductor; devices and strings have none.

Twist is right-handed about x1: a point (x2, x3) of a section moves by (-x3, x2) times the twist.
"""

from __future__ import annotations

import itertools
from collections import namedtuple
from dataclasses import dataclass, field

import numpy as np
from line_march import GRAVITY, accelerate, march
from line_strung import Array, hang

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
    " bar_a bar_b bar_rest string_node string_top string_rest string_mass"
    " frame_node frame_arm frame_spring"
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
    pull: list[float] = field(default_factory=list)

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
            _frame_table(builder, at, frame)
        for station, mass, arm in case.pendulums:
            for chains in nodes:
                node = int(chains[span][_corner(case, station)])
                columns["mass"][node] += mass
                columns["weight"][node] += mass * GRAVITY
                columns["s3"][node] -= mass * arm
                columns["inertia"][node] += mass * arm**2
    for number, string in enumerate(case.strings):
        clamps = [int(chains[number][-1]) for chains in nodes]
        if case.frames:
            _frame_table(builder, clamps, case.frames[0])
            _string(builder, clamps, string, number)
        else:
            for clamp in clamps:
                _string(builder, [clamp], string, number)
    return Model(case, _tables(case, columns), nodes, _seed(case, x, nodes))


def _frame_table(builder: _Builder, nodes: list[int], frame: Frame) -> None:
    x = np.array([builder.columns["x"][node] for node in nodes])[:, 1:]
    arms = x - x.mean(axis=0)
    builder.add(frame_node=nodes, frame_arm=arms, frame_spring=frame.clamp_stiffness)


def _corner(case: Case, station: float) -> int:
    corner = round(station * case.elements)
    assert abs(corner - station * case.elements) < 1e-9, f"station {station} is not a node"
    return corner


def _conductor(builder: _Builder, offset: tuple[float, float]) -> list[Array]:
    """Nodes of one conductor; ends and clamps have no twist, except in a yoke."""
    case, c = builder.case, builder.case.conductor
    weight = c.mass * GRAVITY
    rises = case.rises or (0.0,) * len(case.spans)
    chains = [
        hang(length, rise, case.tension, weight, c.axial_stiffness, case.elements)
        for length, rise in zip(case.spans, rises, strict=True)
    ]
    at = np.array([0.0, *offset])
    tags: list[Array] = []
    builder.pull = [a.right + b.left for a, b in itertools.pairwise(chains)]
    last = _node(builder, at, (True, True, True, True))
    for k, chain in enumerate(chains):
        own = [last]
        for corner in range(1, case.elements + 1):
            end = corner == case.elements
            tower = end and k + 1 == len(chains)
            x = at + np.array([*chain.position[:, corner], 0.0])
            held = tower or (end and not case.frames)
            own.append(_node(builder, x, (tower, tower, tower, held)))
        for a, b in itertools.pairwise(own):
            _element(builder, a, b, chain.rest)
        last = own[-1]
        at = at + np.array([case.spans[k], rises[k], 0.0])
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


def _string(builder: _Builder, nodes: list[int], string: tuple[float, float], number: int) -> None:
    """A string that holds the mean position of nodes; `pull`: weight on it of one conductor."""
    length, weight = string
    columns, count = builder.columns, len(nodes)
    for node in nodes:
        columns["weight"][node] += 0.5 * weight / count
    place = np.mean([columns["x"][node] for node in nodes], axis=0)
    builder.add(
        string_node=nodes,
        string_top=place + np.array([0.0, length, 0.0]),
        string_rest=length - (count * builder.pull[number] + 0.5 * weight) / STIFF,
        string_mass=weight / GRAVITY / 3.0,
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
    empty = {
        "string_node": (0, 1),
        "string_top": (0, 3),
        "frame_node": (0, 1),
        "frame_arm": (0, 1, 2),
    }
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
    model: Model,
    duration: float,
    watched: list[int],
    step: float = 0.0,
    interval: float = 0.05,
    windy: bool = True,
) -> tuple[Array, Array]:
    """Times and displacements (record, watched node, 4) from rest with the seed, in wind."""
    step = step or largest_step(model.case)
    every = int(np.ceil(interval / step))
    u, v = model.seed.copy(), np.zeros((len(model.tables.x), 4))
    records = round(duration / interval)
    out = march(
        u, v, model.tables, windy, interval / every, every, records, np.array(watched, np.int64)
    )
    assert np.isfinite(out).all(), "the time step is too long"
    return interval * np.arange(1, records + 1), out
