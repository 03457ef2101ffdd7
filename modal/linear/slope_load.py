"""Matrices of the load on sections that a slope of the coefficient curve adds.

Where lift or moment has a slope p at the attack angle of the mean wind, a small motion changes the
load on each section in proportion to p and to the change of its attack angle,

    change of alpha = theta + (w3 dw2 - w2 dw3) / (w2^2 + w3^2),    dw2 = -v2 - r omega, dw3 = -v3.

Hence the damping and stiffness of small motion are C + p C1 and K + p K1. C1 is proportional to the
wind speed, K1 to its square.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Model, Scene
from gallop_fmu.engine.mesh import SECTIONS, Mesh

if TYPE_CHECKING:
    from scipy.sparse import csc_array

Array = NDArray[np.float64]
Coefficient = Literal["lift", "moment"]

REACH_DEG = 1.0
"""Half the validity range [deg] of a sloped curve, which is evaluated in its middle only."""


def straight_curve(
    scene: Scene | LineScene, drag: float, lift_slope: float = 0.0, moment_slope: float = 0.0
) -> dict[str, Any]:
    """Curve with constant drag, and with lift and moment that are straight lines through 0 deg.

    Parameters
    ----------
    scene
        A scene; if it has a curve, its reference radius is kept.
    drag
        Drag coefficient.
    lift_slope, moment_slope
        Slopes [1/rad].

    Returns
    -------
    dict
        Section ``aerodynamics`` of a scene.
    """
    radius = None if scene.aerodynamics is None else scene.aerodynamics.reference_radius
    return {
        "kind": "polynomial",
        "valid_from_deg": -REACH_DEG,
        "valid_to_deg": REACH_DEG,
        "outside": "hold",
        "lift": [0.0, lift_slope],
        "drag": [drag],
        "moment": [0.0, moment_slope],
        "reference_radius": radius,
    }


@dataclass(frozen=True)
class SlopeLoad:
    """Matrices of all unknowns per unit slope [1/rad], in a wind of 1 m/s.

    Attributes
    ----------
    damping, stiffness : sparse array, shape (4 node, 4 node)
        C1 and K1 of the module.
    """

    damping: csc_array
    stiffness: csc_array

    @classmethod
    def of(cls, base: Mesh, coefficient: Coefficient, drag: float) -> SlopeLoad:
        """Matrices of a slope of the lift or of the moment.

        Parameters
        ----------
        base
            Span or line whose curve has the drag coefficient `drag` and no slopes. Intervals with a
            curve of their own keep it, so that they have no part in the matrices.
        coefficient
            Coefficient that has the slope.
        drag
            Drag coefficient.
        """
        scene = base.model.scene
        changed = scene.with_values(
            {"aerodynamics": straight_curve(scene, drag, **{f"{coefficient}_slope": 1.0})}
        )
        sloped = Mesh(Model(changed))
        by_element = [
            _derivatives(sloped, element) - _derivatives(base, element)
            for element in range(base.model.elements)
        ]
        slopes = np.array(by_element).transpose(0, 3, 1, 2)  # element, section, motion, load
        motion = section_motion(base)
        length = base.sections.length.reshape(-1, SECTIONS)
        by_twist = np.einsum(
            "ep,epia,epi,epb->eab", length, motion, slopes[:, :, 0], motion[:, :, 2]
        )
        by_rates = np.einsum("ep,epia,epji,epjb->eab", length, motion, slopes[:, :, 1:], motion)
        return cls(
            damping=base.gather(base.assemble(-by_rates)),
            stiffness=base.gather(base.assemble(-by_twist)),
        )


def section_motion(mesh: Mesh) -> Array:
    """Motion of sections along n2, x3 and twist (axis 2) per unknown of their element (axis 3).

    Returns
    -------
    ndarray, shape (element, 3, 3, 12)
    """
    sections = mesh.sections
    normal = sections.normal.reshape(-1, SECTIONS, 2)
    motion = np.zeros((len(normal), SECTIONS, 3, 3, 4))  # element, section, part, node, unknown
    motion[:, :, 0, :, :2] = sections.shape[None, :, :, None] * normal[:, :, None, :]
    motion[:, :, 1, :, 2] = sections.shape
    motion[:, :, 2, :, 3] = sections.shape
    return motion.reshape(len(normal), SECTIONS, 3, 12)


def _derivatives(mesh: Mesh, element: int) -> Array:
    """Derivatives (motion, load, section) of the load on an element in a wind of 1 m/s.

    By theta, v2, v3 and omega, at 0 deg, the middle of the validity range.
    """
    zero = np.zeros(SECTIONS)
    load = mesh.aero_load(zero, 0.0, 0.0, 0.0, 1.0, attack_angle=0.0, slopes=True, element=element)
    assert load.slopes is not None  # asked for
    return load.slopes
