"""Malicious archives and XML: refused with a message, nothing unpacked, parsed or written."""

import zipfile

import pytest

from gallop_fmu.fmu import check_fmu

PLAIN = b"<x/>"
LAUGHS = b'<?xml version="1.0"?><!DOCTYPE a [<!ENTITY a "ha"><!ENTITY b "&a;&a;">]><a>&b;</a>'
OUTSIDE = b'<!DOCTYPE a [<!ENTITY a SYSTEM "file:///etc/passwd">]><a>&a;</a>'
ELSEWHERE = b'<!DOCTYPE a SYSTEM "http://localhost:1/a.dtd"><a/>'
DECLARATION = b'<?xml version="1.0" encoding="%s"?>'


def written(path, entries, method=zipfile.ZIP_DEFLATED):
    with zipfile.ZipFile(path, "w", method) as archive:
        for name, content in entries:
            archive.writestr(name, content)
    return path


def refusal(path):
    """The one finding of a check that stops at the archive."""
    ((name, ok, detail),) = check_fmu(path).rows
    assert (name, ok) == ("archive", False)
    assert [file.name for file in path.parent.iterdir()] == [path.name]
    return detail


@pytest.mark.parametrize(
    "name",
    ["../x", "a/../../x", "/x", "C:x", "a\\x", "..\\x", "a/..", "//server/x"],
    ids=lambda name: name,
)
def test_names_outside_the_folder(tmp_path, name):
    path = written(tmp_path / "x.fmu", [("modelDescription.xml", PLAIN), (name, b"harm")])
    assert "is outside the archive's folder" in refusal(path)


@pytest.mark.parametrize("text", [LAUGHS, OUTSIDE, ELSEWHERE])
@pytest.mark.parametrize(
    "place", ["modelDescription.xml", "sources/buildDescription.xml", "icon/Terminals.XML"]
)
def test_entities_in_any_xml_file(tmp_path, text, place):
    path = written(tmp_path / "x.fmu", list({"modelDescription.xml": PLAIN, place: text}.items()))
    assert refusal(path) == f"{place} contains a DOCTYPE, which may be malicious; remove it"


@pytest.mark.parametrize(
    "text",
    [
        LAUGHS.decode().encode("utf-16"),
        LAUGHS.decode().encode("utf-32"),
        DECLARATION % b"UTF-7"
        + LAUGHS[21:].decode().encode("utf-7").replace(b"<", b"+ADw-").replace(b"!", b"+ACE-"),
        (DECLARATION % b"cp037" + LAUGHS[21:]).decode().encode("cp037"),
        DECLARATION % b"latin-1" + b"<x/>",
    ],
    ids=["utf-16", "utf-32", "utf-7", "ebcdic", "latin-1"],
)
def test_entities_hidden_in_another_encoding(tmp_path, text):
    assert "is not UTF-8 text" in refusal(
        written(tmp_path / "x.fmu", [("modelDescription.xml", text)])
    )


def test_a_zip_bomb_by_its_ratio(tmp_path):
    path = written(
        tmp_path / "x.fmu", [("modelDescription.xml", PLAIN), ("bomb", bytes(11_000_000))]
    )
    assert "at most 100 times the archive's size is unpacked" in refusal(path)


def test_a_zip_bomb_by_its_number_of_files(tmp_path):
    entries = [("modelDescription.xml", PLAIN), *((f"{k}", b"") for k in range(10_000))]
    assert "10001 files" in refusal(written(tmp_path / "x.fmu", entries))


def test_a_false_size(tmp_path):
    """The table of contents states less than the archive contains."""
    path = written(
        tmp_path / "x.fmu", [("modelDescription.xml", PLAIN), ("bomb", bytes(1_000_000))]
    )
    data = bytearray(path.read_bytes())
    size = (1_000_000).to_bytes(4, "little")
    while size in data:
        at = data.index(size)
        data[at : at + 4] = (10).to_bytes(4, "little")
    path.write_bytes(data)
    assert "'bomb'" in refusal(path)


@pytest.mark.parametrize("method", [zipfile.ZIP_BZIP2, zipfile.ZIP_LZMA])
def test_compressions_outside_fmi(tmp_path, method):
    path = written(tmp_path / "x.fmu", [("modelDescription.xml", PLAIN), ("a", b"a" * 100)], method)
    assert "has a compression that FMI does not allow" in refusal(path)


def test_two_entries_of_one_name(tmp_path):
    """Tools differ in the one they take: one could be shown and the other used."""
    entries = [
        ("modelDescription.xml", PLAIN),
        ("Binaries/a.so", b"good"),
        ("binaries/a.so", b"harm"),
    ]
    assert "'binaries/a.so' is there 2 times" in refusal(written(tmp_path / "x.fmu", entries))


def test_a_description_without_end(tmp_path, monkeypatch):
    monkeypatch.setattr("gallop_fmu.fmu.archive_safety.MAX_XML_BYTES", 1000)
    path = written(tmp_path / "x.fmu", [("modelDescription.xml", b"<x/>" + b" " * 1000)])
    assert "modelDescription.xml is larger than 1000 bytes" in refusal(path)


@pytest.mark.parametrize(
    "text",
    [
        b"",
        b"no xml",
        b"<x/>",
        b"<a>" * 100_000,
        b'<fmiModelDescription fmiVersion="2.0"/>',
        (
            b'<fmiModelDescription fmiVersion="2.0" xmlns:xi="http://www.w3.org/2001/XInclude">'
            b'<xi:include href="/etc/passwd"/></fmiModelDescription>'
        ),
    ],
)
def test_invalid_descriptions_are_findings_not_exceptions(tmp_path, text):
    check = check_fmu(written(tmp_path / "x.fmu", [("modelDescription.xml", text)]))
    assert [row.name for row in check.rows if not row.ok] == ["description", "kind"]
    assert "root:" not in "".join(row.detail for row in check.rows)
