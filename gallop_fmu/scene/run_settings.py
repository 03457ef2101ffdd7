"""Start of the motion, discretisation, duration and recording."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.integrators import SPECTRAL_RADIUS
from gallop_fmu.scene.fields import Number, Section, WholeNumber, quantity, setting


class Initial(Section):
    """Start of the motion: a small first-mode perturbation, and the initial action of the wind."""

    seed_vertical: Number = quantity(
        0.0, "m", "amplitude a of u2 = a cos(pi x1/L), x1 from mid-span"
    )
    seed_horizontal: Number = quantity(
        0.0, "m", "amplitude a of u3 = a cos(pi x1/L), x1 from mid-span"
    )
    seed_twist: Number = quantity(
        0.0, "rad", "amplitude a of the twist a cos(pi x1/L), x1 from mid-span"
    )
    wind: Literal["at_once", "mean_wind_equilibrium"] = setting(
        "at_once",
        "wind at the start: applied suddenly to the conductor at rest, or in static equilibrium",
    )


class Numerics(Section):
    """Discretisation and tolerances."""

    elements: WholeNumber = quantity(15, "1", "number of three-node elements", ge=2, le=5000)
    integrator: Literal["newmark", "gauss6", "generalised_alpha"] | None = setting(
        None,
        "integrator, see gallop_fmu.foundation.integrators (default: newmark; with a tolerance"
        " gauss6)",
    )
    time_step: Number = quantity(
        0.01,
        "s",
        "inner time step (with numerics.tolerance: unit of run.record_every)",
        gt=0,
        le=1,
    )
    tolerance: Number | None = quantity(
        None,
        "1",
        "relative error of vertical motion, horizontal motion and twist; controls the step size in"
        " place of time_step",
        ge=1e-8,
        le=0.1,
    )
    spectral_radius: Number | None = quantity(
        None,
        "1",
        "amplification factor of generalised_alpha per step for unresolved motion (default:"
        f" {SPECTRAL_RADIUS})",
        ge=0,
        le=1,
    )
    newton_tolerance: Number = quantity(
        1e-9,
        "m",
        "change that ends Newton's iteration; not used with numerics.tolerance",
        ge=1e-14,
        le=1e-3,
    )
    max_newton_iterations: WholeNumber = quantity(
        20, "1", "maximum number of iterations before a step is halved", ge=2, le=200
    )
    max_halvings: WholeNumber = quantity(
        8, "1", "maximum number of halvings of a step before the run fails", ge=0, le=20
    )
    portable: bool = setting(
        False,
        "true: the same bits on every x86-64 processor; false: fused multiply-add where the"
        " processor has AVX-512, about 1.2 times as fast, with results that differ by rounding",
    )

    @model_validator(mode="before")
    @classmethod
    def _whole_span(cls, data: Any) -> Any:
        """Accept the key `mesh` of release 0.1.0 if it is ``"whole_span"``."""
        if not isinstance(data, dict) or "mesh" not in data:
            return data
        if data["mesh"] != "whole_span":
            raise SceneError(
                f"mesh = {data['mesh']!r}: only whole spans are computed, as half a span excludes"
                " motion in 2, 4, ... loops; remove mesh"
            )
        return {key: value for key, value in data.items() if key != "mesh"}

    @model_validator(mode="after")
    def _fits_the_integrator(self) -> Numerics:
        if self.tolerance is not None and self.integrator not in (None, "gauss6"):
            raise SceneError(
                f'tolerance = {self.tolerance}: integrator = "{self.integrator}" takes equal steps;'
                ' choose "gauss6"'
            )
        if self.spectral_radius is not None and self.integrator != "generalised_alpha":
            raise SceneError(
                f'spectral_radius = {self.spectral_radius}: only integrator = "generalised_alpha"'
                " has one; choose it, or remove spectral_radius"
            )
        return self

    @property
    def method(self) -> Literal["newmark", "gauss6", "generalised_alpha"]:
        """The given or default integrator."""
        return self.integrator or ("newmark" if self.tolerance is None else "gauss6")


class Run(Section):
    """Duration and recording."""

    stop_time: Number = quantity(60.0, "s", "simulated time", gt=0)
    record_every: WholeNumber = quantity(
        1, "1", "number of time steps from one record to the next", ge=1, le=1_000_000
    )
