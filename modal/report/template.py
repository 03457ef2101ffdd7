"""Fills in the templates of the reports."""

from __future__ import annotations

from typing import Any


def render(name: str, content: dict[str, Any], missing: type) -> str:
    """Fill in a template; every text from the scene is escaped.

    Parameters
    ----------
    name
        File of the template.
    content
        Values of the names in it.
    missing
        Type of a part that could not be computed, for the test ``is missing``.
    """
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("modal.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.tests["missing"] = lambda value: isinstance(value, missing)
    return environment.get_template(name).render(content)
