"""A packaged coefficient curve by its name."""

from __future__ import annotations

from typing import Literal

from pydantic import field_validator

from gallop_fmu.scene.aerodynamic_curve import AerodynamicCurve, Outside
from gallop_fmu.scene.curve_catalogue import CurveEntry, find_curve
from gallop_fmu.scene.curve_fields import OUTSIDE_MEANING, RADIUS_MEANING
from gallop_fmu.scene.fields import Number, Section, Text, quantity, setting
from gallop_fmu.scene.polynomial_coefficients import PolynomialCoefficients
from gallop_fmu.scene.table_coefficients import TableCoefficients


class PackagedCoefficients(Section):
    """A packaged curve by its name; `gallop-fmu curves` lists them with source and limits."""

    kind: Literal["packaged"] = setting("packaged", "kind of coefficient curve")
    name: Text = setting(..., "name of the curve; `gallop-fmu curves` lists them")
    outside: Outside | None = setting(None, f"{OUTSIDE_MEANING} (default: that of the curve)")
    reference_radius: Number | None = quantity(None, "m", RADIUS_MEANING, gt=0)

    @field_validator("name")
    @classmethod
    def _is_known(cls, name: str) -> str:
        return find_curve(name).name

    @property
    def entry(self) -> CurveEntry:
        """The curve with its source and limits."""
        return find_curve(self.name)

    def explicit(self) -> PolynomialCoefficients | TableCoefficients:
        """Return the same curve with its numbers."""
        data = {**self.entry.data, "reference_radius": self.reference_radius}
        if self.outside is not None:
            data["outside"] = self.outside
        if data["kind"] == "polynomial":
            return PolynomialCoefficients.model_validate(data)
        return TableCoefficients.model_validate(data)

    @property
    def beyond(self) -> Outside:
        """Rule outside the validity range."""
        return self.explicit().beyond

    @property
    def range_deg(self) -> tuple[float, float]:
        """Validity range [deg]."""
        return self.explicit().range_deg

    @property
    def label(self) -> str:
        """Name and status of the curve."""
        return f"{self.name}, {self.entry.status}: {self.entry.title}"

    def warnings(self) -> list[str]:
        """Warning about a curve that is not published, and those about its numbers."""
        found = self.explicit().warnings()
        if self.entry.status != "published":
            found.append(
                f"aerodynamics.name = {self.name!r}: the curve is {self.entry.status}, not"
                " measured; use measured coefficients for design"
            )
        return found

    def curve(self) -> AerodynamicCurve:
        """Return the curve."""
        return self.explicit().curve()
