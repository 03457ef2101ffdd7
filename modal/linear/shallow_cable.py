"""Frequencies of a shallow elastic cable in closed form, a check of the finite elements.

H. M. Irvine and T. K. Caughey (1974), Proc. R. Soc. A 341, 299-315; H. M. Irvine (1981), Cable
Structures, chapter 3, for inclined spans. What the theory leaves out is of the order of the squared
ratio of sag to span: the change of tension along the span, the longitudinal inertia, and the
difference between parabola and catenary. Eccentric ice is not included.

Relative difference of the first symmetric vertical frequency from that of the finite elements, on a
span of 100 m without eccentric ice; a spring is 80 kN/m along and 2 kN/m across the span:

============================  ========  ========  ========  ========
ends, difference of height    sag 0.4%  sag 1 %   sag 2 %   sag 4 %
============================  ========  ========  ========  ========
rigid, 0 to 25 m              0.002 %   0.003 %   0.01 %    0.16 %
rigid, 50 m                   0.001 %   0.005 %   0.13 %    0.12 %
springs at both ends, 0       0.005 %   0.03 %    0.04 %    0.27 %
springs at both ends, 25 m    0.08 %    0.01 %    0.02 %    0.23 %
springs at both ends, 50 m    0.30 %    0.10 %    0.04 %    0.06 %
spring at one end, 0          0.003 %   0.02 %    0.16 %    0.36 %
spring at one end, 10 m       0.11 %    0.29 %    0.67 %    0.52 %
spring at one end, 25 m       0.26 %    0.65 %    1.3 %     0.85 %
spring at one end, 50 m       0.44 %    1.0 %     2.1 %     1.9 %
============================  ========  ========  ========  ========

On a slope an end on a spring also moves across the chord, which the theory leaves out: it is for
level spans, and for inclined ones between rigid ends or equal springs. The horizontal frequency is
within 0.1 % everywhere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from gallop_fmu import Model, Scene, SceneError
from gallop_fmu.input.scene_like import SpanLike, as_span
from gallop_fmu.scene.supports import RigidSupport
from modal.foundation import one_span as instead
from modal.foundation.root_finding import bracketed_root

CROSSOVER = 4.0 * math.pi**2
"""lambda^2 at which the first symmetric and the first antisymmetric in-plane frequency are equal.
Between rigid ends they are then twice the first out-of-plane one: the 2:1 internal resonance."""


@dataclass(frozen=True)
class ShallowCable:
    """Irvine's theory of one span.

    Attributes
    ----------
    horizontal_tension, sag : float
        Static state [N], [m], from the scene or by the parabola from the other one.
    lambda_squared : float
        Ratio of elastic to geometric stiffness, with the springs along x1 in series with the cable.
    horizontal_hz, vertical_symmetric_hz, vertical_antisymmetric_hz, torsional_hz : float
        First natural frequency [Hz] of each family.
    """

    horizontal_tension: float
    sag: float
    lambda_squared: float
    horizontal_hz: float
    vertical_symmetric_hz: float
    vertical_antisymmetric_hz: float
    torsional_hz: float

    @property
    def ratio(self) -> float:
        """First symmetric vertical over first horizontal frequency."""
        return self.vertical_symmetric_hz / self.horizontal_hz

    @property
    def beyond_crossover(self) -> bool:
        """True if the first symmetric in-plane mode is faster than the first antisymmetric one.

        It then has inner nodes.
        """
        return self.lambda_squared > CROSSOVER


def shallow_cable(scene: SpanLike) -> ShallowCable:
    r"""First frequencies of a span from its numbers alone.

    With mass m per length, chord l = L/cos(slope), tension T = H/cos(slope) along the chord, and
    weight m g cos(slope) across it, the parabola has a parameter s = m g l cos(slope)/T, and

    - lambda^2 = s^2 l / (T f), where f = Le/EA + (1/k1 + 1/k2) cos(slope)^2 is the flexibility of
      cable and end springs along the span, and Le = l (1 + s^2/8);
    - symmetric in plane: tan x = x - 4 x^3/lambda^2, frequency x sqrt(T/m)/(pi l);
    - antisymmetric in plane: sqrt(T/m)/l, whatever the springs along x1;
    - out of plane, between springs k of stiffness along x3: b l = pi - arctan(T b/k1) - arctan(T
      b/k2), frequency b sqrt(T/m)/(2 pi), which is sqrt(T/m)/(2 l) between rigid ends;
    - twist: sqrt(GJ/I)/(2 S), with S the length of the conductor.

    Where a scene holds both sag and tension, s follows from the sag and T from the tension, as in
    the simulation.

    Parameters
    ----------
    scene
        The span; wind, loads and first moments of the ice have no effect.

    Returns
    -------
    ShallowCable

    Raises
    ------
    SceneError
        If the sag is more than an eighth of the span: the theory is for shallow cables.
    SimulationError
        If a support has springs and no initial equilibrium exists.
    """
    scene = as_span(scene, "shallow_cable", instead.CLOSED_FORM)
    span, conductor = scene.span, scene.conductor
    mass = conductor.mass_per_length + scene.ice.mass_per_length
    cosine = span.length / math.hypot(span.length, span.height_difference)
    chord, weight = span.length / cosine, mass * span.gravity
    sag, tension = span.sag, span.horizontal_tension
    if tension is None:
        assert sag is not None  # the scene has one of them
        tension = weight * span.length**2 / (8.0 * sag * cosine)
    elif sag is None:
        sag = weight * span.length**2 / (8.0 * tension * cosine)
    if not sag < span.length / 8.0:
        raise SceneError(
            f"the sag of {sag:.4g} m is more than an eighth of span.length = {span.length} m:"
            " Irvine's theory is for shallow cables; use modal.natural_modes(scene)"
        )
    along = tension / cosine
    parameter = 8.0 * sag * cosine / chord
    left, right = _support_stiffness(scene)
    stretched = chord * (1.0 + parameter**2 / 8.0)
    flexibility = (
        stretched / conductor.axial_stiffness + (1.0 / left[0] + 1.0 / right[0]) * cosine**2
    )
    lambda_squared = parameter**2 * chord / (along * flexibility)
    speed = math.sqrt(along / mass)
    inertia = conductor.torsional_inertia + scene.ice.torsional_inertia
    arc = chord * (1.0 + parameter**2 / 24.0)
    return ShallowCable(
        horizontal_tension=tension,
        sag=sag,
        lambda_squared=lambda_squared,
        horizontal_hz=_string(along, chord, left[1], right[1]) * speed / (2.0 * math.pi),
        vertical_symmetric_hz=symmetric_root(lambda_squared) * speed / (math.pi * chord),
        vertical_antisymmetric_hz=speed / chord,
        torsional_hz=math.sqrt(conductor.torsional_stiffness / inertia) / (2.0 * arc),
    )


def lambda_squared_for(ratio: float) -> float:
    """The lambda^2 at which the symmetric in-plane over the out-of-plane frequency is `ratio`.

    The ends are rigid. From tan x = x - 4 x^3/lambda^2 with x = pi ratio/2.

    Parameters
    ----------
    ratio
        Between 1 (a taut string) and 2.86 (an inextensible cable); 2 gives 4 pi^2.

    Raises
    ------
    SceneError
        If no lambda^2 gives this ratio.
    """
    x = 0.5 * math.pi * ratio
    most = bracketed_root(lambda y: math.sin(y) - y * math.cos(y), math.pi, 1.5 * math.pi) / (
        0.5 * math.pi
    )
    if not 1.0 < ratio < most:
        raise SceneError(f"ratio = {ratio}: between rigid ends it lies between 1 and {most:.4f}")
    return 4.0 * x**3 * math.cos(x) / (x * math.cos(x) - math.sin(x))


def _support_stiffness(scene: Scene) -> list[tuple[float, float]]:
    """Stiffness [N/m] of both supports along x1 and x3, as in the simulation; infinite if rigid."""
    supports = (scene.supports.left, scene.supports.right)
    if all(isinstance(support, RigidSupport) for support in supports):
        return [(math.inf, math.inf)] * 2
    return [
        (math.inf, math.inf) if isinstance(support, RigidSupport) else (float(k1), float(k3))
        for support, (k1, k3) in zip(
            supports, Model(scene).equilibrium().support_stiffness, strict=True
        )
    ]


def symmetric_root(lambda_squared: float) -> float:
    """First root x = w l/(2 c) of tan x = x - 4 x^3/lambda^2, times cos x to remove the poles."""

    def closed(x: float) -> float:
        return lambda_squared * (x * math.cos(x) - math.sin(x)) - 4.0 * x**3 * math.cos(x)

    return bracketed_root(closed, 0.5 * math.pi, 1.5 * math.pi)


def _string(tension: float, length: float, left: float, right: float) -> float:
    """First wave number of a string between springs across it [1/m]."""

    def phase(b: float) -> float:
        return b * length + math.atan(tension * b / left) + math.atan(tension * b / right) - math.pi

    return bracketed_root(phase, 0.0, math.pi / length)
