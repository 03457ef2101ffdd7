"""Two lines for the total error: a section of three spans and a twin bundle, in a rising wind.

The iced conductor, curve and damping of Liu et al. (2009), Example 2, with twist. The line hangs at
rest in still air, and the wind rises smoothly in four seconds from a tenth of its speed (an attack
angle needs some wind). Peers: the lumped chain of
`line_lumped.py` with explicit steps, and the same by CVODE. OpenSees and MoorDyn cannot compute
these scenes: their trusses and lines have no twist, and their loads no lift.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import line_lumped as lumped
import numpy as np
from cases import Case, NotReachedError
from line_galloping import CURVE_2, DAMPING_2, EXAMPLE_2, scene_of
from line_march import accelerate, compiled
from line_sampler import polygon
from scenes import INTERVAL, Array
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import reverse_cuthill_mckee
from sksundae.cvode import CVODE

import gallop_fmu as gf
from gallop_fmu.engine.model import Model
from gallop_fmu.foundation.channels import NODE_INDEX
from gallop_fmu.foundation.outcome import Outcome

SPEED = 8.0
"""Wind speed [m/s]; the motions have some decimetres."""

RISE = 4.0
"""Time [s] in which the wind rises."""

CALM = 0.1
"""Wind at the start over its speed later."""

FINE = 160
"""Elements of a span whose bars give the lengths of the strings without load."""

SHARE = 0.95
"""Step of the explicit chain over its stability limit; nothing is gained by a smaller one."""

FREQUENCIES = (1.0, 10.0)
"""Frequencies [Hz] of the two ratios that state a damping proportional to mass."""


@dataclass(frozen=True)
class LineProblem:
    """A line; `case` has the elements of a span of the coarsest chain."""

    name: str
    title: str
    stop_time: float
    case: lumped.Case
    span: int

    @property
    def records(self) -> int:
        return round(self.stop_time / INTERVAL)


def section() -> LineProblem:
    case = lumped.Case(
        conductor=EXAMPLE_2,
        tension=21e3,
        spans=(120.0, 150.0, 130.0),
        rises=(2.0, -3.0, 1.0),
        strings=((2.0, 490.0), (2.0, 490.0)),
        wind=replace(CURVE_2, speed=SPEED),
        damping=DAMPING_2,
        elements=20,
        seed=(0.0, 0.0),
    )
    title = "Section of three spans on strings, iced, in a wind that rises to 8 m/s"
    return LineProblem("section", title, 10.0, case, 1)


def twin() -> LineProblem:
    case = lumped.Case(
        conductor=EXAMPLE_2,
        tension=21e3,
        spans=(130.0,),
        wind=replace(CURVE_2, speed=SPEED),
        damping=DAMPING_2,
        conductors=polygon(2, 0.4),
        frames=tuple(lumped.Frame((k + 1) / 5.0, 500.0) for k in range(4)),
        elements=20,
        seed=(0.0, 0.0),
    )
    title = "Twin bundle with four spacers, iced, in a wind that rises to 8 m/s"
    return LineProblem("twin", title, 20.0, case, 0)


# ---- gallop-fmu ----


def scene(problem: LineProblem, elements: int, numerics: dict[str, Any]) -> gf.LineScene:
    """The line as gallop-fmu reads it; strings as stiff as those of the chain."""
    words = scene_of(problem.case)
    rests = lumped.build(replace(problem.case, elements=FINE)).tables.string_rest
    conductor = dict(words["conductor"])
    del conductor["mass_per_rest_length"]
    low, high = FREQUENCIES
    data: dict[str, Any] = {
        "title": problem.title,
        "section": {
            "horizontal_tension": words["horizontal_tension"],
            "gravity": words["gravity"],
            "spans": words["spans"],
            "suspensions": [
                {
                    "kind": "string",
                    "length": float(rest),
                    "weight": string["weight"],
                    "stiffness": lumped.STIFF,
                    "damping": 0.0,
                }
                for string, rest in zip(words["strings"], rests, strict=True)
            ],
        },
        "conductor": conductor,
        "ice": words["ice"],
        "aerodynamics": {
            **{key: words["aerodynamics"][key] for key in ("kind", "lift", "drag", "moment")},
            "valid_from_deg": -60.0,
            "valid_to_deg": 80.0,
        },
        "wind": {
            "air_density": words["wind"]["air_density"],
            "history": {"kind": "ramp", "initial": CALM * SPEED, "final": SPEED, "duration": RISE},
        },
        "damping": {
            name: {
                "low_ratio": b1 / (4.0 * np.pi * low),
                "low_frequency": low,
                "high_ratio": b1 / (4.0 * np.pi * high),
                "high_frequency": high,
            }
            for name, b1 in zip(("translation", "twist"), problem.case.damping, strict=True)
        },
        "initial": {"seed_vertical": 0.0, "seed_horizontal": 0.0},
        "numerics": {"elements": elements, **numerics},
    }
    if "bundle" in words:
        data["bundle"] = {
            "subconductors": words["bundle"]["subconductors"],
            "offsets": words["bundle"]["offsets_x2_x3"],
            "stations": words["bundle"]["spacers_at"],
            "clamp_torsional_stiffness": words["bundle"]["clamp_torsional_stiffness"],
        }
    return gf.LineScene.from_dict(data)


def ours(problem: LineProblem, elements: int, numerics: dict[str, Any]) -> Callable[[], Any]:
    def prepare() -> Callable[[], Array]:
        made = scene(problem, elements, numerics)
        model = Model(made)
        state = model.start()
        count = len(problem.case.conductors)
        middles = [model.map.chains[problem.span * count + k].middle for k in range(count)]
        channels = np.array([NODE_INDEX["u2"], NODE_INDEX["u3"]], dtype=np.int32)
        every = round(INTERVAL / made.numerics.time_step)
        nodes, none = np.array(middles, dtype=np.int32), np.empty(0, dtype=np.int32)

        def advance() -> Array:
            run = state.run(problem.records, every, channels, nodes, none)
            if run.report.outcome is not Outcome.COMPLETED:
                raise NotReachedError(str(run.report))
            return run.node_values.mean(axis=2)

        return advance

    return prepare


# ---- the lumped chain ----


def _model(problem: LineProblem, elements: int) -> tuple[lumped.Model, Array]:
    model = lumped.build(replace(problem.case, elements=elements))
    count = len(problem.case.conductors)
    return model, np.array([model.middle(k, problem.span) for k in range(count)], np.int64)


@compiled
def _set_wind(t, full, time):
    x = min(time / RISE, 1.0)
    rise = x * x * x * (10.0 - 15.0 * x + 6.0 * x * x)
    for k in range(3):
        t.wind[k] = full[k] * (CALM + (1.0 - CALM) * rise)


@compiled
def march(u, v, t, full, step, every, records, watched):
    """Velocity Verlet as in line_march.py, in the rising wind; mean u2, u3 of the watched nodes."""
    nodes = u.shape[0]
    a, guess, f = np.zeros((nodes, 4)), np.zeros((nodes, 4)), np.zeros((nodes, 4))
    out = np.zeros((records, 2))
    _set_wind(t, full, 0.0)
    accelerate(u, v, t, True, f, a)
    for record in range(records):
        for number in range(every):
            for i in range(nodes):
                for k in range(4):
                    v[i, k] += 0.5 * step * a[i, k]
                    u[i, k] += step * v[i, k]
                    guess[i, k] = v[i, k] + 0.5 * step * a[i, k]
            _set_wind(t, full, (record * every + number + 1) * step)
            accelerate(u, guess, t, True, f, a)
            for i in range(nodes):
                for k in range(4):
                    v[i, k] += 0.5 * step * a[i, k]
        for node in watched:
            for k in range(2):
                out[record, k] += u[node, k + 1] / watched.shape[0]
    return out


def explicit(problem: LineProblem, elements: int, share: float = SHARE) -> Callable[[], Any]:
    def prepare() -> Callable[[], Array]:
        model, watched = _model(problem, elements)
        step = lumped.largest_step(model.case) / 0.6 * share
        every = int(np.ceil(INTERVAL / step))
        u, v = model.seed.copy(), np.zeros((len(model.tables.x), 4))
        full = model.tables.wind.copy()
        march(u.copy(), v.copy(), model.tables, full, 1e-6, 1, 1, watched)  # compiled

        def advance() -> Array:
            step = INTERVAL / every
            out = march(u, v, model.tables, full, step, every, problem.records, watched)
            if not np.isfinite(out).all():
                raise NotReachedError("the step is too long")
            return out

        return advance

    return prepare


def reference(problem: LineProblem, coarse: int = FINE) -> Array:
    """Chain extrapolated to zero mesh size (order 2), from `coarse` and twice the elements."""
    once, twice = (explicit(problem, n, 0.6)()() for n in (coarse, 2 * coarse))
    return (4.0 * twice - once) / 3.0


@compiled
def _slope(time, y, t, full, order, work, out):
    """y' of the chain, with eight unknowns a node in `order`; work: u, v, f, a."""
    u, v, f, a = work
    _set_wind(t, full, time)
    for place in range(order.shape[0]):
        node = order[place]
        for k in range(4):
            u[node, k] = y[8 * place + k]
            v[node, k] = y[8 * place + 4 + k]
    accelerate(u, v, t, True, f, a)
    for place in range(order.shape[0]):
        node = order[place]
        for k in range(4):
            out[8 * place + k] = v[node, k]
            out[8 * place + 4 + k] = a[node, k]


