"""The public names of both packages: one list, `__init__.pyi`, for loading and type checkers."""

import importlib
from pathlib import Path

import pytest


@pytest.mark.parametrize("name", ["gallop_fmu", "modal"])
def test_public_names_resolve_to_their_objects(name):
    package = importlib.import_module(name)
    assert sorted(package.__all__) == sorted(dir(package))
    assert all(getattr(package, public).__name__ == public for public in package.__all__)
    with pytest.raises(AttributeError, match=f"{name} attribute gallop"):
        package.gallop  # noqa: B018


@pytest.mark.parametrize("name", ["gallop_fmu", "modal"])
def test_no_folder_hides_a_public_name(name):
    """Python sets `package.sweep` to a module of that name as soon as it is imported."""
    package = importlib.import_module(name)
    assert not {path.stem for path in Path(package.__file__).parent.iterdir()} & set(
        package.__all__
    )
