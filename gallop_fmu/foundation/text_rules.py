r"""One rule for all texts that a user gives, and one for all numbers written as text.

Texts are kept in Unicode's normal form C, with line breaks as ``\n``. Control characters,
surrogates and non-characters are refused: NetCDF, XML and terminals cannot show them. Numbers are
written as in most programs: ``.5``, ``2.``, ``05``, ``+3`` and ``1e-3``, in ASCII digits with a
decimal point.
"""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping
from decimal import Decimal
from fractions import Fraction
from typing import Any

from gallop_fmu.foundation.errors import SceneError

INT64_LIMIT = 2**63
"""Whole numbers from this size on become floating-point numbers, as files have 64-bit integers."""

_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
_TOML_NUMBER = re.compile(r"[+-]?(?:0|[1-9][0-9]*)(?:\.[0-9]+)?(?:[eE][+-]?[0-9]+)?")
_WHOLE = re.compile(r"[+-]?[0-9]{1,19}")
_DECIMAL_COMMA = re.compile(r"[+-]?[0-9]+,[0-9]+(?:[eE][+-]?[0-9]+)?")
_DATE_OR_TIME = re.compile(r"[0-9]{1,4}[-/.][0-9]{1,2}[-/.][0-9]{1,4}|[0-9]{1,2}:[0-9]{2}")
_ODD_NUMBER = re.compile(r"[+-]?(?:0[xXoObB][0-9a-fA-F]+|[\w.]*_[\w.]*|[0-9.]+[dD][+-]?[0-9]+)")
# Control characters except tab and line feed, surrogates, and non-characters of Unicode.
_REFUSED = re.compile(
    "[\x00-\x08\x0b-\x1f\x7f-\x9f\ud800-\udfff\ufdd0-\ufdef"
    + "".join(chr(plane << 16 | 0xFFFE) + chr(plane << 16 | 0xFFFF) for plane in range(17))
    + "]"
)


def clean_text(text: str) -> str:
    """Return a text in normal form C, with line feeds as line breaks.

    Raises
    ------
    SceneError
        The text holds a control character, a surrogate or a non-character.
    """
    if text.isascii() and text.isprintable():
        return text
    text = text.replace("\r\n", "\n").replace("\r", "\n")
    if found := _REFUSED.search(text):
        raise SceneError(
            f'"{printable(text[:40])}" holds the character U+{ord(found[0]):04X}'
            f" ({_kind(found[0])}), which files and terminals cannot show; remove it"
        )
    return unicodedata.normalize("NFC", text)


def is_printable(text: str) -> bool:
    """Check that a text has no character that `clean_text` refuses."""
    return _REFUSED.search(text) is None


def printable(text: str) -> str:
    """Return a text with escape sequences for the characters that `clean_text` refuses."""
    return _REFUSED.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


def counted(number: int, noun: str) -> str:
    """Return a number with its noun, such as ``"1 loop"`` and ``"2 loops"``."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"


def read_number(text: str) -> int | float | None:
    """Parse a finite number, as an int if it is whole and has at most 64 bits, or return None."""
    text = text.strip()
    if not is_number(text):
        return None
    if _WHOLE.fullmatch(text) and -INT64_LIMIT <= int(text) < INT64_LIMIT:
        return int(text)
    return value if math.isfinite(value := float(text)) else None


def is_number(text: str) -> bool:
    """Check that a text is written as a number, of any size."""
    return _NUMBER.fullmatch(text) is not None


def toml_spelling(number: str) -> str:
    """Return a number in TOML spelling: digits on both sides of the point, no leading zeros."""
    if _TOML_NUMBER.fullmatch(number):
        return number
    mantissa, mark, exponent = number.lower().partition("e")
    sign = mantissa[0] if mantissa[0] in "+-" else ""
    whole, point, decimals = mantissa.removeprefix(sign).partition(".")
    digits = f"{whole.lstrip('0') or '0'}{point}{(decimals or '0') if point else ''}"
    return f"{sign}{digits}{mark}{exponent}"


def number_remedy(text: str) -> str:
    """Return a hint for a text that was meant as a number, or an empty text."""
    if is_number(text.strip()):
        return "it is too large"
    given, text = text.strip(), unicodedata.normalize("NFKC", text.strip())
    if _DECIMAL_COMMA.fullmatch(text):
        return f"write {text.replace(',', '.')}, with a decimal point"
    if _DATE_OR_TIME.match(text):
        return "dates and times are not numbers; convert times to seconds from the start of the run"
    if _ODD_NUMBER.fullmatch(text) or (given != text and _NUMBER.fullmatch(text)):
        return "write the digits 0 to 9 only, such as 100, 0.5 or 1e-3"
    if text.lower() in ("nan", "na", "n/a", "null", "-"):
        return (
            "give a number; an empty cell, which keeps the scene's value, is allowed only in a"
            " table of spans"
        )
    return ""


def plain(value: Any) -> Any:
    """Return a value as plain data of TOML: numbers, texts, lists and tables.

    NumPy values and sections are converted. Other values, such as dates, become texts, which no
    field of numbers accepts.

    Raises
    ------
    SceneError
        A text is refused, or the value is nested too deeply.
    """
    try:
        return _plain(value)
    except RecursionError:
        raise SceneError("the value is nested too deeply for a scene; give a flatter one") from None


def _plain(value: Any) -> Any:
    if hasattr(value, "model_dump"):
        value = value.model_dump(mode="json", exclude_none=True)
    elif hasattr(value, "tolist"):
        value = value.tolist()
    if value is None or isinstance(value, (bool, float)):
        return value
    if isinstance(value, str):
        return clean_text(value)
    if isinstance(value, int) and -INT64_LIMIT <= value < INT64_LIMIT:
        return value
    if isinstance(value, Mapping):
        return {clean_text(str(key)): _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, (int, Fraction, Decimal)):
        try:
            return float(value)
        except OverflowError:
            return math.inf if value > 0 else -math.inf
    return clean_text(str(value))


def _kind(character: str) -> str:
    names = {"Cc": "a control character", "Cs": "a lone surrogate"}
    return names.get(unicodedata.category(character), "not a character")
