"""The check of complexity finds what is above a limit, and exceptions that are not needed."""

import pytest

from support.scripts import load_script

BRANCHES = "".join(f"    if x == {i}:\n        return {i}\n" for i in range(15))


@pytest.fixture
def script():
    return load_script("tools/check_complexity.py")


def test_functions_above_a_limit_need_a_reason(script, tmp_path):
    (tmp_path / "some").mkdir()
    (tmp_path / "some" / "a.py").write_text(
        f"def branchy(x):\n{BRANCHES}\n\ndef wide(a, b, c, d, e, f, g, h, i):\n    return a\n"
        "\n\ndef plain(x):\n    return x\n"
    )
    (tmp_path / "some" / "b.c").write_text(
        "int deep(int x)\n{\n" + "    if (x) x++;\n" * 15 + "    return x;\n}\n"
    )
    found = script.problems(tmp_path, ("some",), {"some/b.c:deep": "a reason"})
    assert found == [
        "some/a.py:branchy: complexity 16, 1 parameters; split it, or give a reason in EXCEPTIONS",
        "some/a.py:wide: complexity 1, 9 parameters; split it, or give a reason in EXCEPTIONS",
    ]


def test_reasons_that_are_not_needed_must_go(script, tmp_path):
    (tmp_path / "some").mkdir()
    found = script.problems(tmp_path, ("some",), {"some/a.py:gone": "a reason"})
    assert found == ["some/a.py:gone is below the limits now; remove it from EXCEPTIONS"]
