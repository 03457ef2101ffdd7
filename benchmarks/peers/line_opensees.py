"""Tension sections, bundles and phases in OpenSees: corotational trusses with consistent mass.

Own model, without anything of gallop_fmu. A conductor is a chain of trusses of equal rest length;
the strung state (strings plumb, one horizontal tension in all spans) is the equilibrium of that
chain and fixes the rest lengths. A string is one stiff truss with its mass: a uniform bar with
ball joints. A spacer is a frame of stiff trusses in the plane across the line. Nothing twists.

All masses are per metre of rest length; `Line.mass_per_hanging_length` converts.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
from line_strung import Array, Strung, hang
from opensees_wheel import load

ops = load()

NOTHING = (0.0, 0.0, 0.0)
STIFF = 1e9
"""Stiffness [N/m] of a string, of a bar of a spacer, of an interphase spacer."""


@dataclass(frozen=True)
class Span:
    """Length [m], rise of the right end above the left [m], state of the conductor in it.

    `temperature` [K] counts from the strung state; `ice` [kg per metre of rest length], `wind` [N
    per metre of rest length, across the line] and point masses (station, kg) act after stringing.
    """

    length: float
    rise: float = 0.0
    ice: float = 0.0
    wind: float = 0.0
    masses: tuple[tuple[float, float], ...] = ()


@dataclass(frozen=True)
class End:
    """An end string: its tower's point from the clamp in the strung state (x1, x2) [m]."""

    tower: tuple[float, float]
    length: float
    weight: float


@dataclass(frozen=True)
class Line:
    """A section.  `strings`: (length [m], weight [N]) between each two spans.

    `conductors`: offsets (x2, x3) [m] of all subconductors or phases, each on its own strings.
    `frames`: (station, conductors): stiff frames in every span. `bars`: the same with ball-jointed
    bars between two conductors (mass [kg] as third entry).
    """

    spans: tuple[Span, ...]
    strings: tuple[tuple[float, float], ...]
    mass: float
    axial_stiffness: float
    tension: float
    elements: int
    gravity: float = 9.81
    expansion: float = 0.0
    temperature_change: float = 0.0
    conductors: tuple[tuple[float, float], ...] = ((0.0, 0.0),)
    frames: tuple[float, ...] = ()
    bars: tuple[tuple[float, float], ...] = ()
    string_stiffness: float = STIFF
    string_taut: bool = True
    rest_lengths: tuple[float, ...] = ()
    ends: tuple[End, ...] = ()

    @property
    def mass_per_hanging_length(self) -> float:
        """Mass [kg/m] of the strung conductor per metre of its hanging length, mean of the line."""
        rest = hanging = 0.0
        for span in self.spans:
            chain = strung(self, span)
            rest += chain.rest * self.elements
            hanging += float(np.linalg.norm(np.diff(chain.position, axis=1), axis=0).sum())
        return self.mass * rest / hanging

    def refined(self, factor: int) -> Line:
        return replace(self, elements=self.elements * factor)


def strung(line: Line, span: Span) -> Strung:
    """The strung chain of a span; what acts later (ice, wind, point masses) has no part in it."""
    weight = line.mass * line.gravity
    return hang(span.length, span.rise, line.tension, weight, line.axial_stiffness, line.elements)


@dataclass
class Built:
    """Tags of the nodes: `chains[conductor][span]`, `clamps[conductor][suspension]`."""

    line: Line
    chains: list[list[list[int]]] = field(default_factory=list)
    clamps: list[list[int]] = field(default_factory=list)
    free: list[int] = field(default_factory=list)
    loads: dict[int, Array] = field(default_factory=dict)
    later: dict[int, Array] = field(default_factory=dict)
    end_clamps: list[int] = field(default_factory=list)
    strings: list[int] = field(default_factory=list)
    next_tag: int = 1
    trusses: int = 0

    def node(self, x: Array, fixed: bool = False) -> int:
        tag = self.next_tag
        self.next_tag += 1
        ops.node(tag, *map(float, x))
        if fixed:
            ops.fix(tag, 1, 1, 1)
        else:
            self.free.append(tag)
            self.loads[tag], self.later[tag] = np.zeros(3), np.zeros(3)
        return tag

    def load(
        self, tag: int, strung: tuple[float, float, float], later: tuple[float, float, float]
    ) -> None:
        """Add forces: of the strung state, and those that come after it."""
        if tag in self.loads:
            self.loads[tag] += strung
            self.later[tag] += later

    def truss(self, a: int, b: int, stiffness: float, rest: float, mass: float) -> int:
        """Truss of axial stiffness EA [N] on its rest length [m], with its whole mass [kg]."""
        x, y = (np.array(ops.nodeCoord(tag)) for tag in (a, b))
        length = float(np.linalg.norm(y - x))
        self.trusses += 1
        e = self.trusses
        ops.uniaxialMaterial("Elastic", e, stiffness * length / rest)
        ops.uniaxialMaterial("InitStrainMaterial", 10_000_000 + e, e, (length - rest) / length)
        options = ("-rho", mass / length, "-cMass", 1, "-doRayleigh", 1)
        ops.element("corotTruss", e, a, b, 1.0, 10_000_000 + e, *options)
        return e


