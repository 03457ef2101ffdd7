"""The check of the kernel finds a violation of each of its rules."""

import pytest

from support.scripts import load_script

GOOD = {
    "gallop.h": "int gallop_step(void);\n",
    "law.h": "double law_value(double t);\n",
    "law.c": '#include "law.h"\ndouble law_value(double t)\n{\n    return t;\n}\n',
    "time.h": "int time_march(void);\n",
    "time_march.c": (
        '#include "gallop.h"\n#include "law.h"\n#include "time.h"\n'
        "int time_march(void)\n{\n    return law_value(1.0) > 0.0;\n}\n"
        '__attribute__((visibility("default"))) int gallop_step(void)\n'
        "{\n    return time_march();\n}\n"
    ),
}
EXPORTED = '__attribute__((visibility("default"))) '

WRONG = {
    "a warning": ({"law.c": GOOD["law.c"] + "static int unused;\n"}, "refuses law.c"),
    "a shadow": (
        {
            "law.c": '#include "law.h"\ndouble law_value(double t)\n{\n    const double s = t;\n'
            "    {\n        double s = t;\n        t += s;\n    }\n    return t + s;\n}\n"
        },
        "refuses law.c",
    ),
    "an internal name without prefix": (
        {"law.c": GOOD["law.c"] + "int value(void);\nint value(void)\n{\n    return 1;\n}\n"},
        "law.c shares value; call it law_value, or make it static",
    ),
    "an exported name without prefix": (
        {"law.c": GOOD["law.c"] + f"{EXPORTED}int law_one = 1;\n"},
        "law.c exports law_one; a prefix of",
    ),
    "an exported path": (
        {
            "law.c": '#include "law.h"\n#define TWO_PATHS\n'
            "TWO_PATHS double law_value(double t)\n{\n    return t;\n}\n"
        },
        "law.c: TWO_PATHS double law_value is compiled for two paths and not static",
    ),
    "an include upwards": (
        {"law.h": '#include "time.h"\n' + GOOD["law.h"]},
        "law.h includes time.h of a higher layer",
    ),
    "a subject without layer": ({"other.h": ""}, "other.h: add its subject, other, to LAYERS"),
    "a circle of includes": (
        {"state.h": '#include "check.h"\n', "check.h": '#pragma once\n#include "state.h"\n'},
        "a circle of includes: ",
    ),
    "a circle of calls": (
        {
            "time_a.c": "int time_a(void);\nint time_b(void);\n"
            "int time_a(void)\n{\n    return time_b();\n}\n",
            "time_b.c": "int time_a(void);\nint time_b(void);\n"
            "int time_b(void)\n{\n    return time_a();\n}\n",
        },
        "a circle of calls: time_",
    ),
}


@pytest.fixture
def script():
    return load_script("tools/check_kernel.py")


def written(folder, files):
    for name, text in files.items():
        (folder / name).write_text(text)
    return folder


def test_files_that_keep_the_rules_pass(script, tmp_path):
    assert script.problems(written(tmp_path, GOOD)) == []


@pytest.mark.parametrize(("files", "message"), WRONG.values(), ids=WRONG)
def test_a_violation_is_found(script, tmp_path, files, message):
    found = script.problems(written(tmp_path, GOOD | files))
    assert found
    assert all(message in line for line in found), found
