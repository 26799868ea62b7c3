"""Reading and writing `key=value&key=value`, strictly.

A port of the crate `endpoint`'s `query`: every key has to be there exactly
once and no other may be, and numbers are decimal and finite. What the messages
are is in `message`.
"""

from __future__ import annotations

import re
from math import isfinite
from typing import List, Tuple
from urllib.parse import unquote_plus

MAX_BYTES = 1024
"""The longest query that is read. The longest valid answer has about 190 bytes."""

MAX_COUNT = 2**64 - 1
"""The largest count: the other ends hold them in 64 bits."""

EXCERPT_CHARS = 40
"""How much of a refused text an error repeats."""

# float() alone would take `1_000`, ` 1` and digits of any script.
_NUMBER = re.compile(r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")


class InvalidMessage(ValueError):
    """Why a message was refused. Its text names the field."""


def fields(text: str, names: Tuple[str, ...], others: Tuple[str, ...] = ()) -> List[str]:
    """The values of the fields `names`, in their order. `others` may be there too."""
    length = len(text.encode("utf-8", "replace"))
    if length > MAX_BYTES:
        raise InvalidMessage(f"query of {length} bytes: a message has at most {MAX_BYTES}")
    found = {}
    for pair in text.split("&"):
        if not pair:
            continue
        key, _, value = pair.partition("=")
        key = _decoded(key)
        if key not in names and key not in others:
            raise InvalidMessage(
                f"field `{excerpt(key)}` is unknown: this message has the fields"
                f" {', '.join(names)}"
            )
        if key in found:
            raise InvalidMessage(f"field `{key}` appears twice: give it once")
        found[key] = _decoded(value)
    for name in names:
        if name not in found:
            raise InvalidMessage(
                f"field `{name}` is missing: this message has the fields {', '.join(names)}"
            )
    return [found[name] for name in names]


def count(field: str, value: str) -> int:
    """A count or a time in nanoseconds: digits only, so neither `+7` nor ` 7`."""
    if value.isascii() and value.isdigit():
        number = int(value)
        if number <= MAX_COUNT:
            return number
    raise InvalidMessage(
        f"field `{field}`: `{excerpt(value)}` is not a whole number from 0 to {MAX_COUNT}"
    )


def finite(field: str, value: str) -> float:
    """A finite number. `1e400` reads as infinite and is refused too."""
    if _NUMBER.fullmatch(value):
        number = float(value)
        if isfinite(number):
            return number
    raise InvalidMessage(
        f"field `{field}`: `{excerpt(value)}` is not a finite decimal number;"
        " write it like 0.35 or -1e-3"
    )


def decimal(number: float) -> str:
    """A number in the fewest digits that read back to the same float.

    `repr` writes `1e+16`, and in a query a plus sign is a space.
    """
    return repr(number).replace("e+", "e")


def excerpt(text: str, limit: int = EXCERPT_CHARS) -> str:
    """The beginning of a text that came from outside, fit for a log line."""
    start = "".join(
        char if char.isprintable() else char.encode("unicode_escape").decode("ascii")
        for char in text[:limit]
    )
    return start + "..." if len(text) > limit else start


def _decoded(text: str) -> str:
    return unquote_plus(text) if "%" in text or "+" in text else text