def build(line: Line) -> Built:
    """Nodes at the strung state, trusses with the rest lengths of the state now, all loads."""
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 3)
    built = Built(line)
    for offset in line.conductors:
        _conductor(built, offset)
    _frames(built)
    return built


def _conductor(built: Built, offset: tuple[float, float]) -> None:
    line = built.line
    at = np.array([0.0, *offset])
    start = built.node(at, fixed=not line.ends)
    if line.ends:
        _end_string(built, start, at, line.ends[0])
    chains: list[list[int]] = []
    clamps: list[int] = []
    hanging = [strung(line, span) for span in line.spans]
    for k, (span, chain) in enumerate(zip(line.spans, hanging, strict=True)):
        tags = [start]
        for i in range(1, line.elements + 1):
            x = at + np.array([chain.position[0, i], chain.position[1, i], 0.0])
            last = i == line.elements and k + 1 == len(line.spans)
            tags.append(built.node(x, fixed=last and not line.ends))
        rest = line.rest_lengths[k] / line.elements if line.rest_lengths else chain.rest
        _span_elements(built, span, tags, rest)
        at = at + np.array([span.length, span.rise, 0.0])
        start = tags[-1]
        chains.append(tags)
        if k + 1 < len(line.spans):
            clamps.append(start)
            pull = chain.right + hanging[k + 1].left
            _string(built, start, at, line.strings[k], pull)
    if line.ends:
        _end_string(built, start, at, line.ends[1])
    built.chains.append(chains)
    built.clamps.append(clamps)


def _span_elements(built: Built, span: Span, tags: list[int], rest: float) -> None:
    line = built.line
    mass = (line.mass + span.ice) * rest
    first = (0.0, -0.5 * line.mass * rest * line.gravity, 0.0)
    later = (0.0, -0.5 * span.ice * rest * line.gravity, 0.5 * span.wind * rest)
    stretched = rest * (1.0 + line.expansion * line.temperature_change)
    for a, b in itertools.pairwise(tags):
        built.truss(a, b, line.axial_stiffness, stretched, mass)
        built.load(a, first, later)
        built.load(b, first, later)
    for station, point in span.masses:
        tag = tags[_node_of(line, station)]
        ops.mass(tag, point, point, point)
        built.load(tag, NOTHING, (0.0, -point * line.gravity, 0.0))


def _node_of(line: Line, station: float) -> int:
    node = round(station * line.elements)
    assert abs(node - station * line.elements) < 1e-9, f"station {station} is not a node"
    return node


def _string(built: Built, clamp: int, at: Array, string: tuple[float, float], pull: float) -> None:
    """A string above a clamp; `string_taut`: of its length under the pull of the strung state."""
    line = built.line
    length, weight = string
    top = built.node(at + np.array([0.0, length, 0.0]), fixed=True)
    stiffness = line.string_stiffness * length
    rest = length / (1.0 + (pull + 0.5 * weight) / stiffness) if line.string_taut else length
    built.strings.append(built.truss(top, clamp, stiffness, rest, weight / line.gravity))
    built.load(clamp, (0.0, -0.5 * weight, 0.0), NOTHING)


def _end_string(built: Built, clamp: int, at: Array, end: End) -> None:
    line = built.line
    tower = built.node(at + np.array([*end.tower, 0.0]), fixed=True)
    stiffness = line.string_stiffness * end.length
    built.truss(tower, clamp, stiffness, end.length, end.weight / line.gravity)
    built.load(clamp, (0.0, -0.5 * end.weight, 0.0), NOTHING)
    built.end_clamps.append(clamp)


