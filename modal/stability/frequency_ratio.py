"""Frequency ratio of a span: its distance from the 2:1 resonance of galloping and swing."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, overload

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import LineScene, Scene, SceneError, SimulationError
from gallop_fmu.input.scene_like import SceneLike, SpanLike, as_scene, as_span
from modal.foundation import one_span as instead
from modal.foundation.change_of_state import ACSR_EXPANSION
from modal.foundation.one_thread import one_thread
from modal.foundation.scene_variation import (
    ICE_MASS,
    TEMPERATURE,
    free_sag,
    number_of,
    unit_of,
    with_number,
)
from modal.linear.linearise import linearised
from modal.linear.modes import Family, Mode, each_mode, modes_of
from modal.stability.mode_pairs import ModePair, mode_pairs

if TYPE_CHECKING:
    import xarray as xr

FIRST_SEARCHED, SEARCHED_MODES = 8, 24
"""Modes searched for the first symmetric ones, and those searched if these have not both.

Between rigid ends at most five lie below them, more only if the conductor is very soft in torsion.
"""

MIN_FAMILY_SHARE = 0.6
"""Share of the kinetic energy above which a mode clearly belongs to its family."""

MIN_SYMMETRIC_SHARE = 0.8
"""Share of the squared motion above which a mode is clearly symmetric; below 1 on a slope."""

CROSSING_TOLERANCE = 1e-6
"""Relative accuracy of a value at which the ratio is 2."""

DESIGN_NUMBERS = (
    "span.horizontal_tension",
    "conductor.axial_stiffness",
    "span.length",
    "supports.left.stiffness_x1",
    "supports.right.stiffness_x1",
)
"""Numbers that a designer can choose, which `suggest_design_changes` varies."""

DESIGN_STEP = 0.1
"""Relative change of a number in `suggest_design_changes`."""

COLUMNS = {
    "vertical_hz": "Hz",
    "horizontal_hz": "Hz",
    "ratio": "1",
    "detuning": "1",
    "one_to_one_detuning": "1",
}
"""Numbers of a ratio map, and their units."""


@dataclass(frozen=True, repr=False)
class FrequencyRatio:
    """Frequencies of the first symmetric pair, their ratio, and its distance from 2 and from 1.

    Attributes
    ----------
    vertical_hz, horizontal_hz : float
        Natural frequency [Hz] of the first symmetric vertical and horizontal mode.
    """

    vertical_hz: float
    horizontal_hz: float

    def __repr__(self) -> str:
        return (
            f"FrequencyRatio(vertical {self.vertical_hz:.4f} Hz, horizontal"
            f" {self.horizontal_hz:.4f} Hz, ratio {self.ratio:.4f})"
        )

    @property
    def ratio(self) -> float:
        """Vertical over horizontal frequency; 2 is the internal resonance of Liu et al. (2009)."""
        return self.vertical_hz / self.horizontal_hz

    @property
    def detuning(self) -> float:
        """Relative distance from the 2:1 resonance, ratio / 2 - 1."""
        return self.ratio / 2.0 - 1.0

    @property
    def one_to_one_detuning(self) -> float:
        """Relative distance from the 1:1 resonance, ratio - 1; near 0 for taut spans."""
        return self.ratio - 1.0


@dataclass(frozen=True)
class DesignChange:
    """Effect of one design change on the frequency ratio.

    Attributes
    ----------
    path : str
        Path of the changed number, as in `ratio_map`.
    unit : str
        Its unit.
    before, after : float
        Its value before and after.
    detuning_before, detuning_after : float
        Distance from 2:1, ratio / 2 - 1.
    sensitivity : float
        Change of the ratio per relative change of the number (d ratio / d ln value).
    sentence : str
        The same as a sentence.
    """

    path: str
    unit: str
    before: float
    after: float
    detuning_before: float
    detuning_after: float
    sensitivity: float
    sentence: str


@overload
def frequency_ratio(scene: Scene) -> FrequencyRatio: ...


@overload
def frequency_ratio(scene: LineScene) -> list[ModePair]: ...


@overload
def frequency_ratio(scene: SceneLike) -> FrequencyRatio | list[ModePair]: ...


@one_thread
def frequency_ratio(scene: SceneLike) -> FrequencyRatio | list[ModePair]:
    """Compute the ratio of the first symmetric vertical to the first horizontal frequency.

    Near a ratio of 2, vertical galloping drives a horizontal swing at half its frequency, if its
    amplitude exceeds a threshold (Liu, Yan, Zhang, Zhou 2009, Example 3).

    A line has many modes close to each other, vertical and horizontal ones and rotations of
    bundles: all pairs of its lowest modes near 2:1 and 1:1 are returned, with the amplitude above
    which the first starts the second (`modal.mode_pairs`).

    Raises
    ------
    SceneError
        If one of the two modes cannot be identified among the lowest ones.
    SimulationError
        If no initial equilibrium exists.
    """
    scene = as_scene(scene)
    if isinstance(scene, LineScene):
        return mode_pairs(scene)
    unknowns = 4 * (2 * scene.elements - 1)  # of the interior nodes; there may be more
    equations = linearised(scene, "still")
    modes = _up_to_both(each_mode(equations, scene, min(FIRST_SEARCHED, unknowns)))
    if not _has_both(modes):
        modes = modes_of(equations, scene, min(SEARCHED_MODES, unknowns))
    return FrequencyRatio(
        vertical_hz=_first_symmetric(modes, "vertical").frequency_hz,
        horizontal_hz=_first_symmetric(modes, "horizontal").frequency_hz,
    )


@one_thread
def ratio_map(
    scene: SpanLike,
    path: str,
    values: Sequence[float],
    expansion: float = ACSR_EXPANSION,
    against: tuple[str, Sequence[float]] | None = None,
) -> xr.Dataset:
    """Compute frequency ratio and detuning over values of one number of a span, or of two.

    Parameters
    ----------
    scene
        The span.
    path
        Dotted path of the number. Some paths include what follows from the number on a line:

        - ``span.horizontal_tension`` and ``span.sag``: the other of the two is computed, even if
          the scene prescribes both;
        - ``ice.mass_per_length``: ice on the strung conductor, with constant unstretched length
          (`change_of_state`);
        - ``temperature_change``: rise of temperature from the scene's state [K], with the same
          change of state;
        - ``supports.stiffness_x1``, ``supports.stiffness_x3``: the springs of both ends together.
    values
        Values of the number in its unit.
    expansion
        Coefficient of linear expansion [1/K] for ``temperature_change``; the default is for ACSR
        26/7.
    against
        Path and values of a second number, for a map over both. A change of temperature or ice is
        applied after the change of the other number.

    Returns
    -------
    xarray.Dataset
        Over `path`, and over the second path if given: ``vertical_hz``, ``horizontal_hz`` [Hz],
        ``ratio``, ``detuning`` (from 2:1), ``one_to_one_detuning``, and ``problem``: empty, or the
        reason why the ratio does not exist and is NaN.

    Raises
    ------
    SceneError
        If a path is unknown, no value is given, or the two numbers determine each other.
    """
    scene = as_span(scene, "ratio_map", instead.VARIATION)
    over = [(path, values), *([against] if against else [])]
    units = _checked_units(scene, over)
    points = list(product(*(numbers for _, numbers in over)))
    found = [_ratio_at(scene, [name for name, _ in over], point, expansion) for point in points]
    return _ratio_dataset(scene.title, over, units, found)


def _checked_units(scene: Scene, over: list[tuple[str, Sequence[float]]]) -> list[str]:
    """Units of the varied numbers.

    Raises
    ------
    SceneError
        If a path is unknown, no value is given, or the two numbers determine each other.
    """
    for name, numbers in over:
        if len(numbers) == 0:
            raise SceneError(f"values of {name}: at least one is needed")
    paths = [name for name, _ in over]
    units = [unit_of(scene, name) for name in paths]
    if len(set(paths)) < len(paths) or set(paths) == {"span.sag", "span.horizontal_tension"}:
        raise SceneError(
            f"{paths[0]} and {paths[1]}: each determines the other, so there is no map over both;"
            " choose another second number"
        )
    return units


def _ratio_at(
    scene: Scene, paths: list[str], values: Sequence[float], expansion: float
) -> FrequencyRatio | str:
    """Frequency ratio with some numbers changed, or the reason why there is none.

    Changes of temperature and ice come last: they change the state that the others describe.
    """
    order = sorted(range(len(paths)), key=lambda k: paths[k] in (TEMPERATURE, ICE_MASS))
    try:
        for k in order:
            scene = with_number(scene, paths[k], values[k], expansion)
        return frequency_ratio(scene)
    except (SceneError, SimulationError) as problem:
        return str(problem)


def _ratio_dataset(
    title: str,
    over: list[tuple[str, Sequence[float]]],
    units: list[str],
    found: list[FrequencyRatio | str],
) -> xr.Dataset:
    """Arrange the ratios over the varied numbers, the last one fastest."""
    import xarray as xr

    paths, shape = [name for name, _ in over], [len(numbers) for _, numbers in over]

    def column(name: str) -> NDArray[np.float64]:
        values = [
            getattr(row, name) if isinstance(row, FrequencyRatio) else np.nan for row in found
        ]
        return np.reshape(values, shape)

    problems = [row if isinstance(row, str) else "" for row in found]
    return xr.Dataset(
        {
            **{name: (paths, column(name), {"units": unit}) for name, unit in COLUMNS.items()},
            "problem": (paths, np.reshape(problems, shape)),
        },
        coords={
            name: (name, np.asarray(numbers, dtype=np.float64), {"units": unit})
            for (name, numbers), unit in zip(over, units, strict=True)
        },
        attrs={"title": title},
    )


@one_thread
def crossings(
    scene: SpanLike,
    path: str,
    values: Sequence[float],
    ratio: float = 2.0,
    expansion: float = ACSR_EXPANSION,
) -> list[float]:
    """Find the values of a number at which the frequency ratio is 2, or another ratio.

    Parameters
    ----------
    scene, path, values, expansion
        As in `ratio_map`; a crossing is found between two neighbouring values if they are on
        different sides of it.
    ratio
        The ratio.

    Returns
    -------
    list of float
        In the unit of the number, to a relative accuracy of 1e-6; empty if the ratio is not
        crossed.

    Raises
    ------
    SceneError
        If there is no ratio at one of the values, so that a crossing could be missed.
    """
    from scipy.optimize import brentq  # slow to import

    span = as_span(scene, "crossings", instead.VARIATION)
    data = ratio_map(span, path, values, expansion)
    for value, problem in zip(values, data.problem.values, strict=True):
        if problem:
            raise SceneError(f"at {path} = {value:g} there is no frequency ratio: {problem}")
    known = data.ratio.values - ratio

    def excess(value: float) -> float:
        return frequency_ratio(with_number(span, path, value, expansion)).ratio - ratio

    found = []
    for k, value in enumerate(values):
        if known[k] == 0.0:
            found.append(float(value))
        elif k + 1 < len(values) and known[k] * known[k + 1] < 0.0:
            found.append(float(brentq(excess, value, values[k + 1], rtol=CROSSING_TOLERANCE)))
    return found


@one_thread
def suggest_design_changes(scene: SpanLike) -> list[DesignChange]:
    """Suggest design changes that move a span away from the 2:1 resonance, the strongest first.

    Tension, axial stiffness, span length and the stiffness of springs along the span are each
    raised and lowered by a tenth; of the two, the change that ends further from the resonance is
    suggested.

    Raises
    ------
    SceneError
        If the scene itself has no frequency ratio.
    """
    scene = as_span(scene, "suggest_design_changes", instead.VARIATION)
    now = frequency_ratio(free_sag(scene))
    changes = []
    for path in DESIGN_NUMBERS:
        try:
            changes.append(_design_change(scene, path, now))
        except (SceneError, SimulationError):
            continue  # the scene does not have this number, or no ratio with it changed
    return sorted(changes, key=lambda change: -abs(change.detuning_after))


def _design_change(scene: Scene, path: str, now: FrequencyRatio) -> DesignChange:
    """Change of one number by a tenth that ends further from 2:1."""
    value, unit = number_of(scene, path), unit_of(scene, path)
    step = DESIGN_STEP * value
    ratios = [frequency_ratio(with_number(scene, path, value + sign * step)) for sign in (-1, 1)]
    better = max((0, 1), key=lambda k: abs(ratios[k].detuning))
    after = value + (-step, step)[better]
    return DesignChange(
        path=path,
        unit=unit,
        before=value,
        after=after,
        detuning_before=now.detuning,
        detuning_after=ratios[better].detuning,
        sensitivity=(ratios[1].ratio - ratios[0].ratio) / (2.0 * DESIGN_STEP),
        sentence=_sentence(path, unit, value, after, now, ratios[better]),
    )


def _sentence(
    path: str, unit: str, before: float, after: float, now: FrequencyRatio, then: FrequencyRatio
) -> str:
    first, last = (f"{float(f'{value:.4g}'):,.10g}" for value in (before, after))
    change = f"{'raising' if after > before else 'lowering'} {path} from {first} to {last} {unit}"
    effect = "away from" if abs(then.detuning) > abs(now.detuning) else "nearer to"
    return (
        f"{change} changes the ratio from {now.ratio:.3f} to {then.ratio:.3f}, {effect} 2:1 "
        f"(detuning {now.detuning:+.1%} to {then.detuning:+.1%})"
    )


def _up_to_both(modes: Iterable[Mode]) -> list[Mode]:
    """Modes up to that with which both symmetric ones are known, or all."""
    found: list[Mode] = []
    for mode in modes:
        found.append(mode)
        if _has_both(found):
            break
    return found


def _has_both(modes: Sequence[Mode]) -> bool:
    """True if a vertical and a horizontal mode are symmetric."""
    return {"vertical", "horizontal"} <= {mode.family for mode in modes if mode.symmetric}


def _first_symmetric(modes: list[Mode], family: Family) -> Mode:
    """First symmetric mode of a family; SceneError if it cannot be identified."""
    found = [mode for mode in modes if mode.family == family and mode.symmetric]
    if not found:
        raise SceneError(
            f"no symmetric {family} mode among the lowest {len(modes)}, up to"
            f" {modes[-1].frequency_hz:.4g} Hz; see natural_modes(scene, count=...) with a larger"
            " count"
        )
    first = found[0]
    if first.shares[family] < MIN_FAMILY_SHARE:
        shares = ", ".join(f"{name} {share:.0%}" for name, share in first.shares.items())
        raise SceneError(
            f"the first symmetric {family} mode at {first.frequency_hz:.4g} Hz is a mixture"
            f" ({shares}), so that the frequency ratio has no meaning: the eccentric ice or the"
            " supports couple the families; see natural_modes(scene)"
        )
    if first.symmetric_share < MIN_SYMMETRIC_SHARE:
        raise SceneError(
            f"the first symmetric {family} mode at {first.frequency_hz:.4g} Hz cannot be"
            f" distinguished from an antisymmetric one: only {first.symmetric_share:.0%} of it is"
            " symmetric, because two modes cross or veer here, so that the frequency ratio has no"
            " meaning; see natural_modes(scene) and track_modes(scene, ...)"
        )
    return first
