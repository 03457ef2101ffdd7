"""Random quantities: values of a scene with a distribution of `scipy.stats`."""

from __future__ import annotations

import difflib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gallop_fmu import SceneError

Array = NDArray[np.float64]

NAME = "distribution"
"""Key of the name of a distribution; the others are its parameters."""
EXAMPLE = '{distribution = "weibull_min", c = 2.0, scale = 6.0}'


@dataclass(frozen=True)
class Quantity:
    """A value of a scene that is random.

    Attributes
    ----------
    key : str
        Dotted path of the value, such as ``wind.speed``.
    distribution : scipy.stats frozen distribution
        Its continuous distribution, in the unit of the value.
    text : str
        Name and parameters of the distribution.
    """

    key: str
    distribution: Any
    text: str

    def values(self, shares: Array) -> Array:
        """Return the values at which the distribution function has the given shares.

        Raises
        ------
        SceneError
            A value is not finite.
        """
        found = np.asarray(self.distribution.ppf(shares), dtype=np.float64)
        if not np.all(np.isfinite(found)):
            raise SceneError(
                f"{self.key}: {self.text} has values that are not finite; check its parameters"
            )
        return found


def quantities(given: Mapping[str, Any]) -> tuple[Quantity, ...]:
    """Read the random quantities of an atlas.

    Parameters
    ----------
    given
        Dotted path to a frozen distribution of `scipy.stats`, such as ``stats.weibull_min(2.0,
        scale=6.0)``, or to a table with the key ``distribution`` (a name of `scipy.stats`) and
        its parameters, such as ``{"distribution": "weibull_min", "c": 2.0, "scale": 6.0}``.

    Raises
    ------
    SceneError
        There is none; a distribution is unknown or not continuous; or a parameter is missing,
        unknown, or not allowed.
    """
    if not given:
        raise SceneError(f"no random quantity is given; give one, such as wind.speed = {EXAMPLE}")
    return tuple(
        _from_table(key, value) if isinstance(value, Mapping) else _from_scipy(key, value)
        for key, value in given.items()
    )


def _from_scipy(key: str, value: Any) -> Quantity:
    from scipy import stats

    inner = getattr(value, "dist", None)
    if not isinstance(inner, stats.rv_continuous):
        raise SceneError(
            f"{key} = {value!r}: must be a frozen continuous distribution of scipy.stats, or a"
            f" table such as {EXAMPLE}"
        )
    parameters = [f"{number:g}" for number in value.args]
    parameters += [f"{name} = {number:g}" for name, number in value.kwds.items()]
    return _checked(key, value, f"{inner.name}({', '.join(parameters)})")


def _from_table(key: str, table: Mapping[str, Any]) -> Quantity:
    from scipy import stats

    known = [name for name, value in vars(stats).items() if isinstance(value, stats.rv_continuous)]
    name = str(table.get(NAME))
    if name not in known:
        closest = difflib.get_close_matches(name, known, n=1, cutoff=0.0)[0]
        raise SceneError(
            f"{key}.{NAME} = {name!r}: must be the name of a continuous distribution of"
            f" scipy.stats, such as norm, uniform, lognorm or weibull_min; did you mean {closest}?"
        )
    family = getattr(stats, name)
    parameters = {word: value for word, value in table.items() if word != NAME}
    _check_parameters(key, family, parameters)
    text = ", ".join(f"{word} = {value:g}" for word, value in parameters.items())
    return _checked(key, family(**parameters), f"{name}({text})")


def _check_parameters(key: str, family: Any, parameters: Mapping[str, Any]) -> None:
    """Refuse parameters that a family of distributions does not have, or that are no numbers."""
    shapes = [] if family.shapes is None else [word.strip() for word in family.shapes.split(",")]
    allowed = [*shapes, "loc", "scale"]
    for word, value in parameters.items():
        if word not in allowed:
            raise SceneError(f"{key}.{word}: {family.name} has the parameters {', '.join(allowed)}")
        if isinstance(value, bool) or not isinstance(value, (int, float)):
            raise SceneError(f"{key}.{word} = {value!r}: must be a number")
        if not math.isfinite(value):
            raise SceneError(f"{key}.{word} = {value}: must be finite")
    for word in shapes:
        if word not in parameters:
            raise SceneError(f"{key}: {family.name} needs {word}; give it, such as {word} = 2.0")


def _checked(key: str, distribution: Any, text: str) -> Quantity:
    """Return a quantity whose parameters are allowed."""
    middle = float(distribution.median())
    if not math.isfinite(middle):
        raise SceneError(
            f"{key}: {text} is not a distribution; scale must be positive, and each shape"
            " parameter in its range"
        )
    return Quantity(key, distribution, text)
