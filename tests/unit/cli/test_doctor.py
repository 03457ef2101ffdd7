"""`gallop-fmu doctor`: faults are found, each with its remedy."""

import json
import subprocess
import sys
from importlib.metadata import PackageNotFoundError
from types import SimpleNamespace

import pytest

from gallop_fmu.cli import doctor


def test_this_installation_has_no_fault():
    checks = doctor.check_installation()
    assert [check for check in checks if check.state == "fault"] == []
    names = [check.name for check in checks]
    assert {"numpy", "scipy", "fmpy", "pythonfmu", "control", "kernel", "FMU"} <= set(names)
    assert "pytest" not in names  # extras for developers are not listed


@pytest.mark.parametrize(
    ("package", "state", "remedy"),
    [
        ("scipy", "fault", 'pip install "scipy>=1.13"'),
        ("pyarrow", "missing", 'pip install "gallop-fmu[parquet]"'),
    ],
)
def test_a_missing_package_is_named_with_its_remedy(monkeypatch, package, state, remedy):
    real = doctor.version

    def without(name):
        if name == package:
            raise PackageNotFoundError(name)
        return real(name)

    monkeypatch.setattr(doctor, "version", without)
    check = next(check for check in doctor._packages() if check.name == package)
    assert check.state == state
    assert remedy in check.found


def test_an_old_package_is_named_with_its_remedy():
    check = doctor._package("scipy", ">=1.13", "1.9.0", None)
    assert check.state == "fault"
    assert check.found == '1.9.0, but >=1.13 is needed (required): pip install "scipy>=1.13"'


def test_another_package_named_modal_is_found(monkeypatch, tmp_path):
    other = SimpleNamespace(submodule_search_locations=[str(tmp_path / "modal")])
    monkeypatch.setattr(doctor, "find_spec", lambda name: other)
    check = doctor._modal()
    assert check.state == "fault"
    assert str(tmp_path / "modal") in check.found


def test_command_prints_json():
    code = "from gallop_fmu.cli.main import main; main()"
    done = subprocess.run(
        [sys.executable, "-c", code, "doctor", "--json"], capture_output=True, text=True, check=True
    )
    assert {entry["state"] for entry in json.loads(done.stdout)} <= {"ok", "missing"}
