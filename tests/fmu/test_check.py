"""Checking files that are FMUs, and files that are not."""

import os
import stat
import zipfile

import pytest

from gallop_fmu.fmu import check_fmu, export_fmu
from gallop_fmu.fmu.check import MAX_OUTPUT, _run_in_process
from gallop_fmu.fmu.reference import REFERENCE_FILE
from gallop_fmu.fmu.smoke_test import readable_by_pythonfmu

BOMB = (
    '<?xml version="1.0"?><!DOCTYPE x [<!ENTITY a "aaaa">]><fmiModelDescription fmiVersion="2.0"/>'
)


def failed(check):
    return {row.name: row.detail for row in check.rows if not row.ok}


def test_an_exported_fmu_passes(gallop_fmu, monkeypatch):
    """Also if the user turns warnings into errors."""
    monkeypatch.setenv("PYTHONWARNINGS", "error")
    check = check_fmu(gallop_fmu)
    assert failed(check) == {}
    assert check.ok
    names = [
        "archive",
        "description",
        "kind",
        "units",
        "platform",
        "run",
        "finite",
        "rollback",
        "serialised state",
        "functions",
        "logging",
        "reference",
    ]
    assert [row.name for row in check.rows] == [*names, "process"]


def test_an_fmu_of_fmi_3_passes(rigid_scene, tmp_path):
    check = check_fmu(export_fmu(rigid_scene, tmp_path / "x.fmu", fmi=3))
    assert failed(check) == {}
    details = {row.name: row.detail for row in check.rows}
    assert details["kind"] == "FMI 3.0 for co-simulation"
    assert details["functions"] == "all of FMI 3.0 for co-simulation"
    assert details["reference"] == "the same digits in 201 rows"


def test_another_reference_result_is_found(rigid_scene, tmp_path):
    good, bad = export_fmu(rigid_scene, tmp_path / "x.fmu"), tmp_path / "y.fmu"
    with zipfile.ZipFile(good) as old, zipfile.ZipFile(bad, "w") as new:
        for name in old.namelist():
            content = old.read(name)
            if name == REFERENCE_FILE:
                *rows, last, _ = content.decode().split("\n")
                cells = last.split(",")
                cells[2] = repr(float(cells[2]) + 1e-3)
                content = "\n".join([*rows, ",".join(cells), ""]).encode()
            new.writestr(name, content)
    assert failed(check_fmu(bad))["reference"].startswith("midspan.x2 differs from documentation/")


def archive_of(path, entries):
    with zipfile.ZipFile(path, "w") as archive:
        for name, text in entries.items():
            archive.writestr(name, text)
    return path


@pytest.mark.parametrize(
    ("entries", "message"),
    [
        ({"readme.txt": "hello"}, "it has no modelDescription.xml"),
        (
            {"modelDescription.xml": "<x/>", "../outside.txt": "x"},
            "is outside the archive's folder",
        ),
        (
            {"modelDescription.xml": "<x/>", "/etc/outside.txt": "x"},
            "is outside the archive's folder",
        ),
        ({"modelDescription.xml": "<x/>", "a\\b.txt": "x"}, "is outside the archive's folder"),
        ({"modelDescription.xml": BOMB}, "contains a DOCTYPE"),
    ],
)
def test_malicious_or_foreign_archives(tmp_path, entries, message):
    check = check_fmu(archive_of(tmp_path / "x.fmu", entries))
    assert not check.ok
    assert message in failed(check)["archive"]
    assert [file.name for file in tmp_path.iterdir()] == ["x.fmu"]


def test_a_link_is_refused(tmp_path):
    path = archive_of(tmp_path / "x.fmu", {"modelDescription.xml": "<x/>"})
    link = zipfile.ZipInfo("resources/link")
    link.create_system, link.external_attr = 3, (stat.S_IFLNK | 0o777) << 16
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(link, "/etc/passwd")
    assert "is outside the archive's folder" in failed(check_fmu(path))["archive"]


def test_an_archive_that_would_fill_the_disk_is_refused(tmp_path, monkeypatch):
    monkeypatch.setattr("gallop_fmu.fmu.archive_safety.MAX_BYTES", 1000)
    path = archive_of(tmp_path / "x.fmu", {"modelDescription.xml": "<x/>", "big": "x" * 2000})
    assert "2004 bytes; at most 10000 and 1000 are unpacked" in failed(check_fmu(path))["archive"]


