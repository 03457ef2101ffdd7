"""Declaration of the fields of a scene: finite numbers with unit, meaning and range."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

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

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_rules import clean_text

Number = StrictFloat
"""A finite number; texts and truth values are refused, not converted."""


def _whole(value: Any) -> Any:
    return int(value) if isinstance(value, float) and value.is_integer() else value


WholeNumber = Annotated[StrictInt, BeforeValidator(_whole)]
"""A whole number; 15.0 is accepted, as tables with empty cells store whole numbers so."""

Text = Annotated[str, AfterValidator(clean_text)]
"""A text without control characters, see `gallop_fmu.foundation.text_rules`."""

UNIT_OF_OWNER = "of the driven quantity"
"""Unit of the values of a law: the unit of its field, such as m/s for ``wind.history``."""


_OF_PYDANTIC = frozenset(name for name in dir(BaseModel) if not name.startswith("__"))

if TYPE_CHECKING:
    from pydantic._internal._model_construction import ModelMetaclass as _OwnNames
else:

    class _OwnNames(type(BaseModel)):
        """Hides pydantic's names in ``dir`` of a class, which IPython shows for objects, too."""

        def __dir__(cls) -> list[str]:
            return [name for name in super().__dir__() if name not in _OF_PYDANTIC]


class Section(BaseModel, metaclass=_OwnNames):
    """A table of the scene file: immutable, without unknown keys, NaN or infinity."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    def __setattr__(self, name: str, value: Any) -> None:
        self._refuse_change(name)

    def __delattr__(self, name: str) -> None:
        self._refuse_change(name)

    def _refuse_change(self, name: str) -> None:
        raise SceneError(
            f"{type(self).__name__}.{name} cannot be changed: a scene stays as it is; make a"
            ' changed copy, such as scene.with_values({"wind.speed": 6.0})'
        )

    def __dir__(self) -> list[str]:
        """Names for completion: those of this program, without pydantic's."""
        return [name for name in super().__dir__() if name not in _OF_PYDANTIC]


def quantity(default: Any, unit: str, meaning: str, **bounds: float) -> Any:
    """Declare a field of numbers, or of a law.

    Parameters
    ----------
    default
        Default value; ``...`` makes the field required.
    unit
        SI unit, ``"deg"`` for fields that end in ``_deg``, ``"1"`` for pure numbers.
    meaning
        One phrase for documentation and error messages.
    **bounds
        ``gt``, ``ge``, ``lt``, ``le``, ``min_length``, ``max_length``.
    """
    return Field(  # type: ignore[call-overload]
        default, description=meaning, json_schema_extra={"unit": unit}, **bounds
    )


def setting(default: Any, meaning: str) -> Any:
    """Declare a field without a unit: a text, a choice or a section."""
    return Field(default, description=meaning)


def unit_of_field(field: FieldInfo) -> str:
    """Return the unit of a `quantity`, or an empty text for a `setting`."""
    extra = field.json_schema_extra
    return str(extra["unit"]) if isinstance(extra, dict) and "unit" in extra else ""
