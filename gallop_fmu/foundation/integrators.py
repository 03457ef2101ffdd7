"""The time integrators with their order and stability: the one table for all uses.

Measured on example 3 (15 elements), Newmark is cheaper for errors above about 0.3 %, Gauss below.
After a discontinuous start, axial modes oscillate that no step resolves: Newmark then halves its
steps on fine meshes, while the generalised-alpha method damps these modes. Gauss with 2 stages,
Lobatto IIIA of orders 4 and 6, and Radau IIA of order 5 were tried; one of the methods here is
better or equal in every case.

Explicit central differences were estimated only. A three-node bar of length l with Lobatto mass has
the largest eigenvalue 24 c^2 / l^2 with c = sqrt(EA/m), so the step is at most 2 l / (sqrt(24) c);
stiffness-proportional damping b2 reduces it by sqrt(1 + x^2) - x with x = b2 sqrt(6) c / l. With
the measured cost of 1.10 and 0.65 us for one evaluation,

* example 3: steps of 0.87 ms without damping, 0.080 ms with it: 12500 steps or 14 ms for one
  simulated second, against about 0.2 ms with Newmark within 0.5 %;
* example 1, undamped: steps of 0.39 ms: 2550 steps or 1.7 ms, against 0.6 to 1.3 ms with Gauss at
  errors of 5e-3 to 1e-3 after a jump of the load. For an undamped span after a jump the explicit
  method would be competitive.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Integrator:
    """A time integrator.

    Attributes
    ----------
    name
        Value of ``numerics.integrator``.
    code
        Its number in the kernel, ``gallop_integrator``.
    order
        Order of displacement and velocity for smooth motion.
    acceleration_order
        Order of accelerations, and of the inertial part of the support forces.
    unconditionally_stable
        Linear motion stays bounded at every step size.
    spectral_radius
        Amplification factor per step of undamped linear motion of infinite frequency; 1: energy is
        conserved at every step size.
    amplitude_error
        Error constant C: the relative error of a steady amplitude is at most C / n^`order` with n
        steps in a period; from three limit cycles of examples 2 and 3 with 6 to 100 steps in a
        period (`benchmarks/accuracy/time_step.py`). The 2:1 swing determines it, as long steps
        detune it; other motions are less sensitive.
    description
        One line: the method and the solution of its equations.
    """

    name: str
    code: int
    order: int
    acceleration_order: int
    unconditionally_stable: bool
    spectral_radius: float
    amplitude_error: float
    description: str


SPECTRAL_RADIUS = 0.9
"""Default ``numerics.spectral_radius`` of the generalised-alpha method."""

INTEGRATORS = {
    integrator.name: integrator
    for integrator in (
        Integrator(
            "newmark",
            0,
            2,
            2,
            True,
            1.0,
            23.0,
            "Newmark (beta 1/4, gamma 1/2), Newton-Raphson with reused tangent",
        ),
        Integrator(
            "generalised_alpha",
            2,
            2,
            1,
            True,
            SPECTRAL_RADIUS,
            29.0,
            "generalised-alpha (Chung, Hulbert 1993), Newton-Raphson with reused tangent",
        ),
        Integrator(
            "gauss6",
            1,
            6,
            3,
            True,
            1.0,
            100.0,
            "Gauss collocation (3 stages), Newton-Raphson with reused tangent",
        ),
    )
}
"""By name."""
