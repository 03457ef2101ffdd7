"""The file of a winter: distributions of wind and ice in an ice event, and events per winter."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from gallop_fmu import SceneError
from gallop_fmu.foundation.text_files import parse_toml, read_text
from modal.risk.quantities import EXAMPLE, NAME

RATE, RANDOM = "events_per_winter", "random"


class Winter(NamedTuple):
    """Distributions by dotted path, and the mean number of ice events in a winter."""

    random: dict[str, Mapping[str, Any]]
    events_per_winter: float


def read_winter(path: Path | str) -> Winter:
    """Read a TOML file with ``events_per_winter`` and a table ``[random]``.

    Examples of keys are ``wind.speed`` and ``line.ice_thickness``; each has a table such as
    ``{distribution = "weibull_min", c = 2.0, scale = 6.0}``.

    Raises
    ------
    SceneError
        The file is unreadable, or has other keys.
    """
    data = parse_toml(read_text(Path(path)))
    if other := sorted(data.keys() - {RATE, RANDOM}):
        raise SceneError(f"{path}: {other[0]}: the file has {RATE} and the table [{RANDOM}]")
    rate, random = data.get(RATE, 1.0), data.get(RANDOM, {})
    if isinstance(rate, bool) or not isinstance(rate, (int, float)):
        raise SceneError(f"{path}: {RATE} = {rate!r}: must be a number")
    if not isinstance(random, Mapping):
        raise SceneError(f"{path}: {RANDOM} must be a table of distributions")
    return Winter(dict(_leaves(str(path), "", random)), float(rate))


def _leaves(
    path: str, start: str, table: Mapping[str, Any]
) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Yield each distribution with its dotted path."""
    for name, value in table.items():
        key = f"{start}{name}"
        if not isinstance(value, Mapping):
            raise SceneError(f"{path}: {key} = {value!r}: must be a distribution such as {EXAMPLE}")
        if NAME in value:
            yield key, value
        else:
            yield from _leaves(path, f"{key}.", value)
