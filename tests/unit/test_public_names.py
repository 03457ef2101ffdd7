"""What the packages offer is listed for people, for type checkers and for loading; the three lists must agree."""

import ast
import importlib
from pathlib import Path

import pytest


def for_type_checkers(package):
    """Module within the package to the names that a type checker sees of it."""
    tree = ast.parse(Path(package.__file__).read_text(encoding="utf-8"))
    (guarded,) = (node for node in tree.body if isinstance(node, ast.If))
    start = package.__name__ + "."
    return {
        node.module.removeprefix(start): tuple(name.name for name in node.names)
        for node in guarded.body
        if isinstance(node, ast.ImportFrom)
    }


@pytest.mark.parametrize("name", ["gallop_fmu", "modal"])
def test_public_names_are_the_same_for_all(name):
    package = importlib.import_module(name)
    homes = package._HOMES
    assert for_type_checkers(package) == homes
    assert sorted(sum(homes.values(), ())) == sorted(package.__all__) == sorted(dir(package))
    assert all(getattr(package, public).__name__ == public for public in package.__all__)
    with pytest.raises(AttributeError, match=f"module '{name}' has no attribute 'gallop'"):
        package.gallop  # noqa: B018


@pytest.mark.parametrize("name", ["gallop_fmu", "modal"])
def test_no_folder_hides_a_public_name(name):
    """Python sets `package.sweep` to a module of that name as soon as it is imported."""
    package = importlib.import_module(name)
    assert not {path.stem for path in Path(package.__file__).parent.iterdir()} & set(
        package.__all__
    )
