"""gallop-fmu: its integrators over steps or tolerances, and its meshes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from cases import OURS, Case, NotReached
from gallop_fmu.channels import NODE_INDEX
from gallop_fmu.engine import DOFS, Model
from gallop_fmu.outcome import Outcome
from scenes import INTERVAL, Array, Problem

STEPS = (0.05, 0.025, 0.0125, 0.01, 0.005, 0.0025, 0.00125, 0.0005, 0.00025, 0.0001)


@dataclass(frozen=True)
class Variant:
    """One curve: scene values, one of which runs through a list.  `nodes` 41 shows the temporal error too."""

    family: str
    swept: str
    through: tuple[float, ...]
    values: dict[str, Any] = field(default_factory=dict)
    nodes: int = 41


VARIANTS = [
    Variant("Newmark", "numerics.time_step", STEPS),
    Variant("Newmark, 21 nodes", "numerics.time_step", STEPS[:6], nodes=21),
    Variant("Newmark, 81 nodes", "numerics.time_step", STEPS[2:7], nodes=81),
]
"""A further integrator is a line here."""


def cases(problem: Problem) -> list[Case]:
    return [
        Case(
            OURS,
            f"{OURS}, {variant.family}",
            f"{variant.swept.split('.')[-1].replace('_', ' ')} {value:g}",
            (OURS, variant.nodes) if variant.nodes == 41 else None,
            _prepare(problem, _scene_values(variant) | {variant.swept: value}),
        )
        for variant in VARIANTS
        for value in variant.through
    ]


def _scene_values(variant: Variant) -> dict[str, Any]:
    return {"numerics.elements": variant.nodes // 2, "numerics.newton_tolerance": 1e-11} | variant.values


def _prepare(problem: Problem, values: dict[str, Any]) -> Callable[[], Callable[[], Array]]:
    def prepare() -> Callable[[], Array]:
        scene = problem.scene.with_values(values)
        model = Model(scene)
        state = model.start()
        channels = np.array([NODE_INDEX["u2"], NODE_INDEX["u3"]], dtype=np.int32)
        nodes = np.array([model.middle], dtype=np.int32)
        every = round(INTERVAL / scene.numerics.time_step)

        def advance() -> Array:
            run = state.run(len(problem.times), every, channels, nodes)
            if run.report.outcome is not Outcome.COMPLETED:
                raise NotReached(str(run.report))
            return run.node_values[:, :, 0]

        return advance

    return prepare


def converged(problem: Problem) -> Array:
    """The equations of the 41-node mesh, solved by an integrator that is not ours: scipy's DOP853 to 1e-11.

    The kernel gives residual and mass matrix; with neither ice nor twist the mass matrix is constant.
    """
    model = Model(problem.scene.with_values({"numerics.elements": 20}))
    size, inner = DOFS * model.nodes, slice(DOFS, DOFS * (model.nodes - 1))
    mass = np.zeros((size, size))
    for element, block in enumerate(model.tangent(mass=1.0)):
        place = slice(2 * DOFS * element, 2 * DOFS * element + 3 * DOFS)
        mass[place, place] += block
    inverse = np.linalg.inv(mass[inner, inner])
    unknowns = inverse.shape[0]
    u, v = np.zeros(size), np.zeros(size)

    def slope(time: float, y: Array) -> Array:
        u[inner], v[inner] = y[:unknowns], y[unknowns:]
        residual = model.residual(u, v, time=time).reshape(-1)[inner]
        return np.concatenate([y[unknowns:], -inverse @ residual])

    found = solve_ivp(
        slope, (0.0, problem.stop_time), np.zeros(2 * unknowns), "DOP853", problem.times, rtol=1e-10, atol=1e-12
    )
    if not found.success:
        raise NotReached(found.message)
    middle = DOFS * (model.middle - 1)
    return found.y[[middle + 1, middle + 2]].T
