"""The validated description of a line: a tension section with bundles, phases and devices."""

from __future__ import annotations

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.foundation.text_rules import counted
from gallop_fmu.scene.aerodynamics import Aerodynamics
from gallop_fmu.scene.bundle import Bundle
from gallop_fmu.scene.conductor import Conductor, Ice
from gallop_fmu.scene.damping import Damping
from gallop_fmu.scene.devices import Device
from gallop_fmu.scene.fields import Number, Text, quantity, setting
from gallop_fmu.scene.line_consistency import check_line, unusual_in_line
from gallop_fmu.scene.loads import LineLoad
from gallop_fmu.scene.phases import Phase
from gallop_fmu.scene.run_settings import Initial, Numerics, Run
from gallop_fmu.scene.sag_tension import tension_of_sag
from gallop_fmu.scene.scene import Scene
from gallop_fmu.scene.scene_base import SceneBase
from gallop_fmu.scene.shedding import Shedding
from gallop_fmu.scene.tension_section import TensionSection
from gallop_fmu.scene.time_functions import Law
from gallop_fmu.scene.wind import Wind

ONE_SPAN_TABLES = {
    "line": "line data describe one span; give the values of the section (gallop-fmu new --section"
    " makes them from a table of towers)",
    "span": "a section has its spans in section.spans; remove [span], or [section] for one span",
    "supports": "a section has section.left_end, section.right_end and section.suspensions; remove"
    " [supports]",
}
"""Tables of the scene of one span to what a line has in their place."""


class LineConductor(Conductor):
    """One subconductor; without ice, unless the scene's sources say that a value includes it."""

    thermal_expansion: Number | None = quantity(
        None,
        "1/K",
        "coefficient of linear expansion; required where the temperature differs from the strung"
        " state",
        ge=0,
        le=1e-3,
    )


class LineScene(SceneBase):
    """A line: a section of several spans, its loads, numerics, and the source of each value.

    Spans, towers, phases, subconductors and devices count from 1; tower 0 is the left end and
    tower S the right end of S spans. `numerics.elements` is the number of elements of each
    subconductor in each span; the perturbation `initial` acts on each of them.
    """

    section: TensionSection = setting(..., "spans, towers and strung state")
    bundle: Bundle = setting(Bundle(), "subconductors of each phase")
    phases: Annotated[tuple[Phase, ...], Field(strict=False)] = setting(
        (Phase(name="1"),), "phases (default: one)"
    )
    conductor: LineConductor = setting(..., "conductor")
    ice: Ice = setting(Ice(), "ice on spans without their own")
    wind: Wind = setting(Wind(speed=0.0), "wind")
    aerodynamics: Aerodynamics | None = setting(None, "coefficient curve; required with wind")
    devices: Annotated[tuple[Device, ...], Field(strict=False)] = setting((), "devices")
    shedding: Annotated[tuple[Shedding, ...], Field(strict=False)] = setting(
        (), "ice that falls during the run"
    )
    damping: Damping = setting(Damping(), "structural damping")
    loads: Annotated[tuple[LineLoad, ...], Field(strict=False)] = setting((), "concentrated loads")
    initial: Initial = setting(Initial(), "start of the motion")
    numerics: Numerics = setting(Numerics(), "discretisation and tolerances")
    run: Run = setting(Run(), "duration and recording")
    sources: dict[Text, Text] = setting({}, "dotted path of a value or section to its source")

    def _key_figures(self) -> str:
        spans = self.section.spans
        return (
            f"section of {counted(len(spans), 'span')}, {sum(span.length for span in spans):g} m,"
            f" {counted(len(self.phases), 'phase')} of"
            f" {counted(self.bundle.subconductors, 'subconductor')},"
            f" {counted(len(self.devices), 'device')}, wind {self.wind.mean_speed:g} m/s"
        )

    def ice_of_span(self, span: int) -> Ice:
        """Ice on a span, counted from 1."""
        return self.section.spans[span - 1].ice or self.ice

    def wind_of_span(self, span: int) -> Law:
        """Wind speed [m/s] over time on a span, counted from 1, without gusts."""
        own = self.section.spans[span - 1].wind
        return (own or self.wind).speed_law

    @property
    def can_blow(self) -> bool:
        """True if the wind speed of a span is not zero at all times."""
        spans = range(1, len(self.section.spans) + 1)
        return any(self.wind_of_span(span).extremes != (0.0, 0.0) for span in spans)

    def elements_of_span(self, span: int) -> int:
        """Number of elements of each subconductor in a span, counted from 1."""
        return self.section.spans[span - 1].elements or self.numerics.elements

    def strung_weight(self, span: int) -> float:
        """Weight per unit length [N/m] of a subconductor in the strung state of a span, from 1."""
        ice = self.ice_of_span(span).mass_per_length if self.section.strung_with_ice else 0.0
        return (self.conductor.mass_per_length + ice) * self.section.gravity

    @property
    def length(self) -> float:
        """Horizontal distance [m] between the ends."""
        return math.fsum(span.length for span in self.section.spans)

    @property
    def strung_tension(self) -> float:
        """Horizontal tension [N] of each subconductor in the strung state."""
        section = self.section
        if section.horizontal_tension is not None:
            return section.horizontal_tension
        assert section.sag is not None
        assert section.sag_span is not None
        span = section.spans[section.sag_span - 1]
        return tension_of_sag(
            section.sag, span.length, self.strung_weight(section.sag_span), span.height_difference
        )

    @classmethod
    def _tables(cls, data: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
        """Return the data; refuse tables of the scene of one span."""
        wrong = [f"{name}: {cure}" for name, cure in ONE_SPAN_TABLES.items() if name in data]
        if wrong:
            raise SceneError("\n".join(wrong))
        return data

    def _check(self) -> None:
        check_line(self)

    def _unusual_combinations(self) -> list[str]:
        return unusual_in_line(self)


ONE_SPAN_INSTEAD = (
    'give a scene with [span], such as one span with supports.left.kind = "adjacent_span"'
)


def one_span(scene: Scene | LineScene, purpose: str, instead: str = ONE_SPAN_INSTEAD) -> Scene:
    """Return a scene of one span; refuse a line.

    Parameters
    ----------
    purpose
        What needs one span, as the subject of the message.
    instead
        What to do instead, as an imperative.

    Raises
    ------
    SceneError
        The scene is a line.
    """
    if isinstance(scene, LineScene):
        raise SceneError(
            f"{purpose} takes a scene of one span, and this one is a section of"
            f" {len(scene.section.spans)} spans ([section]); {instead}"
        )
    return scene
