"""New cases for lines, drawn from a seed and computed by other programs; see README.md above.

python benchmarks/peers/line_references.py                # all but galloping, 1 minute
python benchmarks/peers/line_references.py --galloping    # galloping, 4 minutes

Writes to tests/peers/data/lines, whose README.md has the format.
"""

from __future__ import annotations

import argparse
import json
import platform
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import line_galloping
import line_lumped as lumped
import line_mechaphlowers as mechaphlowers
import line_opensees as opensees
import numpy as np
from line_opensees import Array, Line, Span, ops
from line_sampler import CONDUCTORS, EXPANSION, SEED, Draw, draw, polygon

FOLDER = Path(__file__).resolve().parents[2] / "tests" / "peers" / "data" / "lines"
ICE_DENSITY = 6000.0
"""Weight density [N/m3] of ice in mechaphlowers."""

COARSE = 160
"""Elements of a span; twice as many in the second mesh, and both are extrapolated (order 2)."""

LOOPS = 3
"""Modes of each family of a bundle; with more loops the nodes of a mode can lie at the spacers."""

SOURCE = f"drawn by benchmarks/peers/line_sampler.py, seed {SEED}"


def extrapolated(coarse: Array, fine: Array) -> tuple[Array, float]:
    """Value for zero mesh size, and the largest change from the finer mesh to it."""
    limit = (4.0 * fine - coarse) / 3.0
    return limit, float(np.abs(limit - fine).max())


def line_of(section: Draw, gravity: float, **changes: Any) -> Line:
    """In OpenSees the mass is per metre of rest length: converted from that of the strung line."""
    spans = tuple(Span(a, b) for a, b in zip(section.spans, section.rises, strict=True))
    values = {
        "spans": spans,
        "strings": section.strings,
        "mass": section.mass,
        "axial_stiffness": section.axial_stiffness,
        "tension": section.tension,
        "elements": COARSE,
        "gravity": gravity,
        "expansion": EXPANSION,
    }
    first = Line(**values)
    mass = section.mass**2 / first.mass_per_hanging_length
    return Line(**(values | {"mass": mass} | changes))


def scene_of(section: Draw, line: Line) -> dict[str, Any]:
    mass, area, modulus, diameter = CONDUCTORS[section.conductor]
    return {
        "gravity": line.gravity,
        "spans": [
            {"length": a, "height_difference": b}
            for a, b in zip(section.spans, section.rises, strict=True)
        ],
        "strings": [{"length": a, "weight": b} for a, b in section.strings],
        "ends": "rigid",
        "conductor": {
            "name": section.conductor,
            "mass_per_length": mass,
            "mass_per_rest_length": line.mass,
            "axial_stiffness": area * modulus,
            "diameter": diameter,
            "thermal_expansion": EXPANSION,
        },
        "horizontal_tension": section.tension,
        "twist": False,
    }


def write(
    name: str, kind: str, scene: dict[str, Any], results: dict[str, Any], **more: Any
) -> None:
    programs = more.pop("program")
    packages = {"OpenSees": "openseespy", "mechaphlowers": "mechaphlowers", "numba": "numba"}
    versions = {p: version(package) for p, package in packages.items() if p in programs}
    case = {
        "kind": kind,
        "source": SOURCE,
        "program": programs,
        "versions": versions | {"python": platform.python_version()},
        **more,
        "scene": scene,
        "results": results,
    }
    text = json.dumps(case, indent=2, default=_plain)
    FOLDER.joinpath(f"{name}.json").write_text(text + "\n", encoding="utf-8")
    print(name, more)