@pytest.mark.parametrize("content", [b"", b"not a zip archive", os.urandom(5000)])
def test_files_that_are_no_archives(tmp_path, content):
    path = tmp_path / "x.fmu"
    path.write_bytes(content)
    assert "not a ZIP archive" in failed(check_fmu(path))["archive"]


def test_a_missing_file(tmp_path):
    assert "does not exist" in failed(check_fmu(tmp_path / "x.fmu"))["archive"]


def test_a_damaged_fmu(gallop_fmu, tmp_path):
    data = bytearray(gallop_fmu.read_bytes())
    data[1000] ^= 1
    path = tmp_path / "x.fmu"
    path.write_bytes(data)
    assert "is damaged" in failed(check_fmu(path))["archive"]
    path.write_bytes(data[: len(data) // 2])
    assert "not a ZIP archive" in failed(check_fmu(path))["archive"]


def copy_with(path, target, changes):
    with zipfile.ZipFile(path) as old:
        return archive_of(target, {name: changes(name, old.read(name)) for name in old.namelist()})


def test_a_real_without_a_unit_is_found(gallop_fmu, tmp_path):
    def strip(name, data):
        return (
            data.replace(b'<Real unit="m/s" min', b"<Real min") if name.endswith(".xml") else data
        )

    found = failed(check_fmu(copy_with(gallop_fmu, tmp_path / "x.fmu", strip)))
    assert found == {"units": "1 without, such as wind_speed"}


def test_a_binary_that_is_none_is_a_finding_and_no_crash(gallop_fmu, tmp_path):
    path = copy_with(
        gallop_fmu,
        tmp_path / "x.fmu",
        lambda n, d: b"no library" if n.startswith("binaries/") else d,
    )
    found = failed(check_fmu(path))
    assert "process" in found or "run" in found


@pytest.mark.parametrize("runtime", ["python"], indirect=True, scope="session")
def test_a_broken_slave_is_a_finding_with_its_message(gallop_fmu, tmp_path):
    path = copy_with(
        gallop_fmu,
        tmp_path / "x.fmu",
        lambda n, d: b"import nothing_here" if n.endswith(".py") else d,
    )
    assert "nothing_here" in failed(check_fmu(path))["run"]


@pytest.mark.parametrize("runtime", ["python"], indirect=True, scope="session")
def test_an_fmu_that_ends_the_process_is_no_sound_one(gallop_fmu, tmp_path):
    path = copy_with(
        gallop_fmu,
        tmp_path / "x.fmu",
        lambda n, d: b"import os; os._exit(0)" if n.endswith(".py") else d,
    )
    assert "ended the process" in failed(check_fmu(path))["run"]


@pytest.mark.parametrize("runtime", ["python"], indirect=True, scope="session")
def test_output_without_end_is_not_kept(gallop_fmu, tmp_path):
    """25 MB on each stream; output of the FMU is not a finding."""
    flood = (
        b"import os\nfor _ in range(400): os.write(1, b'trial: [1' * 7000) and os.write(2, b'x' *"
        b" 63000)\nos.write(2, b'\\nthe last words\\n')\nimport nothing_here\n"
    )
    path = copy_with(gallop_fmu, tmp_path / "x.fmu", lambda n, d: flood if n.endswith(".py") else d)
    code, said = _run_in_process(path, str(tmp_path))
    assert code == 0
    assert len(said) <= MAX_OUTPUT
    assert "the last words" in said
    (finding,) = (tmp_path / "findings").read_text().splitlines()
    assert "nothing_here" in finding


def test_another_platform_only(gallop_fmu, tmp_path):
    def rename(name):
        return (
            name.replace("linux64", "plan9").replace("win64", "plan9").replace("darwin64", "plan9")
        )

    with zipfile.ZipFile(gallop_fmu) as old:
        path = archive_of(
            tmp_path / "x.fmu", {rename(name): old.read(name) for name in old.namelist()}
        )
    assert "no binary for" in failed(check_fmu(path))["platform"]


@pytest.mark.parametrize(
    ("folder", "readable"),
    [
        ("/tmp/x", True),
        ("/tmp/with space", True),
        ("/tmp/gal\u00f6pp", False),
        ("/tmp/50%", False),
        ("/tmp/a#b", False),
    ],
)
def test_folders_that_pythonfmu_can_read(folder, readable):
    assert readable_by_pythonfmu(folder) is readable
