"""How near a span is to the 2:1 internal resonance that lets vertical galloping drive a horizontal swing."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import Scene, SceneError, SimulationError
from modal.foundation.change_of_state import ACSR_EXPANSION
from modal.foundation.scene_variation import (
    ICE_MASS,
    TEMPERATURE,
    free_sag,
    number_of,
    unit_of,
    with_number,
)
from modal.linear.modes import Family, Mode, natural_modes

if TYPE_CHECKING:
    import xarray as xr

SEARCHED = 24
"""Modes among which the first symmetric ones are looked for; between rigid ends at most five lie below them, and more
only where the conductor is very soft in torsion."""

CLEAR_SHARE = 0.6
"""Part of the kinetic energy above which a mode belongs to its family beyond doubt."""

CLEAR_SYMMETRY = 0.8
"""Part of the squared motion above which a mode is symmetric beyond doubt; an inclined span is never quite so."""

DESIGN = (
    "span.horizontal_tension",
    "conductor.axial_stiffness",
    "span.length",
    "supports.left.stiffness_x1",
    "supports.right.stiffness_x1",
)
"""What an engineer can choose; `way_out` tries each."""

STEP = 0.1
"""Relative change by which `way_out` tries a design number."""


@dataclass(frozen=True)
class FrequencyRatio:
    """First symmetric vertical and horizontal frequency [Hz], their ratio, and how far that is from 2 and from 1."""

    vertical_hz: float
    horizontal_hz: float

    @property
    def ratio(self) -> float:
        """Vertical over horizontal frequency; 2 is the internal resonance of Liu et al. (2009)."""
        return self.vertical_hz / self.horizontal_hz

    @property
    def detuning(self) -> float:
        """Relative distance from the 2:1 resonance: ratio / 2 - 1, positive where the vertical mode is too fast."""
        return self.ratio / 2.0 - 1.0

    @property
    def one_to_one_detuning(self) -> float:
        """Relative distance from the 1:1 resonance, ratio - 1: near 0 in tight spans and soft supports."""
        return self.ratio - 1.0


@dataclass(frozen=True)
class DesignChange:
    """What one change of design does to the frequency ratio.

    Attributes
    ----------
    path : str
        The number changed, as in `ratio_map`.
    unit : str
        Its unit.
    before, after : float
        Its value before and after.
    detuning_before, detuning_after : float
        Distance from 2:1, ratio / 2 - 1.
    sensitivity : float
        Change of the ratio per relative change of the number (d ratio / d ln value).
    sentence : str
        The same in words.
    """

    path: str
    unit: str
    before: float
    after: float
    detuning_before: float
    detuning_after: float
    sensitivity: float
    sentence: str


def frequency_ratio(scene: Scene) -> FrequencyRatio:
    """Ratio of the first symmetric vertical to the first symmetric horizontal natural frequency.

    A ratio near 2 lets vertical galloping feed a horizontal swing of half its frequency once its
    amplitude passes a threshold (Liu, Yan, Zhang, Zhou 2009, Example 3).

    Raises
    ------
    SceneError
        If one of the two modes cannot be told among the lowest ones.
    SimulationError
        If no initial equilibrium exists.
    """
    unknowns = 4 * (
        2 * scene.numerics.elements - 1
    )  # at least so many: the ends are rigid or held by springs
    modes = natural_modes(scene, min(SEARCHED, unknowns))
    return FrequencyRatio(
        vertical_hz=_first_symmetric(modes, "vertical").frequency_hz,
        horizontal_hz=_first_symmetric(modes, "horizontal").frequency_hz,
    )


def ratio_map(
    scene: Scene,
    path: str,
    values: Sequence[float],
    expansion: float = ACSR_EXPANSION,
    against: tuple[str, Sequence[float]] | None = None,
) -> xr.Dataset:
    """Frequency ratio and detuning while one number of a span changes, or two at once.

    Parameters
    ----------
    scene
        The span.
    path
        Dotted path of the number. These are understood as an engineer means them:

        - ``span.horizontal_tension`` and ``span.sag``: the other of the two follows, although the
          scene may hold both;
        - ``ice.mass_per_length``: ice on the strung conductor, whose unstretched length stays
          (`change_of_state`);
        - ``temperature_change``: rise of temperature from the scene's state [K], with the same
          change of state;
        - ``supports.stiffness_x1``, ``supports.stiffness_x3``: springs at both ends, at once.
    values
        Values of the number in its unit.
    expansion
        Coefficient of linear expansion [1/K] for ``temperature_change``; the default is for ACSR
        26/7.
    against
        Path and values of a second number, for a map over both. Temperature and ice change the
        state of the span that the other number describes.

    Returns
    -------
    xarray.Dataset
        Over `path`, and over the second one if given: ``vertical_hz``, ``horizontal_hz`` [Hz],
        ``ratio``, ``detuning`` (from 2:1), ``one_to_one_detuning``, and ``problem``: empty, or why
        there is no ratio, which is then NaN.

    Raises
    ------
    SceneError
        If a path is unknown, no value is given, or the two numbers determine each other.
    """
    import xarray as xr

    over = [(path, values), *([against] if against else [])]
    for name, numbers in over:
        if len(numbers) == 0:
            raise SceneError(f"values of {name}: at least one is needed")
    paths = [name for name, _ in over]
    units = [unit_of(scene, name) for name in paths]
    if len(set(paths)) < len(paths) or set(paths) == {"span.sag", "span.horizontal_tension"}:
        raise SceneError(
            f"{paths[0]} and {paths[1]}: one follows from the other, so there is no map over both"
        )
    last_first = sorted(range(len(paths)), key=lambda k: paths[k] in (TEMPERATURE, ICE_MASS))
    found: list[FrequencyRatio | str] = []
    for point in product(*(numbers for _, numbers in over)):
        try:
            changed = scene
            for k in last_first:
                changed = with_number(changed, paths[k], point[k], expansion)
            found.append(frequency_ratio(changed))
        except (SceneError, SimulationError) as problem:
            found.append(str(problem))
    shape = [len(numbers) for _, numbers in over]

    def column(name: str) -> NDArray[np.float64]:
        return np.reshape(
            [getattr(row, name) if isinstance(row, FrequencyRatio) else np.nan for row in found],
            shape,
        )

    columns = {
        "vertical_hz": "Hz",
        "horizontal_hz": "Hz",
        "ratio": "1",
        "detuning": "1",
        "one_to_one_detuning": "1",
    }
    return xr.Dataset(
        {
            **{name: (paths, column(name), {"units": unit}) for name, unit in columns.items()},
            "problem": (
                paths,
                np.reshape([row if isinstance(row, str) else "" for row in found], shape),
            ),
        },
        coords={
            name: (name, np.asarray(numbers, dtype=np.float64), {"units": unit})
            for (name, numbers), unit in zip(over, units, strict=True)
        },
        attrs={"title": scene.title},
    )


def crossings(
    scene: Scene,
    path: str,
    values: Sequence[float],
    ratio: float = 2.0,
    expansion: float = ACSR_EXPANSION,
) -> list[float]:
    """Values of a number at which the frequency ratio is 2, or another ratio.

    Parameters
    ----------
    scene, path, values, expansion
        As in `ratio_map`; a crossing is found between neighbouring values on different sides of it.
    ratio
        The ratio looked for.

    Returns
    -------
    list of float
        In the unit of the number, to a relative accuracy of 1e-6; empty where the ratio is not
        crossed.

    Raises
    ------
    SceneError
        If there is no ratio at one of the values, so that a crossing there could be missed.
    """
    from scipy.optimize import brentq  # slow to import

    data = ratio_map(scene, path, values, expansion)
    known = data.ratio.values - ratio
    for value, problem in zip(values, data.problem.values, strict=True):
        if problem:
            raise SceneError(f"at {path} = {value:g} there is no frequency ratio: {problem}")

    def excess(value: float) -> float:
        return frequency_ratio(with_number(scene, path, value, expansion)).ratio - ratio

    return [
        (
            float(values[k])
            if known[k] == 0.0
            else float(brentq(excess, values[k], values[k + 1], rtol=1e-6))
        )
        for k in range(len(values) - 1)
        if known[k] == 0.0 or known[k] * known[k + 1] < 0.0
    ] + ([float(values[-1])] if known[-1] == 0.0 else [])


def way_out(scene: Scene) -> list[DesignChange]:
    """Which changes of design move a span away from the 2:1 resonance, the strongest first.

    Tension, axial stiffness, span length and the stiffness of springs along the span are each
    raised and lowered by a tenth; of both directions the one that ends further from the resonance
    is told.

    Raises
    ------
    SceneError
        If the scene itself has no frequency ratio.
    """
    here = frequency_ratio(free_sag(scene))
    changes = []
    for path in DESIGN:
        try:
            value = number_of(scene, path)
            step = STEP * value
            both = [
                frequency_ratio(with_number(scene, path, value + sign * step)) for sign in (-1, 1)
            ]
        except (SceneError, SimulationError):
            continue  # the scene does not have it, or it cannot be built
        sensitivity = (both[1].ratio - both[0].ratio) / (2.0 * STEP)
        better = max((0, 1), key=lambda k: abs(both[k].detuning))
        after = value + (-step, step)[better]
        changes.append(
            DesignChange(
                path=path,
                unit=unit_of(scene, path),
                before=value,
                after=after,
                detuning_before=here.detuning,
                detuning_after=both[better].detuning,
                sensitivity=sensitivity,
                sentence=_sentence(path, unit_of(scene, path), value, after, here, both[better]),
            )
        )
    return sorted(changes, key=lambda change: -abs(change.detuning_after))


def _sentence(
    path: str, unit: str, before: float, after: float, here: FrequencyRatio, there: FrequencyRatio
) -> str:
    first, last = (f"{float(f'{value:.4g}'):,.10g}" for value in (before, after))
    change = f"{'raising' if after > before else 'lowering'} {path} from {first} to {last} {unit}"
    effect = "away from" if abs(there.detuning) > abs(here.detuning) else "nearer to"
    return (
        f"{change} takes the ratio from {here.ratio:.3f} to {there.ratio:.3f}, {effect} 2:1 "
        f"(detuning {here.detuning:+.1%} to {there.detuning:+.1%})"
    )


def _first_symmetric(modes: list[Mode], family: Family) -> Mode:
    found = [mode for mode in modes if mode.family == family and mode.symmetric]
    if not found:
        raise SceneError(
            f"no symmetric {family} mode among the lowest {len(modes)}, up to"
            f" {modes[-1].frequency_hz:.4g} Hz; look at natural_modes(scene, count=...) with a"
            " larger count"
        )
    first = found[0]
    if first.shares[family] < CLEAR_SHARE:
        shares = ", ".join(f"{name} {share:.0%}" for name, share in first.shares.items())
        raise SceneError(
            f"the first symmetric {family} mode at {first.frequency_hz:.4g} Hz is a mixture"
            f" ({shares}), so the frequency ratio means nothing; the eccentric ice or the supports"
            " couple the families, see natural_modes(scene)"
        )
    if first.own_image < CLEAR_SYMMETRY:
        raise SceneError(
            f"the first symmetric {family} mode at {first.frequency_hz:.4g} Hz cannot be told from"
            f" an antisymmetric one: only {first.own_image:.0%} of it is symmetric, because two"
            " modes cross or veer here, so the frequency ratio means nothing; see"
            " natural_modes(scene) and track_modes(scene, ...)"
        )
    return first
