"""What every section of a scene has in common: strict finite numbers, each with a unit, a meaning and a range."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    StrictFloat,
    StrictInt,
)
from pydantic.fields import FieldInfo

from gallop_fmu.foundation.text_rules import clean_text

Number = StrictFloat
"""A finite number; text and true/false are refused instead of converted."""


def _whole(value: Any) -> Any:
    return int(value) if isinstance(value, float) and value.is_integer() else value


WholeNumber = Annotated[StrictInt, BeforeValidator(_whole)]
"""A whole number; 15.0 is one too, since tables with empty cells hold whole numbers so."""

Text = Annotated[str, AfterValidator(clean_text)]
"""A text that every file type and terminal can show, see `gallop_fmu.foundation.text_rules`."""

DRIVEN = "of the driven quantity"
"""Unit of a law's values: that of whatever field holds the law, such as m/s for ``wind.history``."""


class Section(BaseModel):
    """A table of the scene file: cannot be changed, knows all its keys, holds no NaN and no infinity."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


def quantity(default: Any, unit: str, meaning: str, **bounds: float) -> Any:
    """Declare a field that holds numbers, or a law that drives one.

    Parameters
    ----------
    default
        Value when the scene does not set the field; ``...`` makes it required.
    unit
        SI unit, ``"deg"`` for fields that end in ``_deg``, ``"1"`` for pure numbers.
    meaning
        One phrase for documentation and error messages.
    **bounds
        ``gt``, ``ge``, ``lt``, ``le``, ``min_length``, ``max_length``.
    """
    return Field(default, description=meaning, json_schema_extra={"unit": unit}, **bounds)  # type: ignore[call-overload]


def setting(default: Any, meaning: str) -> Any:
    """Declare a field without a unit: a text, a choice or a section."""
    return Field(default, description=meaning)


def unit_of_field(field: FieldInfo) -> str:
    """Unit given to `quantity`, or an empty text for a `setting`."""
    extra = field.json_schema_extra
    return str(extra["unit"]) if isinstance(extra, dict) and "unit" in extra else ""
