"""The reference result in an FMU, and the page that shows it."""

import csv
import io
import re
import zipfile

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu

import gallop_fmu as gf
from gallop_fmu.fmu import export_fmu
from gallop_fmu.fmu.reference import REFERENCE_FILE
from support.line_scenes import section

LINE = section(20000.0, [200.0, 250.0], 15.7, 3e7, elements=4)


def read(path, name):
    with zipfile.ZipFile(path) as archive:
        return archive.read(name).decode()


def rows_of(path):
    names, *rows = csv.reader(io.StringIO(read(path, REFERENCE_FILE)))
    return names, np.array(rows, dtype=float)


@pytest.mark.parametrize("fmi", [2, 3])
def test_the_reference_is_the_run_of_a_host_bit_for_bit(tmp_path, fmi):
    scene = gf.load_scene("example3").with_values(
        {"numerics.elements": 6, "initial.seed_vertical": 0.1}
    )
    path = export_fmu(scene, tmp_path / "x.fmu", fmi=fmi)
    names, rows = rows_of(path)
    assert (len(rows), rows[-1, 0]) == (201, pytest.approx(20.0))
    found = simulate_fmu(str(path), stop_time=5.0, output_interval=0.1, output=names[1:])
    outputs = read_model_description(str(path)).modelVariables
    assert set(names[1:]) == {
        v.name for v in outputs if v.causality == "output" and v.type in ("Real", "Float64")
    }
    assert np.ptp(rows[:, names.index("midspan.x2")]) > 0.1
    for at, name in enumerate(names[1:], start=1):
        assert list(found[name]) == list(rows[: len(found), at]), name


def test_a_run_that_fails_leaves_a_note(tmp_path):
    scene = gf.load_scene("example2").with_values(
        {"numerics.elements": 4, "initial.seed_vertical": 8.0}
    )
    page = read(export_fmu(scene, tmp_path / "x.fmu"), "documentation/index.html")
    assert "The run ended early: the step could not be carried out" in page


@pytest.mark.parametrize("runtime", ["native", "python"])
def test_the_page_has_ports_example_plot_and_limits(tmp_path, runtime):
    path = export_fmu(LINE, tmp_path / "x.fmu", runtime=runtime)
    page = read(path, "documentation/index.html")
    assert re.findall(r"<h2>([\w ]+)</h2>", page) == [
        *("Ports", "Example", "Reference result", "Limits"),
        *("Inputs", "Outputs", "Parameters", "Values of Status", "Values of Integrator"),
    ]
    for tower in range(3):
        assert re.search(
            rf"<code>tower\[{tower}\]</code><td>x1, x2, x3, v1, v2, v3<td>f1, f2, f3", page
        )
    assert page.count("<polyline") == 2
    assert "1.9% of the amplitude" in page  # 2 sin(pi 0.3 0.01)
    code = re.search(r"<pre>(.*?)</pre>", page, re.DOTALL).group(1).replace("&quot;", '"')
    code = code.replace("name_of_this_file.fmu", str(path)).replace("60.0", "0.1")
    if runtime == "native":
        exec(compile(code, "example", "exec"), {})
