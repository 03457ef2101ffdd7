"""gallop-fmu: its integrators over steps or tolerances, and its meshes."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from cases import OURS, Case, NotReachedError
from scenes import INTERVAL, Array, Problem

from gallop_fmu.engine.model import DOFS, Model
from gallop_fmu.foundation.channels import NODE_INDEX
from gallop_fmu.foundation.outcome import Outcome

STEPS = (0.05, 0.025, 0.0125, 0.01, 0.005, 0.0025, 0.00125, 0.0005, 0.00025, 0.0001)

GAUSS_STEPS = (0.05, 0.025, 0.05 / 3, 0.0125, 0.01, 0.005)

REFERENCE_STEP = 2.5e-4
"""Step [s] of the converged solution; on example 1, DOP853 to 1e-10 gives the same five digits."""


@dataclass(frozen=True)
class Variant:
    """One curve: scene values, one of which runs through a list.

    `nodes` 41 also gives temporal errors.

    `newton` gives the Newton tolerance [m] for a step: small compared with the error of the step,
    and no smaller.
    """

    family: str
    swept: str
    through: tuple[float, ...]
    values: dict[str, Any] = field(default_factory=dict)
    nodes: int = 41
    newton: Callable[[float], float] = lambda step: max(1e-6 * (step / 0.05) ** 2, 1e-12)


GAUSS = {"numerics.integrator": "gauss6"}
TOLERANCES = (1e-1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6, 1e-7, 1e-8)

VARIANTS = [
    Variant("Newmark", "numerics.time_step", STEPS),
    Variant("Newmark, 21 nodes", "numerics.time_step", STEPS[:6], nodes=21),
    Variant("Newmark, 81 nodes", "numerics.time_step", STEPS[2:7], nodes=81),
    Variant(
        "Gauss 6",
        "numerics.time_step",
        GAUSS_STEPS,
        GAUSS,
        newton=lambda step: 5e-8 * (step / 0.05) ** 4,
    ),
    Variant("tolerance", "numerics.tolerance", TOLERANCES, {"numerics.time_step": INTERVAL}),
]
"""A further integrator is a line here."""


def cases(problem: Problem, portable: bool = False) -> list[Case]:
    return [
        Case(
            OURS,
            f"{OURS}, {variant.family}",
            f"{variant.swept.split('.')[-1].replace('_', ' ')} {value:g}",
            (OURS, variant.nodes) if variant.nodes == 41 else None,
            prepare(problem, {**_scene_values(variant, value), "numerics.portable": portable}),
        )
        for variant in VARIANTS
        for value in variant.through
    ]


def _scene_values(variant: Variant, value: float) -> dict[str, Any]:
    values = {"numerics.elements": variant.nodes // 2, **variant.values, variant.swept: value}
    if variant.swept == "numerics.time_step":
        values["numerics.newton_tolerance"] = variant.newton(value)
    return values


def prepare(problem: Problem, values: dict[str, Any]) -> Callable[[], Callable[[], Array]]:
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
                raise NotReachedError(str(run.report))
            return run.node_values[:, :, 0]

        return advance

    return prepare


def converged(problem: Problem) -> Array:
    """The equations of the 41-node mesh by Runge-Kutta of order 4, just below its stability limit.

    The kernel gives residual and mass matrix; with neither ice nor twist the mass matrix is
    constant.
    """
    model = Model(problem.scene.with_values({"numerics.elements": 20}))
    size, inner = DOFS * model.nodes, slice(DOFS, DOFS * (model.nodes - 1))
    mass = np.zeros((size, size))
    for element, block in enumerate(model.tangent(mass=1.0)):
        place = slice(2 * DOFS * element, 2 * DOFS * element + 3 * DOFS)
        mass[place, place] += block
    inverse = np.linalg.inv(mass[inner, inner])
    u, v, a = np.zeros((3, size))

    def acceleration(time: float, u: Array, v: Array) -> Array:
        residual = model.residual(u, v, time=time).reshape(-1)
        a[inner] = -inverse @ residual[inner]
        return a

    every, out = round(INTERVAL / REFERENCE_STEP), []
    h = INTERVAL / every
    for step in range(len(problem.times) * every):
        time = step * h
        a1 = acceleration(time, u, v).copy()
        v2 = v + 0.5 * h * a1
        a2 = acceleration(time + 0.5 * h, u + 0.5 * h * v, v2).copy()
        v3 = v + 0.5 * h * a2
        a3 = acceleration(time + 0.5 * h, u + 0.5 * h * v2, v3).copy()
        v4 = v + h * a3
        a4 = acceleration(time + h, u + h * v3, v4)
        u = u + h / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
        v = v + h / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        if (step + 1) % every == 0:
            out.append(u[[DOFS * model.middle + 1, DOFS * model.middle + 2]])
    return np.array(out)
