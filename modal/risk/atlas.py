"""Risk atlas: probabilities of galloping, swing and clash of spans, quantiles of amplitudes."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from gallop_fmu import LineScene, Runs, Scene, SceneError, sweep
from gallop_fmu.foundation.atomic_write import check_target, netcdf_bytes, write_whole
from gallop_fmu.foundation.figures import drawn
from gallop_fmu.foundation.notebook_table import notebook_table
from gallop_fmu.foundation.text_rules import counted, read_number
from gallop_fmu.input.scene_spec import SceneSpec
from gallop_fmu.sweeps.cases import GEOMETRY, NAME, SpanTable, spans_of
from gallop_fmu.sweeps.runner import Progress
from modal.foundation.one_thread import one_thread
from modal.risk.draws import Draws, Sampling, draw
from modal.risk.outcomes import METHODS, Found, Method, found_by_estimate, found_by_simulation
from modal.risk.quantities import Quantity, quantities
from modal.risk.statistics import (
    MAX_UNRESOLVED,
    Interval,
    convergence,
    probability,
    quantile,
    sobol_shares,
)
from modal.screening.many_spans import screen_spans

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

CLEARANCE = "label.clearance"
"""Column of the table with the clearance [m] of each span."""
SPAN = "label.span"
"""Column of the runs with the name of the span."""

RETURN_PERIODS = (2.0, 5.0, 10.0, 25.0, 50.0, 100.0)
"""Return periods [winters] of the amplitude."""

EVENTS = {
    "galloping": "an ice event makes the span gallop",
    "swing": "an ice event starts the horizontal swing of the 2:1 resonance",
    "clash": "twice the vertical amplitude of an ice event exceeds the clearance",
}
"""Event to meaning of its probability."""


@dataclass(frozen=True, repr=False)
class RiskAtlas:
    """Risk of spans for random wind and ice, from `modal.risk_atlas`.

    Attributes
    ----------
    dataset : xarray.Dataset
        Over ``span``: ``galloping``, ``swing`` and ``clash``, probabilities of an ice event, with
        ``_lowest`` and ``_highest`` of their confidence interval (95 %, which includes draws that
        are not resolved), the same of a winter as ``winter_galloping`` and so on, and
        ``unresolved``, the share of such draws. Over ``span`` and ``return_period`` [winters]:
        ``amplitude`` [m], half peak-to-peak, with its interval. Over ``span`` and ``draws``:
        ``galloping_of_draws`` with its interval, which shows the convergence. Over ``span`` and
        ``quantity``, if asked for: ``first_share`` and ``total_share`` of the amplitude's variance.
    runs : Runs
        All runs, one for each span and draw.
    remarks : tuple of str
        What limits the trust in the numbers.
    """

    dataset: xr.Dataset
    runs: Runs
    remarks: tuple[str, ...]

    def __repr__(self) -> str:
        spans = self.dataset.sizes["span"]
        worst = self.dataset.winter_galloping
        at = int(worst.fillna(-1.0).argmax("span"))
        return (
            f"RiskAtlas({counted(spans, 'span')}, {counted(self.runs.total, 'run')}; most likely to"
            f" gallop in a winter: {worst.span.values[at]}, {worst.values[at]:.2g})"
        )

    def _repr_html_(self) -> str:
        """Table for notebooks."""
        names = tuple(f"winter_{event}" for event in EVENTS)
        return notebook_table(
            f"Probability in a winter [1] and its 95 % interval, {counted(self.runs.total, 'run')}",
            ("span", *EVENTS),
            [
                (str(row["span"]), *(_with_interval(row, name) for name in names))
                for row in self.table().to_dict("records")
            ],
            self.remarks,
        )

    def plot(self) -> Any:
        """Draw probabilities, amplitudes and convergence by `modal.plots.risk_figure`.

        Returns
        -------
        matplotlib.figure.Figure
        """
        return drawn("RiskAtlas.plot", self)

    def table(self) -> pd.DataFrame:
        """Return one row for each span: probabilities, and amplitudes of each return period.

        Numbers that are not known are None.
        """
        import pandas as pd

        data = self.dataset
        rows: list[dict[str, Any]] = []
        for span in data.span.values.tolist():
            at = data.sel(span=span)
            row: dict[str, Any] = {"span": span}
            for name, values in at.data_vars.items():
                if not values.dims:
                    row[str(name)] = values.item()
            for period in at.return_period.values.tolist():
                for end in ("", "_lowest", "_highest"):
                    value = at[f"amplitude{end}"].sel(return_period=period).item()
                    row[f"amplitude_{period:g}_winters{end}"] = value
            rows.append(row)
        frame = pd.DataFrame(rows).astype(object)
        return frame.where(frame.notna(), None)

    def write(self, path: Path | str) -> None:
        """Write the risk of each span.

        Parameters
        ----------
        path
            ``.csv`` and ``.geojson`` have the rows of `table`, ``.nc`` the dataset. In GeoJSON the
            spans have the geometry of their table.

        Raises
        ------
        SceneError
            The name has another ending, or the file cannot be replaced.
        OSError
            The file cannot be written.
        """
        path = Path(path)
        check_target(path, (".csv", ".geojson", ".nc"))
        if path.suffix.lower() == ".nc":
            write_whole(path, netcdf_bytes(self.dataset))
            return
        frame = self.table()
        if path.suffix.lower() == ".csv":
            write_whole(path, frame.to_csv(index=False).encode())
            return
        places = self._geometries()
        features = [
            {
                "type": "Feature",
                "id": row["span"],
                "geometry": places.get(row["span"]),
                "properties": row,
            }
            for row in frame.to_dict("records")
        ]
        content = {"type": "FeatureCollection", "features": features}
        write_whole(path, json.dumps(content, allow_nan=False).encode())

    def _geometries(self) -> dict[str, Any]:
        """Geometry of each span whose table has one."""
        data = self.runs.dataset
        if GEOMETRY not in data:
            return {}
        pairs = zip(data[SPAN].values.tolist(), data[GEOMETRY].values.tolist(), strict=True)
        return {span: json.loads(text) for span, text in dict(pairs).items() if text}


def _with_interval(row: Mapping[str, Any], name: str) -> str:
    """Value of a row with its interval; a dash if it is not known."""
    if row[name] is None:
        return "-"
    return f"{row[name]:.3g} ({row[f'{name}_lowest']:.3g} to {row[f'{name}_highest']:.3g})"


@one_thread
def risk_atlas(  # noqa: PLR0913 - all but two are keyword arguments
    scene: Scene | LineScene | SceneSpec | str | Path | None,
    random: Mapping[str, Any],
    *,
    table: SpanTable | None = None,
    draws: int = 256,
    seed: int = 0,
    sampling: Sampling = "sobol",
    shares: bool = False,
    method: Method = "estimate",
    stop_time: float | None = None,
    events_per_winter: float = 1.0,
    clearance: float | None = None,
    out: Path | str | None = None,
    workers: int | None = None,
    cluster: str | None = None,
    progress: Progress | None = None,
) -> RiskAtlas:
    """Compute the risk of spans for random wind and ice.

    Each span is computed for the same draws of the random quantities. The quantities are
    independent of each other.

    Parameters
    ----------
    scene, table, out, workers, cluster, progress
        As for `gallop_fmu.sweep`. A column ``label.clearance`` of the table is the `clearance` of
        each span. The same call with `out` computes only what is missing.
    random
        Dotted path of a value to its distribution in an ice event: a frozen distribution of
        `scipy.stats`, or a table such as ``{"distribution": "weibull_min", "c": 2.0, "scale":
        6.0}``.
    draws
        Number of draws for the probabilities, a power of two.
    seed
        Seed of the draws.
    sampling
        ``"sobol"`` or ``"latin_hypercube"``.
    shares
        True computes Sobol shares, too: the runs become ``1 + quantities / 2`` times as many.
    method
        ``"estimate"``: amplitude of the first symmetric vertical mode (`modal.two_mode_estimate`),
        some milliseconds a draw; spans only. ``"simulate"``: `gallop_fmu.sweep`; spans and lines.
    stop_time
        Simulated time [s]; None takes the scene's.
    events_per_winter
        Mean number of ice events in a winter. They are a Poisson process, so that an event of the
        probability p occurs in a winter with the probability 1 - exp(-events_per_winter p).
    clearance
        Vertical distance [m] of two phases, less the flashover distance. They clash if twice the
        vertical amplitude exceeds it: both phases gallop against each other.

    Returns
    -------
    RiskAtlas
        Probabilities and amplitudes of each span, with confidence intervals.

    Raises
    ------
    SceneError, RunsStoppedError
        As for `gallop_fmu.sweep`; or a distribution is not allowed.

    Examples
    --------
    >>> import modal
    >>> wind = {"wind.speed": {"distribution": "uniform", "loc": 2.0, "scale": 6.0}}
    >>> found = modal.risk_atlas("example3", wind, draws=64)
    >>> round(found.dataset.galloping.item(), 2)
    0.58
    """
    if method not in METHODS:
        raise SceneError(f"method = {method!r}: must be {' or '.join(METHODS)}")
    if not (math.isfinite(events_per_winter) and events_per_winter > 0.0):
        raise SceneError(f"events_per_winter = {events_per_winter}: must be positive and finite")
    found = quantities(random)
    drawn = draw(len(found), draws, seed, sampling, shares=shares)
    spans = [{NAME: "span"}] if table is None else spans_of(table)
    limits = [_clearance(row, clearance) for row in spans]
    rows = list(_rows(spans, found, drawn))
    compute: Callable[..., Runs] = (
        partial(screen_spans, estimate_only=True)
        if method == "estimate"
        else partial(sweep, stop_time=stop_time)
    )
    runs = compute(scene, table=rows, out=out, workers=workers, cluster=cluster, progress=progress)
    names, outcomes, limits = _outcomes(runs, spans, limits, method)
    dataset = _dataset(names, outcomes, limits, (found, drawn), events_per_winter)
    remarks = (*_remarks(names, outcomes, method, found), *_missing_shares(dataset))
    return RiskAtlas(dataset, runs, remarks)


def _rows(
    spans: Sequence[Mapping[str, Any]], random: Sequence[Quantity], drawn: Draws
) -> Iterator[dict[str, Any]]:
    """Yield a row of the table of runs for each span and draw."""
    values = [quantity.values(drawn.points[:, k]).tolist() for k, quantity in enumerate(random)]
    for span in spans:
        if twice := next((each.key for each in random if each.key in span), None):
            raise SceneError(f"{twice}: given in the table and as random; give it in one of them")
        for number, point in enumerate(zip(*values, strict=True)):
            yield {
                **span,
                NAME: f"{span[NAME]}, draw {number}",
                SPAN: span[NAME],
                **dict(zip((each.key for each in random), point, strict=True)),
            }


def _clearance(row: Mapping[str, Any], default: float | None) -> float:
    """Clearance [m] of a span; NaN without one."""
    given = row.get(CLEARANCE)
    value = default if given is None else read_number(str(given))
    if value is None and given is None:
        return math.nan
    if value is None or not (math.isfinite(value) and value > 0.0):
        where = "clearance" if given is None else f"span {row[NAME]}: {CLEARANCE}"
        shown = value if given is None else given
        raise SceneError(f"{where} = {shown}: must be a positive number [m]")
    return float(value)


def _outcomes(
    runs: Runs, spans: Sequence[Mapping[str, Any]], limits: list[float], method: Method
) -> tuple[list[str], list[Found], list[float]]:
    """Names, outcomes and clearances of all spans; a line has several."""
    each = runs.dataset.sizes["run"] // len(spans)
    parts = [
        (row[NAME], runs.dataset.isel(run=slice(k * each, (k + 1) * each)), limits[k])
        for k, row in enumerate(spans)
    ]
    if method == "estimate":
        return [n for n, _, _ in parts], [found_by_estimate(p) for _, p, _ in parts], limits
    if "span_u2_amplitude" not in runs.dataset:
        return [n for n, _, _ in parts], [found_by_simulation(p) for _, p, _ in parts], limits
    names, outcomes, clearances = [], [], []
    for name, part, limit in parts:
        for span in part.span.values.tolist():
            if np.all(np.isnan(part.span_u2_amplitude.sel(span=span).values)) and len(parts) > 1:
                continue  # another line has more spans
            names.append(f"span {span}" if len(parts) == 1 else f"{name}, span {span}")
            outcomes.append(found_by_simulation(part, span))
            clearances.append(limit)
    return names, outcomes, clearances


def _dataset(
    names: list[str],
    outcomes: list[Found],
    limits: list[float],
    random: tuple[tuple[Quantity, ...], Draws],
    rate: float,
) -> xr.Dataset:
    import xarray as xr

    found, drawn = random
    data = xr.Dataset(coords={"span": ("span", names, {"long_name": "span"})})
    data.attrs = {
        "events_per_winter": rate,
        "random": json.dumps({each.key: each.text for each in found}),
    }
    for event, meaning in EVENTS.items():
        values = [_event(event, each, limit) for each, limit in zip(outcomes, limits, strict=True)]
        estimates = [probability(each, drawn) for each in values]
        _add(data, event, ("span",), estimates, ("1", f"probability that {meaning}"))
        winter = [Interval(*(_of_winter(p, rate) for p in _numbers(each))) for each in estimates]
        of_winter = f"probability that {meaning}, in a winter".replace("an ice event", "one")
        _add(data, f"winter_{event}", ("span",), winter, ("1", of_winter))
    data["unresolved"] = (
        "span",
        [float(np.mean(np.isnan(each.amplitude))) for each in outcomes],
        {"units": "1", "long_name": "share of draws whose amplitude is not known"},
    )
    periods = [period for period in RETURN_PERIODS if period * rate > 1.0]
    data = data.assign_coords(
        return_period=(
            "return_period",
            periods,
            {"units": "winter", "long_name": "mean time between exceedances"},
        )
    )
    heights = [
        quantile(each.amplitude, 1.0 - 1.0 / (period * rate), drawn)
        for each in outcomes
        for period in periods
    ]
    meaning = "vertical amplitude, half peak-to-peak, exceeded once in the return period"
    _add(data, "amplitude", ("span", "return_period"), heights, ("m", meaning))
    series = [convergence(each.gallops, drawn) for each in outcomes]
    data = data.assign_coords(draws=("draws", list(series[0]), {"long_name": "draws"}))
    part = "probability of galloping from the first draws"
    every = [each for one in series for each in one.values()]
    _add(data, "galloping_of_draws", ("span", "draws"), every, ("1", part))
    return _with_shares(data, outcomes, found, drawn)


def _event(event: str, found: Found, limit: float) -> Any:
    if event == "galloping":
        return found.gallops
    if event == "swing":
        return found.swings
    clashes = 2.0 * found.amplitude > limit
    unknown = np.isnan(found.amplitude) | math.isnan(limit)
    return np.where(unknown, np.nan, clashes.astype(float))


def _of_winter(share: float, rate: float) -> float:
    return -math.expm1(-rate * share)


def _numbers(each: Interval) -> tuple[float, float, float]:
    return each.value, each.lowest, each.highest


def _add(
    data: xr.Dataset,
    name: str,
    dimensions: tuple[str, ...],
    estimates: Sequence[Interval],
    meaning: tuple[str, str],
) -> None:
    """Add estimates and the ends of their intervals to a dataset."""
    shape = [data.sizes[each] for each in dimensions]
    unit, words = meaning
    columns = np.array([_numbers(each) for each in estimates]).T.reshape(3, *shape)
    for suffix, part, values in zip(
        ("", "_lowest", "_highest"),
        ("", ", lower end of the 95 % interval", ", upper end of the 95 % interval"),
        columns,
        strict=True,
    ):
        attrs = {"units": unit, "long_name": words + part}
        data[name + suffix] = (dimensions, values, attrs)


def _with_shares(
    data: xr.Dataset, outcomes: list[Found], random: tuple[Quantity, ...], drawn: Draws
) -> xr.Dataset:
    """Add the Sobol shares, if the draws for them exist."""
    if len(set(drawn.matrix)) == 1:
        return data
    data = data.assign_coords(quantity=("quantity", [each.key for each in random]))
    unknown = [Interval(np.nan, np.nan, np.nan)] * len(random)
    found = [sobol_shares(each.amplitude, drawn) or (unknown, unknown) for each in outcomes]
    for k, (name, meaning) in enumerate(
        {
            "first_share": "share of the amplitude's variance that a quantity causes alone",
            "total_share": "share that it causes alone and together with others",
        }.items()
    ):
        _add(
            data,
            name,
            ("span", "quantity"),
            [each for pair in found for each in pair[k]],
            ("1", meaning),
        )
    return data


def _remarks(
    names: list[str], outcomes: list[Found], method: Method, random: tuple[Quantity, ...]
) -> Iterator[str]:
    """Yield what limits the trust in the numbers."""
    if method == "estimate":
        yield (
            "the estimate covers vertical galloping of the first symmetric mode only; other modes"
            ' and all effects of the run need method = "simulate"'
        )
    if len(random) > 1:
        yield "the random quantities are taken as independent of each other"
    for name, found in zip(names, outcomes, strict=True):
        total = len(found.amplitude)
        if lost := sum(found.reasons.values()):
            first = next(iter(found.reasons))
            yield (
                f"{name}: {lost} of {counted(total, 'draw')} are not resolved, most often:"
                f" {first.partition('; ')[0]}"
            )
        if beyond := int(np.count_nonzero(np.isinf(found.amplitude))):
            yield (
                f"{name}: in {beyond} of {counted(total, 'draw')} the amplitude is beyond the range"
                " of the estimate; it counts as infinite"
            )


def _missing_shares(data: xr.Dataset) -> Iterator[str]:
    """Yield the spans whose Sobol shares were asked for and are not known."""
    if "first_share" not in data:
        return
    missing = data.span.values[data.first_share.isnull().any("quantity").values]
    if len(missing):
        yield (
            f"no Sobol shares of {', '.join(missing)}: they need more than"
            f" {1.0 - MAX_UNRESOLVED:.0%} of the draws resolved with a finite amplitude, and"
            " galloping in every repeat; give more draws, or narrower distributions"
        )
