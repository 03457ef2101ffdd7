"""A saved session as bytes: magic, sizes, plain data as JSON, motion, checksum; equal sessions give equal bytes."""

from __future__ import annotations

import hashlib
import json
import struct
from typing import Any

MAGIC = b"gallopS1"
HEADER = struct.Struct("<8sQQ")
"""Magic, bytes of JSON, bytes of motion."""
CHECKSUM_SIZE = hashlib.sha256().digest_size


def to_bytes(saved: dict[str, Any], version: str) -> bytes:
    """Bytes of what `Session.save` gave; `version` is that of the package."""
    plain = {name: value for name, value in saved.items() if name != "motion"} | {
        "version": version
    }
    text = json.dumps(plain, sort_keys=True, allow_nan=False).encode()
    motion: bytes = saved["motion"]
    body = HEADER.pack(MAGIC, len(text), len(motion)) + text + motion
    return body + hashlib.sha256(body).digest()


def from_bytes(data: bytes, version: str) -> dict[str, Any]:
    """What `Session.restore` takes.

    Raises
    ------
    ValueError
        Foreign or damaged bytes, or those of another version.
    """
    if len(data) < HEADER.size + CHECKSUM_SIZE or data[: len(MAGIC)] != MAGIC:
        raise ValueError(f"{len(data)} bytes that are not a state of a gallop-fmu FMU")
    _, text_size, motion_size = HEADER.unpack_from(data)
    expected = HEADER.size + text_size + motion_size + CHECKSUM_SIZE
    if len(data) != expected:
        raise ValueError(
            f"the state has {len(data)} bytes, {expected} are needed: it is cut short or damaged"
        )
    body, checksum = data[:-CHECKSUM_SIZE], data[-CHECKSUM_SIZE:]
    if hashlib.sha256(body).digest() != checksum:
        raise ValueError("the state is damaged: its checksum does not match")
    plain: dict[str, Any] = json.loads(body[HEADER.size : HEADER.size + text_size])
    if plain.pop("version") != version:
        raise ValueError(f"the state is of another version of gallop-fmu; this is {version}")
    return plain | {"motion": body[HEADER.size + text_size :]}
