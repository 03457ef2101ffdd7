"""The section ``[aerodynamics]``: any kind of coefficient curve."""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from gallop_fmu.scene.assumed_coefficients import AssumedCoefficients
from gallop_fmu.scene.packaged_coefficients import PackagedCoefficients
from gallop_fmu.scene.polynomial_coefficients import PolynomialCoefficients
from gallop_fmu.scene.table_coefficients import TableCoefficients

Aerodynamics = Annotated[
    PolynomialCoefficients | TableCoefficients | PackagedCoefficients | AssumedCoefficients,
    Field(discriminator="kind"),
]
"""Any kind of coefficient curve; in a scene file, ``kind`` selects it."""
