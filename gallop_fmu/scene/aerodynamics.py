"""The section ``[aerodynamics]``: any kind of coefficient curve."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from gallop_fmu.scene.polynomial_coefficients import PolynomialCoefficients
from gallop_fmu.scene.table_coefficients import TableCoefficients

Aerodynamics = Annotated[PolynomialCoefficients | TableCoefficients, Field(discriminator="kind")]
"""Either form of coefficient curve; in a scene file, ``kind`` selects it."""
