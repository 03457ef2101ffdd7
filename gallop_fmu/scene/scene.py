"""The validated description of one iced span of an overhead line."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.aerodynamics import Aerodynamics
from gallop_fmu.scene.conductor import Conductor, Ice
from gallop_fmu.scene.consistency import check_consistency, unusual_combinations
from gallop_fmu.scene.damping import Damping
from gallop_fmu.scene.fields import Number, Section, Text, quantity, setting
from gallop_fmu.scene.front_ends import resolved
from gallop_fmu.scene.loads import Load
from gallop_fmu.scene.run_settings import Initial, Numerics, Run
from gallop_fmu.scene.scene_base import SceneBase
from gallop_fmu.scene.shedding import SpanShedding
from gallop_fmu.scene.stations import shed_stations
from gallop_fmu.scene.supports import Supports
from gallop_fmu.scene.wind import Wind


class Span(Section):
    """Geometry and initial state, from the sag, the horizontal tension, or both prescribed."""

    length: Number = quantity(..., "m", "horizontal distance between the supports", gt=0, le=10000)
    height_difference: Number = quantity(0.0, "m", "height of the right support above the left")
    sag: Number | None = quantity(
        None, "m", "sag at mid-span, measured vertically from the chord", gt=0
    )
    horizontal_tension: Number | None = quantity(
        None, "N", "horizontal tension of the initial state", gt=0
    )
    gravity: Number = quantity(9.81, "m/s2", "acceleration of gravity", gt=0, le=100)

    @model_validator(mode="after")
    def _determined(self) -> Span:
        if self.sag is None and self.horizontal_tension is None:
            raise SceneError(
                "neither sag nor horizontal_tension is given, so the initial state is unknown; give"
                " sag [m] or horizontal_tension [N]"
            )
        if abs(self.height_difference) >= self.length:
            raise SceneError(
                f"height_difference = {self.height_difference} must be less than length ="
                f" {self.length} m either way"
            )
        return self

    @property
    def initial_state(self) -> Literal["from_sag", "from_tension", "held"]:
        """Source of the initial equilibrium: sag, tension, or both (``"held"``: prescribed)."""
        if self.horizontal_tension is None:
            return "from_sag"
        return "from_tension" if self.sag is None else "held"


class Scene(SceneBase):
    """One span: structure, loads, numerics, and the source of each value."""

    span: Span = setting(..., "geometry and initial state")
    conductor: Conductor = setting(..., "conductor")
    ice: Ice = setting(Ice(), "ice")
    wind: Wind = setting(Wind(speed=0.0), "wind")
    aerodynamics: Aerodynamics | None = setting(None, "coefficient curve; required with wind")
    supports: Supports = setting(Supports(), "supports")
    damping: Damping = setting(Damping(), "structural damping")
    loads: Annotated[tuple[Load, ...], Field(strict=False)] = setting((), "concentrated loads")
    shedding: Annotated[tuple[SpanShedding, ...], Field(strict=False)] = setting(
        (), "ice that falls during the run"
    )
    initial: Initial = setting(Initial(), "start of the motion")
    numerics: Numerics = setting(Numerics(), "discretisation and tolerances")
    run: Run = setting(Run(), "duration and recording")
    sources: dict[Text, Text] = setting({}, "dotted path of a value or section to its source")

    def _key_figures(self) -> str:
        return f"span of {self.span.length:g} m, wind {self.wind.mean_speed:g} m/s"

    @property
    def length(self) -> float:
        """Horizontal distance [m] between the ends."""
        return self.span.length

    @property
    def elements(self) -> int:
        """Number of elements of the mesh, also the number of the node at mid-span.

        It is `numerics.elements`, or one more if that is odd and a part of the span loses its ice:
        mid-span is then between two elements.
        """
        odd = self.numerics.elements % 2 if shed_stations(self) else 0
        return self.numerics.elements + odd

    @classmethod
    def _tables(cls, data: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
        """Return the data with a table ``line`` resolved."""
        if "section" in data:
            raise SceneError(
                "section: the data describe a section of several spans, and Scene is one span; use"
                " LineScene.from_dict, or load_scene for a file"
            )
        return resolved(data, folder)

    def _check(self) -> None:
        check_consistency(self)

    def _unusual_combinations(self) -> list[str]:
        return unusual_combinations(self)