def _ordered(tables: lumped.Tables) -> tuple[Array, int]:
    """Order of the nodes with a small band, and the bandwidth in nodes."""
    pairs = [*zip(tables.left, tables.right, strict=True)]
    for group in (*tables.frame_node, *tables.string_node):
        pairs += [(i, j) for i in group for j in group if i < j]
    i, j = np.array(pairs).T
    size = len(tables.x)
    graph = coo_matrix((np.ones(2 * len(i)), (np.r_[i, j], np.r_[j, i])), (size, size)).tocsr()
    order = reverse_cuthill_mckee(graph, symmetric_mode=True).astype(np.int64)
    place = np.empty(size, np.int64)
    place[order] = np.arange(size)
    return order, int(np.abs(place[i] - place[j]).max())


def cvode(problem: LineProblem, elements: int, rtol: float) -> Callable[[], Any]:
    """CVODE, BDF to order 2, banded Jacobian by its own differences."""

    def prepare() -> Callable[[], Array]:
        model, watched = _model(problem, elements)
        tables = model.tables
        order, band = _ordered(tables)
        size = len(order)
        work = tuple(np.zeros((size, 4)) for _ in range(4))
        start = np.zeros(8 * size)
        full = tables.wind.copy()
        _slope(0.0, start, tables, full, order, work, np.empty(8 * size))
        solver = CVODE(
            lambda time, y, out: _slope(time, y, tables, full, order, work, out),
            linsolver="band",
            lband=8 * band + 7,
            uband=8 * band + 7,
            rtol=rtol,
            atol=1e-2 * rtol,
            max_num_steps=10**6,
            method="BDF",
            max_order=2,
        )
        places = [8 * int(np.flatnonzero(order == node)[0]) for node in watched]
        times = INTERVAL * np.arange(problem.records + 1)

        def advance() -> Array:
            found = solver.solve(times, start)
            if not found.success:
                raise NotReachedError(found.message)
            return np.mean([found.y[1:, [at + 1, at + 2]] for at in places], axis=0)

        return advance

    return prepare