def _plain(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return np.round(value, 7).tolist()
    return value.item()


# ---------------------------------------------------------------------------------- statics


def statics(number: int, section: Draw, states: list[dict[str, Any]]) -> None:
    """A section under ice, wind and temperature, in both programs."""
    gravity = mechaphlowers.GRAVITY
    peer = mechaphlowers.Section(
        section.spans,
        tuple(np.cumsum([20.0, *section.rises])),
        ((mechaphlowers.SHORTEST, 1.0), *section.strings, (mechaphlowers.SHORTEST, 1.0)),
        *CONDUCTORS[section.conductor],
        EXPANSION,
        section.tension,
    )
    diameter = CONDUCTORS[section.conductor][3]
    found, errors, differences = [], [], []
    for state in states:
        thickness = np.array(state["ice_thickness"])
        pressure = np.full(len(section.spans), state["wind_pressure"])
        their = mechaphlowers.solve(peer, 15.0 + state["temperature_change"], pressure, thickness)
        ice = np.pi * thickness * (thickness + diameter) * ICE_DENSITY / gravity
        wind = pressure * (diameter + 2.0 * thickness)
        ours, error = _opensees_statics(section, gravity, ice, wind, state["temperature_change"])
        offsets = their.offsets[1:-1] + np.array([[0.0, a, 0.0] for a, _ in section.strings])
        differences.append(float(np.abs(offsets - ours["clamps"]).max()))
        errors.append(error)
        found.append(
            {
                **state,
                "ice_mass_per_length": ice,
                "wind_force_per_length": wind,
                "mechaphlowers": {"clamps": offsets, "horizontal_tension": their.horizontal},
                "opensees": ours,
            }
        )
    results = {
        "unit": "m, N; displacements (x1, x2, x3) from the strung state",
        "clamps": "displacement of the clamp of each suspension",
        "mid_spans": "displacement of the middle (half the rest length) of each span",
        "string_pull": "axial force in the middle of each string",
        "ends": "force of the conductor on the left and the right tower",
        "states": found,
    }
    scene = scene_of(section, line_of(section, gravity)) | {"strung_temperature_deg_c": 15.0}
    write(
        f"new_statics_{number}",
        "statics",
        scene,
        results,
        program=["mechaphlowers", "OpenSees"],
        mesh_error={"clamps and mid-spans [m]": max(errors)},
        difference_of_programs={"clamps [m]": max(differences)},
    )


def _opensees_statics(
    section: Draw, gravity: float, ice: Array, wind: Array, temperature: float
) -> tuple[dict[str, Array], float]:
    meshes = []
    for factor in (1, 2):
        line = line_of(section, gravity)
        share = line.mass / section.mass
        spans = tuple(
            Span(s.length, s.rise, float(i * share), float(w * share))
            for s, i, w in zip(line.spans, ice, wind, strict=True)
        )
        line = line_of(
            section, gravity, spans=spans, temperature_change=temperature, elements=factor * COARSE
        )
        built = opensees.build(line)
        opensees.settle(built, 40)
        meshes.append(_static_values(built))
    limits = {key: extrapolated(meshes[0][key], meshes[1][key]) for key in meshes[0]}
    error = max(limits[key][1] for key in ("clamps", "mid_spans"))
    return {key: value for key, (value, _) in limits.items()}, error


def _static_values(built: opensees.Built) -> dict[str, Array]:
    line, chains = built.line, built.chains[0]
    ops.reactions()
    ends = []
    for tag, span, chain in ((chains[0][0], 0, 0), (chains[-1][-1], -1, -1)):
        rest = opensees.strung(line, line.spans[span]).rest
        spread = line.spans[chain]
        half = 0.5 * rest * np.array([0.0, -(line.mass + spread.ice) * line.gravity, spread.wind])
        ends.append(half - np.array(ops.nodeReaction(tag)))
    return {
        "clamps": np.array([opensees.displacement(tag) for tag in built.clamps[0]]),
        "mid_spans": np.array([opensees.displacement(tags[line.elements // 2]) for tags in chains]),
        "string_pull": np.array([ops.eleResponse(e, "axialForce")[0] for e in built.strings]),
        "ends": np.array(ends),
    }


# ------------------------------------------------------------------------------ frequencies


def section_frequencies(number: int, section: Draw, changes: dict[str, Any], note: str) -> None:
    gravity = 9.81
    line = line_of(section, gravity, **changes)
    meshes = []
    for factor in (1, 2):
        built = opensees.build(line.refined(factor))
        opensees.settle(built, 10)
        meshes.append(opensees.planes(built, 4 * len(section.spans) + 2))
    planes, error = [], 0.0
    for coarse, fine in zip(*meshes, strict=True):
        count = min(len(coarse), len(fine), 2 * len(section.spans) + 1)
        value, change = extrapolated(coarse[:count], fine[:count])
        planes.append(value)
        error = max(error, change)
    scene = scene_of(section, line)
    for data, span in zip(scene["spans"], line.spans, strict=True):
        data["ice_mass_per_rest_length"] = span.ice
        data["ice_mass_per_length"] = span.ice * section.mass / line.mass
        data["masses"] = [{"station": s, "mass": m} for s, m in span.masses]
    scene["temperature_change"] = line.temperature_change
    write(
        f"new_section_frequencies_{number}",
        "frequencies",
        scene,
        {"unit": "Hz", "in_plane": planes[0], "out_of_plane": planes[1]},
        program=["OpenSees"],
        mesh_error={"frequencies [Hz]": error},
        note=note,
    )


def bundle_frequencies(
    number: int, section: Draw, count: int, spacing: float, spacers: int
) -> None:
    gravity = 9.81
    stations = tuple((k + 1) / (spacers + 1) for k in range(spacers))
    elements = (spacers + 1) * round(COARSE / (spacers + 1))
    offsets = polygon(count, spacing)
    line = line_of(section, gravity, conductors=offsets, frames=stations, elements=elements)
    meshes = []
    for factor in (1, 2):
        built = opensees.build(line.refined(factor))
        opensees.settle(built)
        found = opensees.families(built, 4 * count if count > 2 else 9)
        meshes.append({family: values[:LOOPS] for family, values in found.items()})
    limits = {family: extrapolated(meshes[0][family], meshes[1][family]) for family in meshes[0]}
    scene = scene_of(section, line) | {
        "bundle": {
            "subconductors": count,
            "spacing": spacing,
            "offsets_x2_x3": np.array(offsets),
            "spacers_at": np.array(stations),
            "spacer": "rigid in its plane across the line, massless; x1 of the clamps is free",
        }
    }
    write(
        f"new_bundle_frequencies_{number}",
        "bundle frequencies",
        scene,
        {"unit": "Hz", **{family: value for family, (value, _) in limits.items()}},
        program=["OpenSees"],
        mesh_error={"frequencies [Hz]": max(error for _, error in limits.values())},
    )


def bundle_section(section: Draw, count: int, spacing: float, spacers: int) -> None:
    """Section of a bundle, yokes at its strings, in the lumped chain: lowest modes."""
    torsional, inertia = 150.0, 2e-4
    line = line_of(section, lumped.GRAVITY)
    half = 0.5 * spacing
    case = lumped.Case(
        conductor=lumped.Conductor(
            line.mass,
            section.axial_stiffness,
            torsional,
            inertia,
            CONDUCTORS[section.conductor][3],
        ),
        tension=section.tension,
        spans=section.spans,
        rises=section.rises,
        strings=section.strings,
        wind=lumped.Wind(0.0, 0.0, (), ()),
        damping=(0.0, 0.0),
        elements=6 * (spacers + 1),
        conductors=((0.0, -half), (0.0, half)),
        frames=tuple(lumped.Frame((k + 1) / (spacers + 1), 500.0) for k in range(spacers)),
    )
    meshes = []
    for factor in (1, 2):
        model = lumped.build(replace(case, elements=factor * case.elements))
        meshes.append(lumped.frequencies(model, count)[0])
    frequencies, error = extrapolated(*meshes)
    scene = scene_of(section, line)
    scene["conductor"] |= {"torsional_stiffness": torsional, "torsional_inertia": inertia}
    scene["twist"] = True
    scene["bundle"] = {
        "subconductors": 2,
        "spacing": spacing,
        "offsets_x2_x3": np.array(case.conductors),
        "spacers_at": np.array([frame.station for frame in case.frames]),
        "spacer": "rigid in its plane across the line, massless; x1 of the clamps is free",
        "clamp_torsional_stiffness": 500.0,
        "yoke": "at each string a massless frame like a spacer, held at its centre (yoke_height 0)",
    }
    write(
        "new_bundle_section_frequencies",
        "bundle section frequencies",
        scene,
        {"unit": "Hz", "all": frequencies},
        program=["lumped chain", "numba"],
        mesh_error={"frequencies [Hz]": error},
    )


# ------------------------------------------------------------------------------------ pulse


def smooth_step(x: Array) -> Array:
    x = np.clip(x, 0.0, 1.0)
    return x**3 * (10.0 - 15.0 * x + 6.0 * x**2)


def pulse_law(time: Array) -> Array:
    return smooth_step(time) - smooth_step((time - 1.5) / 0.5)


def section_pulse(section: Draw, station: float, force: tuple[float, float, float]) -> None:
    gravity, step, duration = 9.81, 0.001, 12.0
    line = line_of(section, gravity)
    meshes = []
    for factor in (1, 2):
        mesh = line.refined(factor)
        built = opensees.build(mesh)
        opensees.settle(built)
        chains = built.chains[0]
        watched = [tags[mesh.elements // 2] for tags in chains] + built.clamps[0]
        place = chains[0][round(station * mesh.elements)]
        meshes.append(opensees.pulse(built, place, force, pulse_law, step, duration, 50, watched))
    limit = (4.0 * meshes[1] - meshes[0]) / 3.0
    change = np.sqrt(((limit - meshes[1]) ** 2).mean(axis=0) / (limit**2).mean(axis=0))[1:]
    names = [f"mid{k + 1}" for k in range(len(section.spans))]
    names += [f"clamp{k + 1}" for k in range(len(section.strings))]
    columns = ["t"] + [f"{name}_u{i}" for name in names for i in (1, 2, 3)]
    file = FOLDER / "new_section_pulse.csv"
    np.savetxt(file, limit, fmt="%.7g", delimiter=",", header=",".join(columns), comments="")
    scene = scene_of(section, line) | {
        "damping": 0.0,
        "load": {
            "span": 1,
            "station_of_rest_length": station,
            "force": list(force),
            "law": "s(t) - s((t - 1.5)/0.5), s(x) = x^3 (10 - 15 x + 6 x^2), 0 below 0, 1 above 1",
        },
    }
    results = {
        "file": file.name,
        "columns": "time [s]; u1, u2, u3 [m] of the middle (half the rest length) of each span and"
        " of each clamp",
        "time_step": step,
    }
    error = {
        "relative RMS of each series": dict(zip(columns[1:], change.round(6).tolist(), strict=True))
    }
    write("new_section_pulse", "pulse", scene, results, program=["OpenSees"], mesh_error=error)


def compute() -> None:
    rng = np.random.default_rng(SEED)
    for number, spans in enumerate((2, 3, 4), 1):
        section = draw(rng, spans, mechaphlowers.GRAVITY)
        uneven = np.round(rng.uniform(0.0, 0.014, spans), 3).tolist()
        even = [float(np.round(rng.uniform(0.003, 0.01), 3))] * spans
        calm = {"ice_thickness": [0.0] * spans, "wind_pressure": 0.0}
        statics(
            number,
            section,
            [
                calm | {"temperature_change": float(np.round(rng.uniform(25.0, 55.0)))},
                calm | {"temperature_change": -20.0, "ice_thickness": uneven},
                {
                    "temperature_change": -10.0,
                    "ice_thickness": even,
                    "wind_pressure": float(np.round(rng.uniform(100.0, 350.0), -1)),
                },
            ],
        )
    for number, spans in enumerate((2, 3, 4), 1):
        section = draw(rng, spans, 9.81)
        section_frequencies(number, section, *_changes(rng, section, number))
    for number, count in enumerate((2, 4), 1):
        section = draw(rng, 1, 9.81)
        spacing = float(np.round(rng.uniform(0.35, 0.55), 2))
        bundle_frequencies(number, section, count, spacing, int(rng.integers(4, 8)))
    section_pulse(draw(rng, 2, 9.81), 0.35, (0.0, 300.0, 500.0))
    bundle_section(draw(rng, 2, 9.81), 14, 0.4, 4)


def _changes(rng: np.random.Generator, section: Draw, number: int) -> tuple[dict[str, Any], str]:
    spans = [Span(a, b) for a, b in zip(section.spans, section.rises, strict=True)]
    if number == 1:
        return {}, "as strung"
    if number == 2:
        ice = float(np.round(rng.uniform(0.3, 0.9), 2))
        spans[0] = Span(spans[0].length, spans[0].rise, ice=ice)
        return {"spans": tuple(spans), "temperature_change": -15.0}, "ice in span 1, colder by 15 K"
    mass = float(np.round(rng.uniform(20.0, 60.0)))
    spans[1] = Span(spans[1].length, spans[1].rise, masses=((0.25, mass), (0.5, mass)))
    return {"spans": tuple(spans)}, "two point masses in span 2"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--galloping", action="store_true")
    if parser.parse_args().galloping:
        for case in line_galloping.cases(SEED):
            write(**case)
    else:
        compute()


if __name__ == "__main__":
    main()