def _frames(built: Built) -> None:
    """Stiff frames: bars between all pairs; interphase spacers: a bar from each to the next."""
    line = built.line
    count = len(line.conductors)
    pairs = [(i, j, 0.0, s) for s in line.frames for i in range(count) for j in range(i)]
    pairs += [(i, i + 1, mass, s) for s, mass in line.bars for i in range(count - 1)]
    for k in range(len(line.spans)):
        for i, j, mass, station in pairs:
            n = _node_of(line, station)
            a, b = built.chains[i][k][n], built.chains[j][k][n]
            length = float(np.linalg.norm(np.subtract(ops.nodeCoord(a), ops.nodeCoord(b))))
            built.truss(a, b, STIFF * length, length, mass)
            for tag in (a, b):
                built.load(tag, NOTHING, (0.0, -0.5 * mass * line.gravity, 0.0))


def settle(built: Built, steps: int = 1) -> None:
    """Equilibrium (Newton): weight of the strung state at once, later loads in equal steps."""
    for number, series, loads in ((1, "Constant", built.loads), (2, "Linear", built.later)):
        ops.timeSeries(series, number)
        ops.pattern("Plain", number, number)
        for tag, force in loads.items():
            if force.any():
                ops.load(tag, *force.tolist())
    analysis("Static", 1e-10, "LoadControl", 1.0 / steps)
    assert ops.analyze(steps) == 0, "no equilibrium"
    ops.loadConst("-time", 0.0)


def analysis(kind: str, tolerance: float, *integrator: object) -> None:
    ops.wipeAnalysis()
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", tolerance, 100)
    ops.algorithm("Newton")
    ops.integrator(*integrator)
    ops.analysis(kind)


def frequencies(built: Built, count: int) -> tuple[Array, Array]:
    """Frequencies [Hz] and shapes (mode, node of `built.free`, 3), scaled to 1."""
    values = np.array(ops.eigen("-genBandArpack", count))
    shapes = np.array(
        [[ops.nodeEigenvector(tag, mode + 1) for tag in built.free] for mode in range(count)]
    )
    shapes /= np.abs(shapes).max(axis=(1, 2), keepdims=True)
    return np.sqrt(values) / (2.0 * np.pi), shapes


def planes(built: Built, count: int) -> tuple[Array, Array]:
    """In-plane and out-of-plane frequencies [Hz] of a single conductor."""
    found, shapes = frequencies(built, count)
    across = np.abs(shapes[:, :, 2]).max(axis=1) > 0.5
    return found[~across], found[across]


def families(built: Built, count: int) -> dict[str, Array]:
    """Frequencies [Hz] of a bundle of one span by family, from its centre and its turn."""
    found, shapes = frequencies(built, count)
    place = {tag: i for i, tag in enumerate(built.free)}
    offsets = np.array(built.line.conductors)
    offsets -= offsets.mean(axis=0)
    radius = float(np.sqrt((offsets**2).sum(axis=1).mean()))
    kept: dict[str, list[float]] = {"vertical": [], "horizontal": [], "torsion": []}
    for frequency, shape in zip(found, shapes, strict=True):
        moved = np.array(
            [[shape[place[tag]] for tag in chains[0][1:-1]] for chains in built.chains]
        )
        turn = np.einsum("c,cn->n", offsets[:, 0], moved[:, :, 2])
        turn -= np.einsum("c,cn->n", offsets[:, 1], moved[:, :, 1])
        size = {
            "vertical": np.abs(moved[:, :, 1].mean(axis=0)).max(),
            "horizontal": np.abs(moved[:, :, 2].mean(axis=0)).max(),
            "torsion": np.abs(turn).max() / (radius * len(offsets)),
        }
        kept[max(size, key=lambda family: size[family])].append(frequency)
    return {family: np.array(values) for family, values in kept.items()}


def displacement(tag: int) -> Array:
    return np.array(ops.nodeDisp(tag))


def pulse(
    built: Built,
    place: int,
    force: tuple[float, float, float],
    law: Callable[[Array], Array],
    step: float,
    duration: float,
    every: int,
    watched: list[int],
) -> Array:
    """Free vibration after a force at a node: times, then u1 u2 u3 of each watched node (Newmark).

    Displacements count from the equilibrium in which the analysis starts.
    """
    start = np.concatenate([displacement(tag) for tag in watched])
    times = step * np.arange(round(duration / step) + 2)
    ops.timeSeries("Path", 3, "-dt", step, "-values", *law(times).tolist(), "-useLast")
    ops.pattern("Plain", 3, 3)
    ops.load(place, *force)
    analysis("Transient", 1e-8, "Newmark", 0.5, 0.25)
    rows = [np.zeros(1 + 3 * len(watched))]
    for record in range(1, round(duration / (step * every)) + 1):
        assert ops.analyze(every, step) == 0, f"no convergence near {record * every * step} s"
        moved = np.concatenate([displacement(tag) for tag in watched]) - start
        rows.append(np.concatenate([[record * every * step], moved]))
    return np.array(rows)
