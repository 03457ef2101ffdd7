"""The time integrators: what each is, its order and its stability.

The one table that packing, provenance and tests read.  Measured on example 3 (15 elements): Newmark
is the cheaper one down to errors of about 0.3 %, Gauss below that.  Where a rough start makes axial
modes ring that no step resolves, Newmark has to halve its steps on fine meshes; the
generalised-alpha method lets them decay and goes on.  Methods that were tried and are not here, as
one of these is as good or better everywhere: Gauss with 2 stages, Lobatto IIIA of orders 4 and 6,
Radau IIA of order 5.

Explicit central differences were estimated, not tried.  A three-node bar of length l with Lobatto's
mass has the largest eigenvalue 24 c^2 / l^2, c = sqrt(EA/m), so steps end at 2 l / (sqrt(24) c);
damping b2 in proportion to the stiffness shortens them by sqrt(1 + x^2) - x, x = b2 sqrt(6) c / l.
At a measured cost of 1.10 and 0.65 us of an evaluation alone,

* example 3: 0.87 ms without damping, 0.080 ms with it, so 12500 steps or 14 ms a simulated second,
  against some 0.2 ms by Newmark within 0.5 %: no case for it;
* example 1, undamped: 0.39 ms, so 2550 steps or 1.7 ms, against 0.6 to 1.3 ms by Gauss at errors of
  5e-3 to 1e-3 after a jump of the load.  Where an undamped span must be followed closely after a
  jump, it would hold its own.
"""

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
        Factor a step on undamped linear motion that is infinitely fast; 1: energy is kept at every
        step size.
    amplitude_error
        Largest relative error of a steady amplitude, times the number of steps in a period to the
        power `order`, of three limit cycles of examples 2 and 3 with 6 to 100 steps in a period
        (`benchmarks/accuracy/time_step.py`). It is that of the 2:1 swing, which long steps detune; other
        motions are less sensitive.
    description
        One line: the method and how its equations are solved.
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
"""Of the generalised-alpha method, unless ``numerics.spectral_radius`` is given."""

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
