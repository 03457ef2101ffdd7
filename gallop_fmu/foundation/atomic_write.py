"""Atomic writing: one rule for every file that the package writes.

A file is written under a random name in the same folder, then renamed: readers always find the old
file or the new one. Links are followed, mode and owner of an older file are kept, and only regular,
writable files are replaced. `check_target` applies the same rule before a long computation.
"""

from __future__ import annotations

import errno
import os
import secrets
import stat
import sys
from collections.abc import Sequence
from contextlib import suppress
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, BinaryIO

from gallop_fmu.foundation.errors import SceneError

if TYPE_CHECKING:
    import xarray as xr

NEW_FILE = os.O_WRONLY | os.O_CREAT | os.O_EXCL | getattr(os, "O_BINARY", 0)


def write_whole(path: Path, content: bytes) -> None:
    """Replace a file atomically; if it is a link, replace its target.

    Parameters
    ----------
    path
        The file. A new file gets the default mode, an older one keeps its mode and, if possible,
        its owner.
    content
        All bytes of the file.

    Raises
    ------
    OSError
        It cannot be written. The older file is kept, and no temporary file remains.
    """
    try:
        place, older = _place(path)
        with _Temporary(place, 0o666 if older is None else 0o600) as new:
            if older is not None:
                _keep_mode(new.descriptor, new.path, older)
            new.write(content)
            os.replace(new.path, place)
    except OSError as problem:
        raise OSError(problem.errno, problem.strerror, str(path)) from None


def check_target(path: Path, suffixes: Sequence[str] = ()) -> None:
    """Refuse a file that cannot be written, before a long computation.

    Parameters
    ----------
    path
        File to be written by `write_whole`.
    suffixes
        Allowed suffixes; any if empty.

    Raises
    ------
    SceneError
        The suffix is another one, the folder is missing or read-only, the name is too long, or a
        folder, device, pipe or read-only file has this name.
    """
    if suffixes and path.suffix.lower() not in suffixes:
        raise SceneError(
            f"{path}: must end in {' or '.join(suffixes)}, as the suffix decides the format;"
            " change the name of the file"
        )
    try:
        if path.is_dir():
            raise SceneError(f"{path}: is a folder; give the name of a file")
        if not path.parent.is_dir():
            raise SceneError(f"{path}: there is no folder {path.parent}; create it first")
        place, _ = _place(path)
        with _Temporary(place, 0o600):
            pass
    except OSError as problem:
        raise SceneError(f"{path}: cannot be written ({problem.strerror or problem})") from None
    except ValueError as problem:  # a name with NUL in it
        if isinstance(problem, SceneError):
            raise
        raise SceneError(f"{str(path)!r}: cannot be written ({problem})") from None


def open_exclusive(path: Path) -> BinaryIO:
    """Open a file to read and append, with a lock against other calls of this function.

    Closing the file or ending the program releases the lock. On network file systems without locks
    the file is not locked.

    Parameters
    ----------
    path
        The file, created if it does not exist. A link is not followed.

    Returns
    -------
    BinaryIO
        The file, without a buffer.

    Raises
    ------
    BlockingIOError
        Another program has locked it.
    OSError
        It is not a regular file, or cannot be opened.
    """
    flags = os.O_RDWR | os.O_CREAT | os.O_APPEND
    for name in ("O_BINARY", "O_NOFOLLOW", "O_NONBLOCK"):  # a pipe must not block
        flags |= getattr(os, name, 0)
    while True:
        file = os.fdopen(os.open(path, flags, 0o666), "a+b", buffering=0)
        try:
            found = os.fstat(file.fileno())
            _check_regular(found)
            _lock(file.fileno())
            if _is_same(path, found):  # otherwise it was removed before it was locked
                return file
        except BaseException:
            file.close()
            raise
        file.close()


def netcdf_bytes(dataset: xr.Dataset) -> bytes:
    """Return a dataset as a NetCDF file in memory: HDF5 crashes on a full disk."""
    buffer = BytesIO()
    dataset.to_netcdf(buffer, engine="h5netcdf")
    return buffer.getvalue()


class _Temporary:
    """A temporary file in the folder of another, removed at the end unless it was renamed."""

    def __init__(self, place: Path, mode: int) -> None:
        self.path = place.with_name(f".gallop-{secrets.token_hex(8)}.new")
        self.descriptor = os.open(self.path, NEW_FILE, mode)

    def write(self, content: bytes) -> None:
        """Write the content to the disk and close the file."""
        with os.fdopen(self.descriptor, "wb") as file:
            self.descriptor = -1
            file.write(content)
            file.flush()
            os.fsync(file.fileno())

    def __enter__(self) -> _Temporary:
        return self

    def __exit__(self, *_: object) -> None:
        if self.descriptor >= 0:
            os.close(self.descriptor)
        with suppress(OSError):
            self.path.unlink(missing_ok=True)


def _place(path: Path) -> tuple[Path, os.stat_result | None]:
    """Return the path after following links, and the state of an older file."""
    place = Path(os.path.realpath(path))
    try:
        older = place.stat()
    except FileNotFoundError:
        return place, None
    _check_regular(older)
    if not stat.S_IMODE(older.st_mode) & 0o222 or not os.access(place, os.W_OK):
        raise PermissionError(
            errno.EACCES, "the file is read-only; choose another name, or allow writing"
        )
    return place, older


def _check_regular(found: os.stat_result) -> None:
    if not stat.S_ISREG(found.st_mode):
        raise OSError(
            errno.EINVAL,
            "a folder, a device or a pipe, not a regular file; give the name of a file",
        )


def _is_same(path: Path, found: os.stat_result) -> bool:
    with suppress(FileNotFoundError):
        return os.path.samestat(path.lstat(), found)
    return False


def _keep_mode(descriptor: int, path: Path, older: os.stat_result) -> None:
    """Give the new file the mode of the older one and, if allowed, its owner and group."""
    mode = stat.S_IMODE(older.st_mode)
    if sys.platform == "win32":
        path.chmod(mode)
        return
    try:
        os.fchown(descriptor, older.st_uid, older.st_gid)
    except OSError:
        if os.fstat(descriptor).st_gid != older.st_gid:
            mode &= ~0o070  # the permissions of the old group must not pass to another
    os.fchmod(descriptor, mode)


def _lock(descriptor: int) -> None:
    """Lock a file, or raise BlockingIOError."""
    if sys.platform == "win32":
        import msvcrt

        os.lseek(descriptor, 2**62, os.SEEK_SET)  # beyond the content, which stays readable
        try:
            msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
        except OSError as problem:
            raise BlockingIOError(problem.errno, problem.strerror) from None
    else:
        import fcntl

        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as problem:
            if problem.errno not in (errno.ENOLCK, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS):
                raise
