"""The cases of `total.py`: every code on several meshes, with steps or tolerances that suit."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any

import chain
import explicit
import general_solvers
import moordyn_line
import opensees
import ours
import total_lines
from cases import OURS, Case
from scenes import INTERVAL, Array, Problem, example1, galloping

STEPS = (0.05, 0.025, 0.0125, 0.01, 0.005, 0.0025, 0.00125)
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5)
OUR_ELEMENTS = (5, 10, 15, 20, 30, 40)

STABLE_STEP = 4.5e-4
"""Step [s] of the explicit chain of 40 elements, 5 % below its limit."""

CHAINS = {"example1": (40, 80, 120, 160, 240), "galloping": (40, 80, 120, 160, 240, 360, 520)}
SOLVERS = {"example1": (40, 80, 160), "galloping": (40, 80, 160, 320)}
RADAU = (1e-2, 1e-3, 1e-4)
CVODE = (1e-4, 1e-5, 1e-6, 1e-7)
OPENSEES = {40: (0.05, 0.025, 0.0125), 80: (0.025, 0.0125, 0.005), 160: (0.0125, 0.005)}
MOORDYN = {40: (5e-4, 0.01), 80: (2.5e-4, 0.01)}

COARSE = 320
"""Elements of the coarser of the two chains that give the reference of a span."""

Scene = tuple[str, float, Any, list[Case]]
"""Title, stop time [s], reference, cases."""


def scene(name: str, portable: bool) -> Scene:
    """Return a scene of `total.py`; `portable` chooses the arithmetic of gallop-fmu."""
    if name == "temporal":
        return _temporal(portable)
    if name in ("section", "twin"):
        line = total_lines.section() if name == "section" else total_lines.twin()
        return (
            line.title,
            line.stop_time,
            total_lines.reference(line),
            total_lines.cases(line, portable),
        )
    problem = example1() if name == "example1" else galloping()
    reference = chain.extrapolated(problem, COARSE, 5e-5)
    return problem.title, problem.stop_time, reference, _span_cases(problem, portable)


def _numerics(elements: int, values: dict[str, Any], portable: bool) -> dict[str, Any]:
    return {
        f"numerics.{key}": value
        for key, value in {"elements": elements, "portable": portable, **values}.items()
    }


def fixed_step(step: float) -> dict[str, Any]:
    """A step with a Newton tolerance that is small compared with its error."""
    return {"time_step": step, "newton_tolerance": max(1e-6 * (step / 0.05) ** 2, 1e-12)}


def _span_cases(problem: Problem, portable: bool) -> list[Case]:
    found = []
    for elements in OUR_ELEMENTS:
        variants = [("Newmark", f"step {step:g} s", fixed_step(step)) for step in STEPS]
        variants += [
            ("tolerance", f"tolerance {t:g}", {"time_step": INTERVAL, "tolerance": t})
            for t in TOLERANCES
        ]
        for family, setting, values in variants:
            name = f"{elements} elements, {setting}"
            advance = ours.prepare(problem, _numerics(elements, values, portable))
            found.append(Case(OURS, f"{OURS}, {family}", name, None, advance))
    for elements in CHAINS[problem.name]:
        step = STABLE_STEP * 40 / elements
        advance = explicit.prepare(problem, chain.velocity_verlet, step, elements)
        name = f"{elements} elements, step {1e6 * step:.3g} us"
        found.append(Case("numba", "numba, velocity Verlet", name, None, advance))
    for elements in SOLVERS[problem.name]:
        for rtol in CVODE:
            options = {"method": "BDF", "max_order": 2}
            advance = general_solvers.cvode(problem, rtol, options, elements)
            name = f"{elements} elements, tolerance {rtol:g}"
            found.append(Case("CVODE", "CVODE, BDF to order 2", name, None, advance))
        for rtol in RADAU:
            advance = general_solvers.radau(problem, rtol, elements)
            name = f"{elements} elements, tolerance {rtol:g}"
            found.append(Case("Radau", "scipy, Radau", name, None, advance))
    for elements, steps in OPENSEES.items():
        for step in steps:
            for mass in ("consistent", "lumped"):
                advance = opensees.prepare(problem, step, mass == "consistent", elements=elements)
                name = f"{elements} elements, step {step:g} s"
                found.append(Case("OpenSees", f"OpenSees, {mass} mass", name, None, advance))
    if problem.wind is None:
        found += [
            Case(
                "MoorDyn",
                "MoorDyn, Runge-Kutta 4",
                f"{segments} elements, step {1e3 * step:g} ms",
                None,
                lambda setting=(*setting, segments): moordyn_line.prepare(problem, *setting),
            )
            for segments, setting in MOORDYN.items()
            for step in setting[:1]
        ]
    return found


def _temporal(portable: bool) -> Scene:
    """Example 1, 41 nodes, against the same mesh converged in time; without costly settings."""
    problem = example1()
    reference: dict[Hashable, Array] = {
        (OURS, 41): ours.converged(problem),
        ("chain", False): explicit.converged(problem, consistent=False),
        ("chain", True): explicit.converged(problem, consistent=True),
    }
    cases = [case for case in ours.cases(problem, portable) if case.model]
    cases += [*explicit.cases(problem), *general_solvers.cases(problem)]
    cases += [
        Case(
            "OpenSees",
            "OpenSees, consistent mass",
            f"step {step:g} s",
            ("chain", True),
            opensees.prepare(problem, step, consistent=True),
        )
        for step in opensees.STEPS[:5]
    ]
    return "Example 1, 41 nodes: error in time", problem.stop_time, reference, cases
