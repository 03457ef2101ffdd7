"""Writing the file."""

import subprocess
import sys
import zipfile

import pytest
from fmpy import read_model_description

from gallop_fmu.engine.library import library_path
from gallop_fmu.fmu import ExportError, export_fmu
from gallop_fmu.fmu.export import platform
from gallop_fmu.foundation.outcome import SimulationError
from gallop_fmu.input.scene_files import load_scene
from gallop_fmu.scene.scene import Scene


def test_exporting_twice_gives_the_same_bytes(gallop_scene, gallop_fmu, runtime, tmp_path):
    again = export_fmu(
        Scene.from_dict(gallop_scene.model_dump(mode="json")),
        tmp_path / "other name.fmu",
        runtime=runtime,
    )
    assert again.read_bytes() == gallop_fmu.read_bytes()


def test_another_process_gives_the_same_bytes(tmp_path):
    script = (
        "import sys; from gallop_fmu.fmu import export_fmu; from gallop_fmu.input.scene_files"
        " import load_scene;"
    )
    script += "export_fmu(load_scene('example3'), sys.argv[1])"
    files = [tmp_path / "0.fmu", tmp_path / "1.fmu"]
    for seed, file in enumerate(files):
        environment = {"PYTHONHASHSEED": str(seed), "TZ": f"UTC+{5 * seed}"}
        subprocess.run(
            [sys.executable, "-c", script, str(file)], env=environment, cwd=tmp_path, check=True
        )
    assert files[0].read_bytes() == files[1].read_bytes()


def test_another_scene_gives_another_identity(gallop_fmu, rigid_fmu):
    guids = {read_model_description(str(path)).guid for path in (gallop_fmu, rigid_fmu)}
    assert len(guids) == 2


def test_content_for_pythonfmu(gallop_scene, tmp_path):
    with zipfile.ZipFile(export_fmu(gallop_scene, tmp_path / "x.fmu", runtime="python")) as archive:
        names = archive.namelist()
        name = archive.read("resources/slavemodule.txt").decode()
        assert names == sorted(names)
        assert f"binaries/linux64/{name}.so" in names
        assert f"binaries/win64/{name}.dll" in names
        assert f"resources/{name}.py" in names
        assert {
            "documentation/licenses/license.txt",
            "documentation/licenses/pythonfmu.txt",
        } <= set(names)
        assert archive.read("resources/scene.toml").decode() == gallop_scene.to_toml()
        assert archive.read("resources/requirements.txt").decode().startswith("gallop-fmu==")


def test_content_of_a_native_fmu(gallop_scene, tmp_path):
    path = export_fmu(gallop_scene, tmp_path / "x.fmu")
    name = read_model_description(str(path)).coSimulation.modelIdentifier
    with zipfile.ZipFile(path) as archive:
        names = archive.namelist()
        assert names == sorted(names)
        assert (
            archive.read(f"binaries/{platform()}/{name}{library_path().suffix}")
            == library_path().read_bytes()
        )
        assert {"resources/model.bin", "documentation/licenses/license.txt"} <= set(names)
        assert archive.read("resources/scene.toml").decode() == gallop_scene.to_toml()


def test_replaces_a_file_and_leaves_nothing_else(gallop_scene, tmp_path):
    (tmp_path / "x.fmu").write_text("old")
    export_fmu(gallop_scene, str(tmp_path / "x.fmu"))
    assert [file.name for file in tmp_path.iterdir()] == ["x.fmu"]
    assert zipfile.is_zipfile(tmp_path / "x.fmu")


@pytest.mark.parametrize(
    ("name", "runtime", "message"),
    [
        ("x.fmu", "fortran", "runtime = 'fortran': must be one of"),
        ("x.zip", "python", "must end in .fmu"),
        ("missing/x.fmu", "python", "there is no folder .*; create it first"),
        ("folder.fmu", "python", "is a folder"),
    ],
)
def test_errors_have_a_remedy(gallop_scene, tmp_path, name, runtime, message):
    (tmp_path / "folder.fmu").mkdir()
    with pytest.raises(ExportError, match=message):
        export_fmu(gallop_scene, tmp_path / name, runtime=runtime)
    assert [file.name for file in tmp_path.iterdir()] == ["folder.fmu"]


def test_a_scene_that_cannot_start_is_not_exported(tmp_path):
    scene = load_scene("example2").with_values({"initial.seed_twist": 2.0})
    with pytest.raises(SimulationError, match="left the validity range"):
        export_fmu(scene, tmp_path / "x.fmu")
    assert list(tmp_path.iterdir()) == []
