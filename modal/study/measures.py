"""Measures against galloping with values that a line crew can install, applied to a line.

Each measure is a changed line, which the study simulates. A measure that a line cannot have is kept
with the reason.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, SceneError
from gallop_fmu.foundation.text_rules import counted

TENSION_FACTORS = (1.1, 0.9)
"""Changes of the strung tension."""

USUAL_SHARE = 0.25
"""Share of the rated strength up to which conductors are usually strung (aeolian vibration)."""

MORE_SPACERS = 2
"""Spacers that are added in each span of a bundle."""

PENDULUM_STATIONS = (0.25, 0.5, 0.75)
PENDULUM_MASS, PENDULUM_ARM = 20.0, 0.5
"""Mass [kg] of a detuning pendulum of a phase, and its arm [m]."""

DAMPER_SHARE, MAX_DAMPER_MASS = 0.05, 50.0
"""Mass of a hanging damper over the modal mass of its span, and its maximum [kg]."""

MAX_STRETCH = 1.0
"""Stretch [m] of the spring of a tuned damper above which a plain spring is not practicable
(chosen)."""

INTERPHASE_STATIONS = ((1.0 / 3.0, 2.0 / 3.0), (0.25, 0.5, 0.75))
"""Stations of interphase spacers between the first two phases, the next two, and so on in turn."""

INTERPHASE_MASS = 5.0
"""Mass of an interphase spacer per length [kg/m]: a composite rod with fittings."""

SHORT_SPACER_PART = 2
"""Least number of elements between two spacers."""


@dataclass(frozen=True)
class Measure:
    """A change of the line.

    Attributes
    ----------
    name : str
        What to do, as an imperative.
    detail : str
        Values, and what they assume.
    scene : LineScene or None
        The changed line; None if the line cannot have it.
    reason : str
        Why not; empty otherwise.
    """

    name: str
    detail: str
    scene: LineScene | None
    reason: str = ""


def measures(scene: LineScene, frequencies_hz: NDArray[np.float64]) -> list[Measure]:
    """Return all measures for a line.

    Parameters
    ----------
    scene
        The line, with all phases that it has.
    frequencies_hz
        Frequency of galloping of each span [Hz], to which dampers are tuned; NaN where a span does
        not gallop.
    """
    found = [_tension(scene, factor) for factor in TENSION_FACTORS]
    if scene.bundle.subconductors > 1:
        found.append(_spacers(scene))
    return [
        *found,
        _interphase(scene),
        pendulums(scene),
        dampers(scene, frequencies_hz),
        _split(scene),
    ]


def _made(name: str, detail: str, change: Callable[[], LineScene]) -> Measure:
    """Return a measure, or the reason why the line cannot have it."""
    try:
        return Measure(name, detail, change())
    except SceneError as problem:
        return Measure(name, detail, None, str(problem))


def _tension(scene: LineScene, factor: float) -> Measure:
    """Change the strung tension."""
    tension, strength = factor * scene.strung_tension, scene.section.rated_strength
    way = "Raise" if factor > 1.0 else "Lower"
    detail = f"strung at {tension / 1e3:.2f} kN"
    if strength:
        share = tension / strength
        detail += f", {share:.0%} of the rated strength"
        if share > USUAL_SHARE:
            detail += f" (more than the usual {USUAL_SHARE:.0%}: check aeolian vibration)"
    if factor < 1.0:
        detail += "; sags grow, so check the ground clearance"
    values = {
        "section.horizontal_tension": tension,
        "section.sag": None,
        "section.sag_span": None,
    }
    return _made(
        f"{way} the tension by {abs(factor - 1.0):.0%}", detail, lambda: scene.with_values(values)
    )


def _spacers(scene: LineScene) -> Measure:
    """Add spacers to a bundle."""
    before = len(scene.bundle.spacer_stations)
    count = before + MORE_SPACERS
    values: dict[str, Any] = {"bundle.spacers": count, "bundle.stations": None}
    for k in range(len(scene.section.spans)):
        least = SHORT_SPACER_PART * (count + 1)
        values[f"section.spans.{k}.elements"] = max(scene.elements_of_span(k + 1), least)
    return _made(
        f"Use {count} spacers in each span of the bundle instead of {before}",
        "evenly spaced; shorter subspans resist twist more",
        lambda: scene.with_values(values),
    )


def _interphase(scene: LineScene) -> Measure:
    """Connect neighbouring phases by interphase spacers."""
    name = "Connect the phases by interphase spacers"
    if len(scene.phases) == 1:
        return Measure(name, "", None, "the scene has one phase; give all of them as [[phases]]")
    order = sorted(range(len(scene.phases)), key=lambda k: scene.phases[k].offset)
    devices = []
    for number, (low, high) in enumerate(pairwise(order)):
        length = math.dist(scene.phases[low].offset, scene.phases[high].offset)
        for span in range(1, len(scene.section.spans) + 1):
            devices += [
                {
                    "kind": "interphase_spacer",
                    "span": span,
                    "station": station,
                    "phases": [low + 1, high + 1],
                    "mass": INTERPHASE_MASS * length,
                }
                for station in INTERPHASE_STATIONS[number % len(INTERPHASE_STATIONS)]
            ]
    return _made(
        name,
        f"2 or 3 in each span, in turn, {INTERPHASE_MASS:g} kg/m; spacers do not hinder phases"
        " that move alike, as they do in a study, where all start alike",
        lambda: _with_devices(scene, devices),
    )


def pendulums(scene: LineScene) -> Measure:
    """Hang detuning pendulums in all spans."""
    count = scene.bundle.subconductors
    mass = PENDULUM_MASS / count
    devices = [
        {
            "kind": "pendulum",
            "span": span,
            "station": station,
            "mass": mass,
            "arm": PENDULUM_ARM,
        }
        for span in range(1, len(scene.section.spans) + 1)
        for station in PENDULUM_STATIONS
    ]
    each = f" on each of {count} subconductors" if count > 1 else ""
    return _made(
        f"Hang {len(PENDULUM_STATIONS)} detuning pendulums in each span",
        f"{mass:g} kg at {PENDULUM_ARM:g} m below the conductor{each}, at the quarter points;"
        " they lower the torsional frequency, and the moment curve decides if that helps",
        lambda: _with_devices(scene, devices),
    )


def dampers(scene: LineScene, frequencies_hz: NDArray[np.float64]) -> Measure:
    """Hang a tuned damper at mid-span of all spans that gallop.

    The tuning is that of Den Hartog (Mechanical Vibrations, section 3.3): with mu the ratio of the
    damper's mass to the modal mass, half of the mass of the span, the frequency is f/(1 + mu) and
    the damping ratio sqrt(3 mu/(8 (1 + mu)^3)).
    """
    devices: list[dict[str, Any]] = []
    masses, stretches = [], []
    for span, frequency in enumerate(frequencies_hz.tolist(), start=1):
        if not math.isfinite(frequency):
            continue
        per_length = scene.conductor.mass_per_length + scene.ice_of_span(span).mass_per_length
        modal = 0.5 * per_length * scene.section.spans[span - 1].length
        mass = min(DAMPER_SHARE * modal, MAX_DAMPER_MASS / scene.bundle.subconductors)
        mu = mass / modal
        omega = 2.0 * math.pi * frequency / (1.0 + mu)
        ratio = math.sqrt(3.0 * mu / (8.0 * (1.0 + mu) ** 3))
        devices.append(
            {
                "kind": "damper",
                "span": span,
                "station": 0.5,
                "damping": 2.0 * ratio * mass * omega,
                "hanging_mass": mass,
                "hanging_stiffness": mass * omega**2,
            }
        )
        masses.append(mass)
        stretches.append(scene.section.gravity / omega**2)
    name = "Hang a tuned damper at mid-span"
    if not devices:
        return Measure(name, "", None, "no span gallops at a frequency to which it can be tuned")
    lever = (
        ": not practicable as a plain spring; its mass needs a lever or a counterweight"
        if max(stretches) > MAX_STRETCH
        else ""
    )
    return _made(
        name,
        f"{_range_of(masses, '.0f')} kg for each conductor, in {counted(len(devices), 'span')};"
        f" a spring would stretch by {_range_of(stretches, '.1f')} m under its weight{lever}",
        lambda: _with_devices(scene, devices),
    )


def _range_of(values: Sequence[float], digits: str) -> str:
    """Lowest and highest value, or the one value if they are the same in so many digits."""
    low, high = format(min(values), digits), format(max(values), digits)
    return low if low == high else f"{low} to {high}"


def _with_devices(scene: LineScene, devices: list[dict[str, Any]]) -> LineScene:
    """Return the line with more devices."""
    own = scene.model_dump(mode="json", exclude_none=True)["devices"]
    return scene.with_values({"devices": [*own, *devices]})


def _split(scene: LineScene) -> Measure:
    """Place a tower in the middle of the longest span."""
    spans = scene.section.spans
    longest = max(range(len(spans)), key=lambda k: spans[k].length)
    length = spans[longest].length
    return _made(
        f"Split span {longest + 1} by a tower in its middle",
        f"two spans of {0.5 * length:g} m in place of {length:g} m; the new string is as its"
        " neighbour, its clamp on the line between the old ones",
        lambda: split_span(scene, longest + 1),
    )


def split_span(scene: LineScene, number: int) -> LineScene:
    """Return the line with a suspension in the middle of a span; the strung tension stays.

    Raises
    ------
    SceneError
        The line has no suspension whose copy the new one could be, or something is attached to
        the span or to one behind it.
    """
    data = scene.model_dump(mode="json", exclude_none=True)
    section = data["section"]
    if not section["suspensions"]:
        raise SceneError("the line has no suspension string, so the new tower has no example")
    behind = [
        item
        for name in ("devices", "loads", "shedding")
        for item in data[name]
        if item["span"] >= number
    ]
    if behind:
        raise SceneError(
            f"something is attached to span {behind[0]['span']}; move it to the new spans by hand"
        )
    span = section["spans"][number - 1]
    half = dict(span)
    half["length"] = 0.5 * span["length"]
    half["height_difference"] = 0.5 * span.get("height_difference", 0.0)
    if "elements" in span:
        half["elements"] = max(2, math.ceil(0.5 * span["elements"]))
    suspension = _nearest(section["suspensions"], number)
    section["spans"][number - 1 : number] = [half, dict(half)]
    section["suspensions"].insert(number - 1, suspension)
    # The strung tension is that of the whole section; a given sag is that of a span that changes.
    section.pop("sag", None)
    section.pop("sag_span", None)
    section["horizontal_tension"] = scene.strung_tension
    data["sources"] = {
        path: text for path, text in data["sources"].items() if not path.startswith("section.")
    }
    return LineScene.from_dict(data)


def _nearest(suspensions: list[dict[str, Any]], span: int) -> dict[str, Any]:
    """A copy of the suspension at the nearer end of a span."""
    return dict(suspensions[min(max(span - 2, 0), len(suspensions) - 1)])


def applicable(found: list[Measure]) -> Iterator[tuple[Measure, LineScene]]:
    """Yield the measures that the line can have, with their lines."""
    for measure in found:
        if measure.scene is not None:
            yield measure, measure.scene
