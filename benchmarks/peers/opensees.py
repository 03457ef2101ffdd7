"""OpenSees: corotational trusses through OpenSeesPy; Newmark, or central differences (lumped mass).

Initial strains hold the hanging shape; each truss has the modulus that gives engineering strain on
its rest length. OpenSees has no aerodynamic load: in the galloping scene Python computes it at the
nodes from their velocities, before every step, extrapolated linearly to its end (a load that lags a
step behind would make the scheme of first order).
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable

import numpy as np
from cases import Case, NotReachedError
from chain import Chain, chain, section_force
from opensees_wheel import load
from scenes import INTERVAL, LOADED_POINTS, Array, Problem

STEPS = (0.05, 0.025, 0.0125, 0.005, 0.0025, 0.001, 0.0005, 0.00025)
EXPLICIT_STEPS = (4e-4, 2e-4)


ops = load()


def cases(problem: Problem) -> list[Case]:
    windy = problem.wind is not None
    found = [
        Case(
            "OpenSees",
            family,
            f"step {step:g} s",
            ("chain", consistent),
            prepare(problem, step, consistent),
        )
        for family, consistent in (
            ("OpenSees, Newmark, consistent mass", True),
            ("OpenSees, Newmark, lumped mass", False),
        )
        for step in (STEPS[:5] if windy else STEPS)
    ]
    family = "OpenSees, central differences, lumped mass"
    for step in (
        () if windy else EXPLICIT_STEPS
    ):  # 20 s of CPU time a run with aerodynamic loads in Python
        found.append(
            Case(
                "OpenSees",
                family,
                f"step {step:g} s",
                ("chain", False),
                prepare(problem, step, False, explicit=True),
            )
        )
    return found


def prepare(
    problem: Problem,
    step: float,
    consistent: bool,
    *,
    explicit: bool = False,
    elements: int = LOADED_POINTS + 1,
) -> Callable[[], Callable[[], Array]]:
    every = round(INTERVAL / step)
    step = INTERVAL / every

    def prepared() -> Callable[[], Array]:
        span = chain(problem, elements)
        middle = _span(problem, span, step, consistent)
        _analysis(step, explicit)
        if problem.wind is None:
            return lambda: _still_air(problem, step, every, middle)
        return _wind(problem, span, step, every, consistent)

    return prepared


def _span(problem: Problem, span: Chain, step: float, consistent: bool) -> int:
    """Nodes, trusses, weight and point loads; returns the mid-span node."""
    nodes = span.position.shape[1]
    ops.wipe()
    ops.model("basic", "-ndm", 3, "-ndf", 3)
    for i, x in enumerate(span.position.T):
        ops.node(i + 1, *map(float, x))
    for end in (1, nodes):
        ops.fix(end, 1, 1, 1)
    for e, length in enumerate(np.linalg.norm(np.diff(span.position, axis=1), axis=0), 1):
        ops.uniaxialMaterial("Elastic", e, span.stiffness * length / span.rest)
        ops.uniaxialMaterial("InitStrainMaterial", 1000 + e, e, (length - span.rest) / length)
        density = span.node_mass / length
        options = ("-rho", density, "-cMass", int(consistent), "-doRayleigh", 1)
        ops.element("corotTruss", e, e, e + 1, 1.0, 1000 + e, *options)
    ops.timeSeries("Constant", 1)
    ops.pattern("Plain", 1, 1)
    for i in range(2, nodes):
        ops.load(i, 0.0, -span.weight, 0.0)
    times = step * np.arange(round(problem.stop_time / step) + 2)
    ops.timeSeries("Path", 2, "-dt", step, "-values", *problem.law.at(times).tolist(), "-useLast")
    ops.pattern("Plain", 2, 2)
    for i in range(2, nodes):
        ops.load(i, *span.load[:, i - 1].tolist())
    if problem.mass_damping:
        ops.rayleigh(problem.mass_damping, 0.0, 0.0, 0.0)
    return nodes // 2 + 1


def _analysis(step: float, explicit: bool) -> None:
    ops.constraints("Plain")
    ops.numberer("Plain")  # the chain is already in order
    if explicit:
        ops.system("Diagonal", "lumped")
        ops.algorithm("Linear")
        ops.integrator("CentralDifference")
    else:
        ops.system("BandSPD")
        # 1e-6 m is enough for large steps and saves an iteration; small ones need more to show
        # their order
        ops.test("NormDispIncr", 1e-6 if step >= 0.005 else 1e-8 if step >= 0.001 else 1e-10, 25)
        ops.algorithm("Newton")
        ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")


def _still_air(problem: Problem, step: float, every: int, middle: int) -> Array:
    out = np.empty((len(problem.times), 2))
    for record in range(len(out)):
        if ops.analyze(every, step):
            raise NotReachedError(f"OpenSees fails at {ops.getTime():.3f} s")
        out[record] = ops.nodeDisp(middle, 2), ops.nodeDisp(middle, 3)
    return out


def _wind(
    problem: Problem, span: Chain, step: float, every: int, consistent: bool
) -> Callable[[], Array]:
    nodes = span.position.shape[1]
    inner, middle = range(2, nodes), nodes // 2 + 1
    shares = span.tributary.tolist()
    section_force(0.0, 0.0, span)  # compiled before the clock runs

    normals = span.normal.T.tolist()

    def forces() -> list[tuple[float, float, float]]:
        found = []
        for i in inner:
            (n1, n2), share = normals[i - 1], shares[i - 1]
            across = n1 * ops.nodeVel(i, 1) + n2 * ops.nodeVel(i, 2)
            up, along = section_force(across, ops.nodeVel(i, 3), span)
            found.append((n1 * up * share, n2 * up * share, along * share))
        return found

    now = forces()
    for i, start in zip(
        inner, _accelerations(np.array(now), span.node_mass, consistent), strict=True
    ):
        for direction in (1, 2, 3):  # OpenSees itself would start without acceleration
            ops.setNodeAccel(i, direction, float(start[direction - 1]), "-commit")

    def advance() -> Array:
        before, out, pattern = now, np.empty((len(problem.times), 2)), 3
        for record in range(len(out)):
            for _ in range(every):
                here = forces()
                with contextlib.suppress(Exception):
                    ops.remove("loadPattern", pattern)
                ops.pattern("Plain", pattern, 1)
                for i, force, old in zip(inner, here, before, strict=True):
                    ops.load(i, *(2.0 * a - b for a, b in zip(force, old, strict=True)))
                before = here
                if ops.analyze(1, step):
                    raise NotReachedError(f"OpenSees fails at {ops.getTime():.3f} s")
            out[record] = ops.nodeDisp(middle, 2), ops.nodeDisp(middle, 3)
        return out

    return advance


def _accelerations(force: Array, node_mass: float, consistent: bool) -> Array:
    count = len(force)
    mass = node_mass * np.eye(count)
    if consistent:
        mass = node_mass / 6.0 * (4.0 * np.eye(count) + np.eye(count, k=1) + np.eye(count, k=-1))
    return np.linalg.solve(mass, force)
