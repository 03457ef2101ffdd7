"""Other masters give the digits of simulate(), and checkers find nothing, where they are installed.

`pip install ".[hosts]"` installs them; CI runs benchmarks/hosts/masters.py, which needs all.
"""

import pytest

from gallop_fmu.fmu import export_fmu
from support.scripts import load_script

masters = load_script("benchmarks/hosts/masters.py")
SCENE, STEPS = "example3", 50


@pytest.fixture(scope="module")
def wanted():
    return masters.simulated(SCENE, STEPS)


@pytest.mark.parametrize(
    ("name", "version"),
    [
        (name, version)
        for name, (package, versions, _) in masters.MASTERS.items()
        for version in versions
        if package != "fmpy"  # the other tests are in FMPy
    ],
)
def test_a_master_gives_the_same_digits(wanted, tmp_path, name, version):
    package, _, run = masters.MASTERS[name]
    pytest.importorskip(package)
    assert run(export_fmu(SCENE, tmp_path / f"span{version}.fmu", fmi=version), STEPS) == wanted


@pytest.mark.parametrize("options", [{"fmi": 2}, {"fmi": 3}, {"runtime": "python"}])
def test_fmutool_finds_nothing(tmp_path, options):
    pytest.importorskip("fmu_manipulation_toolbox")
    fmu = export_fmu(SCENE, tmp_path / "span.fmu", **options)
    assert masters.check_by_fmutool(fmu) == ""
