"""The plain installation is enough for the README; what is not in it is named when it is needed."""

import json
import subprocess
import sys
from importlib.metadata import distribution, packages_distributions

from packaging.requirements import Requirement

PROGRAM = "gallop-fmu"

CODE = """
import json, sys
from importlib.machinery import PathFinder

EXTRAS = set(json.loads(sys.argv[1]))

class Plain(PathFinder):
    @classmethod
    def find_spec(cls, name, path=None, target=None):
        if name.partition(".")[0] in EXTRAS:
            return None
        return super().find_spec(name, path, target)

sys.meta_path = [Plain if finder is PathFinder else finder for finder in sys.meta_path]

import gallop_fmu as gf
import modal

result = gf.simulate("example3", stop_time=2.0)
result.save("run.nc")
result.plot()
result.to_dataframe()
gf.sweep("example3", {"wind.speed": [4.0, 5.0]}, stop_time=1.0, out="winds.nc")
gf.export_fmu("example3", "example3.fmu")
gf.export_fmu("example3", "slave.fmu", runtime="python")
modal.screen("example3", 5.6).plot()
modal.screen_spans("example3", {"wind.speed": [4.0, 5.0]}, estimate_only=True, workers=1)
modal.linear_model("example3")
modal.natural_modes("example3")
for call in (
    lambda: gf.sweep("example3", {"wind.speed": [4.0]}, out="winds.parquet"),
    lambda: result.save("run.parquet"),
    lambda: gf.sweep("example3", {"wind.speed": [4.0]}, cluster="tcp://localhost:8786"),
    lambda: gf.export_fmu("example3", "all.fmu", platforms=["linux64", "win64"]),
):
    try:
        call()
    except Exception as problem:
        print(problem)
    else:
        print("no error")
"""


def plain_requirements(name, extras=(), found=None):
    """Names of a distribution and of all that it requires."""
    found = set() if found is None else found
    key = name.lower().replace("_", "-")
    if (key, *extras) in found:
        return found
    found.add((key, *extras))
    for text in distribution(name).requires or ():
        need = Requirement(text)
        wanted = [{"extra": extra} for extra in extras] or [{"extra": ""}]
        if need.marker is None or any(need.marker.evaluate(each) for each in wanted):
            plain_requirements(need.name, tuple(need.extras), found)
    return found


def test_the_readme_works_with_the_plain_installation(tmp_path):
    """All packages that a plain installation does not bring are made unimportable."""
    plain = {key for key, *_ in plain_requirements(PROGRAM)}
    blocked = [
        module
        for module, names in packages_distributions().items()
        if not {name.lower().replace("_", "-") for name in names} & plain
    ]
    assert {"pyarrow", "distributed", "pytest"} <= set(blocked)
    assert not {"numpy", "xarray", "fmpy", "control", "gallop_fmu"} & set(blocked)
    done = subprocess.run(
        [sys.executable, "-c", CODE, json.dumps(blocked)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    messages = done.stdout.splitlines()
    assert len(messages) == 4
    for message, extra in zip(messages, ("parquet", "parquet", "cluster", "cross"), strict=True):
        assert f'pip install "gallop-fmu[{extra}]"' in message
