"""Safety checks of an FMU's archive, before it is unpacked or its XML is parsed."""

from __future__ import annotations

import re
import stat
import zipfile
from collections import Counter
from pathlib import Path, PurePosixPath

MAX_BYTES = 500_000_000
"""Bytes of all files of an archive, unpacked."""
MAX_FILES = 10_000
MAX_EXPANSION = 100
"""Unpacked bytes for each packed one, above `SMALL_BYTES`; code and tables have up to 20."""
SMALL_BYTES = 10_000_000
MAX_XML_BYTES = 20_000_000
"""Bytes of modelDescription.xml, or another XML file."""
METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"""Compressions that FMI allows; others can ask for gigabytes to unpack a few bytes."""


def archive_problem(path: Path) -> str:
    """Return the reason why the archive must not be unpacked, or an empty text."""
    if not path.exists():
        return f"{path} does not exist"
    if not path.is_file():
        return f"{path} is not a file"
    try:
        with zipfile.ZipFile(path) as archive:
            return _entries_problem(archive.infolist(), path.stat().st_size) or _content_problem(
                archive
            )
    except Exception as problem:  # of zipfile, of zlib, and others for damaged bytes
        return f"not a ZIP archive that can be read ({problem})"


def _entries_problem(entries: list[zipfile.ZipInfo], packed: int) -> str:
    """Check the table of contents."""
    return (
        _size_problem(entries, packed)
        or next(filter(None, map(_entry_problem, entries)), "")
        or _names_problem(entries)
    )


def _size_problem(entries: list[zipfile.ZipInfo], packed: int) -> str:
    size = sum(entry.file_size for entry in entries)
    if len(entries) > MAX_FILES or size > MAX_BYTES:
        return (
            f"{len(entries)} files, {size} bytes; at most {MAX_FILES} and {MAX_BYTES} are unpacked"
        )
    if size > SMALL_BYTES and size > MAX_EXPANSION * packed:
        return (
            f"{size} bytes packed into {packed}; at most {MAX_EXPANSION} times the archive's size"
            " is unpacked"
        )
    return ""


def _entry_problem(entry: zipfile.ZipInfo) -> str:
    if _escapes(entry):
        return (
            f"the entry {entry.orig_filename!r} is outside the archive's folder, or is not a plain"
            " file"
        )
    if entry.compress_type not in METHODS:
        return (
            f"the entry {entry.filename!r} has a compression that FMI does not allow; store or"
            " deflate it"
        )
    if entry.filename.lower().endswith(".xml") and entry.file_size > MAX_XML_BYTES:
        return f"{entry.filename} is larger than {MAX_XML_BYTES} bytes"
    return ""


def _names_problem(entries: list[zipfile.ZipInfo]) -> str:
    names = Counter(entry.filename.lower() for entry in entries)
    for name, times in names.most_common(1):
        if times > 1:  # tools differ in which one they use
            return f"the entry {name!r} is there {times} times"
    if "modelDescription.xml" not in {entry.filename for entry in entries}:
        return "not an FMU: it has no modelDescription.xml"
    return ""


def _content_problem(archive: zipfile.ZipFile) -> str:
    """Unpack in memory, and check the text of XML files."""
    damaged = archive.testzip()
    if damaged is not None:
        return f"the entry {damaged!r} is damaged"
    for name in archive.namelist():
        if name.lower().endswith(".xml"):
            problem = _xml_problem(archive.read(name))
            if problem:
                return f"{name} {problem}"
    return ""


def _escapes(entry: zipfile.ZipInfo) -> bool:
    name = entry.orig_filename
    kind = stat.S_IFMT(entry.external_attr >> 16)
    plain = kind in (0, stat.S_IFREG, stat.S_IFDIR)
    return not plain or ".." in PurePosixPath(name).parts or bool(re.search(r"^/|[\\:\0]", name))


def _xml_problem(text: bytes) -> str:
    """Refuse a DOCTYPE, which entities need; only another encoding than UTF-8 could hide it."""
    declared = re.match(rb"(?:\xef\xbb\xbf)?\s*<\?xml[^>]*encoding\s*=\s*[\"']([^\"']*)", text)
    try:
        text.decode("utf-8")
    except UnicodeDecodeError:
        return "is not UTF-8 text"
    if b"\0" in text or (declared and declared[1].lower() not in (b"utf-8", b"us-ascii")):
        return "is not UTF-8 text, which FMI demands"
    return "contains a DOCTYPE, which may be malicious; remove it" if b"<!DOCTYPE" in text else ""
