"""Whether an FMU's archive can be opened safely: looked at before anything is unpacked or given to an XML parser."""

from __future__ import annotations

import re
import stat
import zipfile
from collections import Counter
from pathlib import Path, PurePosixPath

LARGEST_ARCHIVE = 500_000_000
"""Bytes of all files of an archive, unpacked."""
MOST_FILES = 10_000
MOST_EXPANSION = 100
"""Unpacked bytes for each packed one, in an archive of more than `SMALL_ARCHIVE`; code and tables have up to 20."""
SMALL_ARCHIVE = 10_000_000
LARGEST_XML = 20_000_000
"""Bytes of modelDescription.xml, or another XML file."""
METHODS = (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED)
"""Compressions that FMI allows; others can ask for gigabytes to unpack a few bytes."""


def archive_problem(path: Path) -> str:
    """What forbids to unpack an archive as an FMU; empty if nothing does."""
    if not path.exists():
        return f"{path} does not exist"
    if not path.is_file():
        return f"{path} is not a file"
    try:
        with zipfile.ZipFile(path) as archive:
            return _entries_problem(archive.infolist(), path.stat().st_size) or _content_problem(
                archive
            )
    except Exception as problem:  # zipfile's own, zlib's, and whatever else damaged bytes provoke
        return f"not a ZIP archive that can be read ({problem})"


def _entries_problem(entries: list[zipfile.ZipInfo], packed: int) -> str:
    """What the table of contents tells."""
    size = sum(entry.file_size for entry in entries)
    if len(entries) > MOST_FILES or size > LARGEST_ARCHIVE:
        return (
            f"{len(entries)} files, {size} bytes; at most {MOST_FILES} and {LARGEST_ARCHIVE} are"
            " unpacked"
        )
    if size > SMALL_ARCHIVE and size > MOST_EXPANSION * packed:
        return (
            f"{size} bytes packed into {packed}; at most {MOST_EXPANSION} times the archive's size"
            " is unpacked"
        )
    for entry in entries:
        if _escapes(entry):
            return (
                f"the entry {entry.orig_filename!r} leads out of the archive, or is no plain file"
            )
        if entry.compress_type not in METHODS:
            return (
                f"the entry {entry.filename!r} is compressed otherwise than FMI allows (stored or"
                " deflated)"
            )
        if entry.filename.lower().endswith(".xml") and entry.file_size > LARGEST_XML:
            return f"{entry.filename} is larger than {LARGEST_XML} bytes"
    name, times = (
        Counter(entry.filename.lower() for entry in entries).most_common(1)[0]
        if entries
        else ("", 0)
    )
    if times > 1:  # tools differ in which one they take
        return f"the entry {name!r} is there {times} times"
    if "modelDescription.xml" not in {entry.filename for entry in entries}:
        return "not an FMU: it has no modelDescription.xml"
    return ""


def _content_problem(archive: zipfile.ZipFile) -> str:
    """What unpacking and looking at the text of XML files tells."""
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
    """Entities need a DOCTYPE, which could hide from a search only in another encoding; FMI demands UTF-8."""
    declared = re.match(rb"(?:\xef\xbb\xbf)?\s*<\?xml[^>]*encoding\s*=\s*[\"']([^\"']*)", text)
    try:
        text.decode("utf-8")
    except UnicodeDecodeError:
        return "is not UTF-8 text"
    if b"\0" in text or (declared and declared[1].lower() not in (b"utf-8", b"us-ascii")):
        return "is not UTF-8 text, which FMI demands"
    return "contains a DOCTYPE, which can hide harm" if b"<!DOCTYPE" in text else ""
