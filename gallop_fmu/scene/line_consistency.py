"""Checks of the values of a line against each other, and warnings about unusual combinations."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import combinations, pairwise
from typing import TYPE_CHECKING

from gallop_fmu.foundation.errors import SceneError
from gallop_fmu.scene.conductor import Ice
from gallop_fmu.scene.consistency import (
    MAX_SAG_RATIO,
    MIN_USUAL_SAG_RATIO,
    NO_CURVE,
    check_attack_angle,
    check_mass_matrix,
    ice_against_curve,
)
from gallop_fmu.scene.devices import InterphaseSpacer, Interval
from gallop_fmu.scene.phases import Phase
from gallop_fmu.scene.sag_tension import MAX_STRAIN, catenary_sag, check_tension, highest_tension
from gallop_fmu.scene.shedding_checks import curves_of, wrong_sheddings
from gallop_fmu.scene.stations import (
    BOUNDARIES,
    MIN_PART,
    SAME_PLACE,
    Conductor,
    Place,
    conductors_of,
    places,
    stations,
)
from gallop_fmu.scene.suspensions import EndString, Post, String, VString
from gallop_fmu.scene.validation_messages import joined
from gallop_fmu.scene.wind_consistency import (
    check_time_tables,
    check_wind_of_line,
    unusual_wind_of_line,
)

if TYPE_CHECKING:
    from gallop_fmu.scene.line_scene import LineScene

MAX_USUAL_SAG_RATIO = 0.2
"""Maximum usual sag of a span of a section over its length."""

MIN_SAG_RATIO, MAX_TENSION_RATIO = 1e-6, 1e6
"""Minimum sag over span, and maximum tension over weight of the span; no line is near them."""

MIN_USUAL_PHASE_DISTANCE = 0.3
"""Minimum usual distance [m] between conductors of two phases."""


def check_line(scene: LineScene) -> None:
    """Refuse values that contradict each other.

    Raises
    ------
    SceneError
        One line for each problem: it names the span, suspension, phase or device by number, the
        values and a remedy.
    """
    _raise_all(_wrong_numbers(scene))  # the other checks need valid numbers of spans and phases
    _check_strung_state(scene)
    _raise_all(
        [
            *_long_strings(scene),
            *_unfit_suspensions(scene),
            *_touching_conductors(scene),
            *_wrong_places(scene),
            *_overlapping_intervals(scene),
            *wrong_sheddings(scene),
        ]
    )
    _check_ice_and_curves(scene)
    check_time_tables(scene, scene.run.stop_time)
    check_wind_of_line(scene)


def unusual_in_line(scene: LineScene) -> list[str]:
    """Warnings about values that are unusual together, each a fact and a remedy."""
    curves = [
        scene.aerodynamics,
        *(d.aerodynamics for d in _intervals(scene)),
        *curves_of(scene.shedding),
    ]
    return [
        *_unusual_sags(scene),
        *_strained(scene),
        *_bundle_without_spacers(scene),
        *_near_phases(scene),
        *_interphase_spacers_on_bundles(scene),
        *(text for curve in curves if curve is not None for text in curve.warnings()),
        *_ice_against_curves(scene),
        *unusual_wind_of_line(scene),
    ]


def _raise_all(problems: Iterator[str] | list[str]) -> None:
    lines = list(dict.fromkeys(problems))
    if lines:
        raise SceneError(joined(lines))


def _intervals(scene: LineScene) -> list[Interval]:
    return [device for device in scene.devices if isinstance(device, Interval)]


def _wrong_numbers(scene: LineScene) -> Iterator[str]:
    """Problems of numbers of spans, phases and subconductors that the line does not have."""
    limits = {
        "span": len(scene.section.spans),
        "phase": len(scene.phases),
        "subconductor": scene.bundle.subconductors,
    }
    named = (
        ("devices", "device", scene.devices),
        ("loads", "load", scene.loads),
        ("shedding", "shedding", scene.shedding),
    )
    for path, noun, items in named:
        for i, item in enumerate(items):
            given = {name: getattr(item, name, None) for name in limits}
            found = [(name, name, number) for name, number in given.items() if number is not None]
            found += [("phases", "phase", number) for number in getattr(item, "phases", ())]
            for key, name, number in found:
                if not 1 <= number <= limits[name]:
                    yield (
                        f"{path}.{i} ({noun} {i + 1}): {key} = {number}, but the line has"
                        f" {limits[name]} {name}{'s' * (limits[name] != 1)}; give a number from 1"
                        f" to {limits[name]}"
                    )


def _check_strung_state(scene: LineScene) -> None:
    """Refuse a strung state that no section has."""
    section = scene.section
    change = section.temperature_change
    if change != 0.0 and scene.conductor.thermal_expansion is None:
        raise SceneError(
            f"conductor.thermal_expansion: missing; section.temperature_deg_c ="
            f" {section.temperature_deg_c:g} differs from section.strung_temperature_deg_c ="
            f" {section.strung_temperature_deg_c:g}, so give it in 1/K (ACSR: about 1.9e-5), or"
            " equal temperatures"
        )
    given = f"section.horizontal_tension = {section.horizontal_tension or 0.0:g} N"
    if section.sag is not None and section.sag_span is not None:
        length = section.spans[section.sag_span - 1].length
        if section.sag > MAX_SAG_RATIO * length:
            raise SceneError(
                f"section.sag = {section.sag:g} m is more than {MAX_SAG_RATIO:g} times the length"
                f" {length:g} m of span {section.sag_span}; is it in cm or mm?"
            )
        if section.sag < MIN_SAG_RATIO * length:
            raise SceneError(
                f"section.sag = {section.sag:g} m is less than {MIN_SAG_RATIO:g} of the length"
                f" {length:g} m of span {section.sag_span}; is it in km?"
            )
        given = (
            f"section.sag = {section.sag:g} m of span {section.sag_span} (tension"
            f" {scene.strung_tension:.4g} N)"
        )
    for number, span in enumerate(section.spans, start=1):
        check_tension(
            f"span {number}: {given}",
            scene.strung_tension,
            scene.strung_weight(number),
            span.length,
            "is it in kN?" if section.sag is None else "check the units",
        )
        weight = scene.strung_weight(number) * span.length
        if scene.strung_tension > MAX_TENSION_RATIO * weight:
            raise SceneError(
                f"span {number}: {given} is more than {MAX_TENSION_RATIO:g} times the weight of the"
                f" span ({weight:.4g} N); check the units of conductor.mass_per_length and the"
                " tension"
            )


def _long_strings(scene: LineScene) -> Iterator[str]:
    """Problems of strings that are too long for their spans, or reach another phase."""
    spans = [span.length for span in scene.section.spans]
    for i, suspension in enumerate(scene.section.suspensions):
        if isinstance(suspension, Post):
            continue
        shorter = min(spans[i], spans[i + 1])
        name = f"section.suspensions.{i} (suspension {i + 1})"
        if suspension.length >= 0.5 * shorter:
            yield (
                f"{name}: length = {suspension.length:g} m must be less than half the shorter span"
                f" beside it, {0.5 * shorter:g} m; is it in cm or mm?"
            )
        for (low, below), (high, above) in _ordered_phases(scene):
            rise = above.offset[0] - below.offset[0]
            aside = abs(above.offset[1] - below.offset[1])
            if 0.0 < rise <= suspension.length and aside < scene.conductor.diameter:
                yield (
                    f"{name}: length = {suspension.length:g} m, so the string of phase {low}"
                    f" passes phase {high}, which is {rise:g} m above it; give a shorter string,"
                    " or more distance in phases.offset"
                )
    for name, end, length in (
        ("left_end", scene.section.left_end, spans[0]),
        ("right_end", scene.section.right_end, spans[-1]),
    ):
        if isinstance(end, EndString) and end.length >= 0.5 * length:
            yield (
                f"section.{name}: length = {end.length:g} m must be less than half of its span,"
                f" {0.5 * length:g} m; is it in cm or mm?"
            )


def _ordered_phases(scene: LineScene) -> Iterator[tuple[tuple[int, Phase], tuple[int, Phase]]]:
    """Yield all pairs of phases with their numbers, the lower one first."""
    for a, b in combinations(enumerate(scene.phases, start=1), 2):
        yield (a, b) if a[1].offset[0] <= b[1].offset[0] else (b, a)


def _unfit_suspensions(scene: LineScene) -> Iterator[str]:
    """Problems of suspensions and yokes that do not fit the bundle."""
    bundle = scene.bundle
    if bundle.subconductors == 1:
        given = [name for name in ("yoke_mass", "yoke_height") if getattr(bundle, name) != 0.0]
        for name in given:
            yield (
                f"bundle.{name} = {getattr(bundle, name):g}, but a single conductor has no yoke;"
                " remove it, or set bundle.subconductors"
            )
        return
    for i, suspension in enumerate(scene.section.suspensions):
        name = f"section.suspensions.{i} (suspension {i + 1})"
        if isinstance(suspension, VString):
            yield (
                f'{name}: kind = "v_string" holds a single conductor, not the yoke of a bundle of'
                f' {bundle.subconductors}; use kind = "string" or "post"'
            )
        if isinstance(suspension, String) and suspension.clamp_torsional_stiffness is not None:
            yield (
                f"{name}: clamp_torsional_stiffness is that of a single conductor's clamp; the"
                " clamps of a bundle are elastic at its yoke, give"
                " bundle.clamp_torsional_stiffness in its place"
            )


def _touching_conductors(scene: LineScene) -> Iterator[str]:
    """Problems of names and places of phases and subconductors."""
    diameter, names = scene.conductor.diameter, [phase.name for phase in scene.phases]
    for i, name in enumerate(names):
        if name in names[:i]:
            yield (
                f"phases.{i} (phase {i + 1}): name = {name!r} is also that of phase"
                f" {names.index(name) + 1}; give each phase its own name"
            )
    corners = scene.bundle.positions
    for (a, first), (b, second) in combinations(enumerate(corners, start=1), 2):
        if math.dist(first, second) <= diameter:
            yield (
                f"bundle: subconductors {a} and {b} are {math.dist(first, second):g} m apart and"
                f" touch (conductor.diameter = {diameter:g} m); increase spacing, or correct"
                " offsets"
            )
    for a, b, distance in _phase_distances(scene):
        if distance <= diameter:
            yield (
                f"phases.{b - 1} (phase {b}): it touches phase {a}, at a distance of"
                f" {distance:g} m between conductors of {diameter:g} m; give the phases different"
                " offsets [x2, x3]"
            )


def _phase_distances(scene: LineScene) -> Iterator[tuple[int, int, float]]:
    """Yield the numbers of all pairs of phases, and the distance [m] of nearest conductors."""
    corners = scene.bundle.positions
    for (a, one), (b, other) in combinations(enumerate(scene.phases, start=1), 2):
        rise, aside = (other.offset[axis] - one.offset[axis] for axis in (0, 1))
        yield (
            a,
            b,
            min(
                math.hypot(rise + p[0] - q[0], aside + p[1] - q[1])
                for p in corners
                for q in corners
            ),
        )


def _wrong_places(scene: LineScene) -> Iterator[str]:
    """Problems of stations: too close, or more than the elements of the span allow."""
    seen: set[tuple[int, tuple[Place, ...]]] = set()
    for conductor, found in places(scene).items():
        if (conductor.span, tuple(found)) in seen:
            continue
        seen.add((conductor.span, tuple(found)))
        length = scene.section.spans[conductor.span - 1].length
        for first, second in pairwise(found):
            yield from _too_close(scene, conductor, length, first, second)
        for place in found:
            margin = length * min(place.station, 1.0 - place.station)
            if margin < MIN_PART:
                yield (
                    f"{place.name} is at station {place.station:g} of span {conductor.span},"
                    f" {margin:.3g} m from its end; must be at least {MIN_PART:g} m away"
                )
        parts = len(stations(found)) + 1
        elements = scene.elements_of_span(conductor.span)
        if elements < parts:
            yield (
                f"span {conductor.span}: {elements} elements, but spacers, devices and shedding"
                f" divide {_name(scene, conductor)} into {parts} parts with at least one element"
                f" each; set numerics.elements or section.spans.{conductor.span - 1}.elements to at"
                f" least {parts}"
            )


def _too_close(
    scene: LineScene, conductor: Conductor, length: float, first: Place, second: Place
) -> Iterator[str]:
    apart = second.station - first.station
    where = f"station {second.station:g} of span {conductor.span}"
    if apart > SAME_PLACE and apart * length < MIN_PART:
        yield (
            f"{first.name} and {second.name} are {apart * length:.3g} m apart at {where}; give"
            f" them the same station, or a distance of at least {MIN_PART:g} m"
        )
    elif apart <= SAME_PLACE and first.kind == second.kind not in BOUNDARIES:
        yield (
            f"{first.name} and {second.name} are both of kind {first.kind} at {where} on"
            f" {_name(scene, conductor)}; remove one, or move it"
        )


def _name(scene: LineScene, conductor: Conductor) -> str:
    """Name of a conductor for messages, without numbers that are always 1."""
    phase = f"phase {conductor.phase}" if len(scene.phases) > 1 else ""
    part = f"subconductor {conductor.subconductor}" if scene.bundle.subconductors > 1 else ""
    return " ".join(filter(None, [phase, part])) or "the conductor"


def _overlapping_intervals(scene: LineScene) -> Iterator[str]:
    """Problems of intervals that overlap on one conductor."""
    numbered = [
        (number, device, set(conductors_of(scene, device)))
        for number, device in enumerate(scene.devices, start=1)
        if isinstance(device, Interval)
    ]
    for (a, first, on_first), (b, second, on_second) in combinations(numbered, 2):
        overlap = min(first.to_station, second.to_station) - max(
            first.from_station, second.from_station
        )
        if overlap > SAME_PLACE and on_first & on_second:
            yield (
                f"devices.{b - 1} (device {b}): its interval from {second.from_station:g} to"
                f" {second.to_station:g} overlaps that of device {a}, {first.from_station:g} to"
                f" {first.to_station:g} of span {first.span}; make them adjoin, or remove one"
            )


def _parts(scene: LineScene) -> Iterator[tuple[str, Ice, bool]]:
    """Yield path and ice of all parts of the line, and True if the part has its own curve."""
    spans = scene.section.spans
    if any(span.ice is None for span in spans):
        yield "ice", scene.ice, False
    for i, span in enumerate(spans):
        if span.ice is not None:
            yield f"section.spans.{i}.ice (span {i + 1})", span.ice, False
    for i, device in enumerate(scene.devices):
        if isinstance(device, Interval):
            ice = scene.ice_of_span(device.span) if device.ice is None else device.ice
            yield f"devices.{i}.ice (device {i + 1})", ice, device.aerodynamics is not None


def _check_ice_and_curves(scene: LineScene) -> None:
    """Refuse ice without a positive definite mass matrix, and angles outside the curves."""
    for path, ice, _ in _parts(scene):
        check_mass_matrix(scene.conductor, ice, path)
    if not scene.can_blow:
        return
    if scene.aerodynamics is None:
        raise SceneError(NO_CURVE)
    for path, ice, has_own in _parts(scene):
        if not has_own:
            check_attack_angle(scene.aerodynamics, ice, path, scene.wind.turn_deg)
    for i, device in enumerate(scene.devices):
        if isinstance(device, Interval) and device.aerodynamics is not None:
            ice = scene.ice_of_span(device.span) if device.ice is None else device.ice
            path = f"devices.{i}.ice (device {i + 1})"
            check_attack_angle(device.aerodynamics, ice, path, scene.wind.turn_deg)


def _unusual_sags(scene: LineScene) -> Iterator[str]:
    """Warnings about spans with an unusual sag in the strung state."""
    for number, span in enumerate(scene.section.spans, start=1):
        weight, tension = scene.strung_weight(number), scene.strung_tension
        sag = catenary_sag(span.length, weight, tension, span.height_difference)
        if not MIN_USUAL_SAG_RATIO < sag / span.length < MAX_USUAL_SAG_RATIO:
            yield (
                f"span {number}: the sag in the strung state is {sag:.3g} m,"
                f" {sag / span.length:.3g} of its length {span.length:g} m; usual are"
                f" {MIN_USUAL_SAG_RATIO:g} to {MAX_USUAL_SAG_RATIO:g}; check the units of"
                f" section.{_given(scene)}, conductor.mass_per_length and the length"
            )


def _given(scene: LineScene) -> str:
    return "horizontal_tension" if scene.section.sag is None else "sag"


def _strained(scene: LineScene) -> Iterator[str]:
    """Warnings about tensions in the strung state that no conductor withstands."""
    tension, strength = scene.strung_tension, scene.section.rated_strength
    if tension > MAX_STRAIN * scene.conductor.axial_stiffness:
        yield (
            f"section.{_given(scene)}: the horizontal tension of {tension:.4g} N is more than"
            f" {MAX_STRAIN:.0%} of conductor.axial_stiffness ="
            f" {scene.conductor.axial_stiffness:g} N, which no conductor withstands; check the"
            " units (both in N)"
        )
    if strength is None:
        return
    for number, span in enumerate(scene.section.spans, start=1):
        highest = highest_tension(
            span.length, scene.strung_weight(number), tension, span.height_difference
        )
        if highest > strength:
            yield (
                f"span {number}: the tension in the strung state reaches {highest:.4g} N, more than"
                f" section.rated_strength = {strength:g} N; check section.{_given(scene)}, and the"
                " units (N)"
            )


def _bundle_without_spacers(scene: LineScene) -> Iterator[str]:
    if scene.bundle.subconductors > 1 and not scene.bundle.spacer_stations:
        yield (
            f"bundle: {scene.bundle.subconductors} subconductors without spacers, which move"
            " independently within the spans; give bundle.spacers, unless this is meant"
        )


def _near_phases(scene: LineScene) -> Iterator[str]:
    for a, b, distance in _phase_distances(scene):
        if distance < MIN_USUAL_PHASE_DISTANCE:
            yield (
                f"phases {a} and {b}: conductors are {distance:.3g} m apart; usual is at least"
                f" {MIN_USUAL_PHASE_DISTANCE:g} m; check phases.offset [m]"
            )


def _interphase_spacers_on_bundles(scene: LineScene) -> Iterator[str]:
    if scene.bundle.subconductors == 1:
        return
    for i, device in enumerate(scene.devices):
        if isinstance(device, InterphaseSpacer):
            yield (
                f"devices.{i} (device {i + 1}): the interphase spacer is clamped to subconductor"
                f" {device.subconductor} of each bundle and not to its centre, so that its force"
                " rotates the bundles; place it at a bundle spacer, and check the rotation"
            )


def _ice_against_curves(scene: LineScene) -> Iterator[str]:
    """Warnings about parts of the line whose ice and curve contradict each other."""
    for path, ice, has_own in _parts(scene):
        if not has_own:
            for text in ice_against_curve(scene.aerodynamics, ice):
                yield text if path == "ice" else f"{path}: {text}"
