"""The conductor and the ice on it."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import BeforeValidator, model_validator

from gallop_fmu.scene.fields import Number, Section, quantity, setting


class Conductor(Section):
    """The conductor; without ice, unless the scene's sources say that a value includes it."""

    diameter: Number = quantity(
        ..., "m", "diameter of the bare conductor, reference of the coefficients", gt=0, le=1
    )
    mass_per_length: Number = quantity(
        ..., "kg/m", "mass per unit length of the hanging conductor", gt=0
    )
    axial_stiffness: Number = quantity(..., "N", "axial stiffness EA", gt=0)
    torsional_stiffness: Number = quantity(..., "N m2/rad", "torsional stiffness GJ", gt=0)
    torsional_inertia: Number = quantity(
        ..., "kg m", "mass moment of inertia per unit length about x1", gt=0
    )
    slack: Literal["error", "tension_only"] = setting(
        "error",
        "at zero tension: end the run with an error, or continue with a slack conductor",
    )


class Ice(Section):
    """Ice on the conductor: mass, moments, and attack angle."""

    mass_per_length: Number = quantity(0.0, "kg/m", "mass of ice per unit length", ge=0)
    torsional_inertia: Number = quantity(
        0.0, "kg m", "moment of inertia of ice per unit length about x1", ge=0
    )
    first_moment_x2: Number = quantity(
        0.0, "kg", "first moment of the ice's mass in x2, upwards (S_x3 of Liu et al. 2009)"
    )
    first_moment_x3: Number = quantity(
        0.0, "kg", "first moment of the ice's mass in x3, downwind (S_x2 of Liu et al. 2009)"
    )
    attack_angle_deg: Number = quantity(
        0.0,
        "deg",
        "initial attack angle of the wind on the ice; also rotates the first moments",
        ge=-360,
        le=360,
    )
    first_moment_angle_deg: Number | None = quantity(
        None,
        "deg",
        "attack angle of the given first moments (default: attack_angle_deg of the same file)",
        ge=-360,
        le=360,
    )

    @model_validator(mode="before")
    @classmethod
    def _keep_angle_of_moments(cls, data: Any) -> Any:
        """Store the attack angle of the first moments; a later change of it rotates them."""
        if not isinstance(data, dict) or data.get("first_moment_angle_deg") is not None:
            return data
        if not (data.get("first_moment_x2") or data.get("first_moment_x3")):
            return data
        return {**data, "first_moment_angle_deg": data.get("attack_angle_deg", 0.0)}

    def first_moments(self, attack_angle: ArrayLike | None = None) -> tuple[Any, Any]:
        """Return the first mass moments of the ice at an attack angle [rad] (default: initial).

        Returns
        -------
        tuple
            Integrals of rho x2 dA and of rho x3 dA [kg], of the shape of `attack_angle`. A larger
            attack angle rotates the section like a twist.
        """
        given = np.radians(
            self.attack_angle_deg
            if self.first_moment_angle_deg is None
            else self.first_moment_angle_deg
        )
        rotation = (
            np.radians(self.attack_angle_deg) if attack_angle is None else np.asarray(attack_angle)
        ) - given
        sine, cosine = np.sin(rotation), np.cos(rotation)
        return (
            self.first_moment_x2 * cosine - self.first_moment_x3 * sine,
            self.first_moment_x2 * sine + self.first_moment_x3 * cosine,
        )


def _bare(ice: Any) -> Any:
    return Ice() if ice == "none" else ice


OwnIce = Annotated[Ice | None, BeforeValidator(_bare)]
"""Ice of a part of a line; None: as around it, and ``"none"`` in a scene file: bare."""