def cases(problem: LineProblem, portable: bool) -> list[Case]:
    """All cases of a line; families are codes with a method."""
    found = []
    for elements in (5, 10, 15, 20, 30):
        for step in (0.05, 0.025, 0.0125, 0.01, 0.005, 0.0025):
            numerics = {
                "time_step": step,
                "newton_tolerance": max(1e-6 * (step / 0.05) ** 2, 1e-12),
                "portable": portable,
            }
            name = f"{elements} elements, step {step:g} s"
            advance = ours(problem, elements, numerics)
            found.append(Case("gallop-fmu", "gallop-fmu, Newmark", name, None, advance))
        for tolerance in (1e-1, 1e-2, 1e-3, 1e-4, 1e-5):
            numerics = {"time_step": INTERVAL, "tolerance": tolerance, "portable": portable}
            name = f"{elements} elements, tolerance {tolerance:g}"
            advance = ours(problem, elements, numerics)
            found.append(Case("gallop-fmu", "gallop-fmu, tolerance", name, None, advance))
    for elements in (10, 20, 30, 40, 60, 80):
        name = f"{elements} elements"
        advance = explicit(problem, elements)
        found.append(Case("numba", "numba, velocity Verlet", name, None, advance))
    for elements in (10, 20, 40, 80):
        for rtol in (1e-3, 1e-4, 1e-5):
            name = f"{elements} elements, tolerance {rtol:g}"
            advance = cvode(problem, elements, rtol)
            found.append(Case("CVODE", "CVODE, BDF to order 2", name, None, advance))
    return found
