"""The time integrators: what each is, its order and its stability.  The one table that scene, command line, provenance,
documentation and tests read."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Integrator:
    """One way to step in time.

    Attributes
    ----------
    name
        Value of ``numerics.integrator``.
    code
        Number by which the kernel knows it, ``gallop_integrator``.
    order
        Order of displacement and velocity of smooth motion.
    acceleration_order
        Order of accelerations, and of what inertia adds to the support forces.
    unconditionally_stable
        Whether linear motion stays bounded at every step size.
    spectral_radius
        Factor a step at which undamped linear motion grows or decays, at every step size; 1 keeps its energy.
    description
        One line: the method and how its equations are solved.
    """

    name: str
    code: int
    order: int
    acceleration_order: int
    unconditionally_stable: bool
    spectral_radius: float
    description: str


INTEGRATORS = {
    integrator.name: integrator
    for integrator in (
        Integrator("newmark", 0, 2, 2, True, 1.0, "Newmark (beta 1/4, gamma 1/2), Newton-Raphson with reused tangent"),
        Integrator("gauss6", 1, 6, 3, True, 1.0, "Gauss collocation (3 stages), Newton-Raphson with reused tangent"),
    )
}
"""By name."""
