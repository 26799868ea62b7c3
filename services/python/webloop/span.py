"""Spans of time as they are typed: `3ms`, `6s`, `10m`, `1m30s`.

Always with a unit, and always whole nanoseconds in the end, by integers alone:
0.3 ms has to be 300000 ns, not a rounding of it.
"""

from __future__ import annotations

import re

UNITS_NS = {
    "ns": 1,
    "us": 1_000,
    "ms": 1_000_000,
    "s": 1_000_000_000,
    "m": 60_000_000_000,
    "h": 3_600_000_000_000,
}

MIN_H_NS = 10_000
"""The shortest sample time of the two ends."""

MAX_H_NS = 3_600_000_000_000
"""The longest: an hour. Beyond it a typing error is likelier than a plant."""

MAX_SPAN_NS = 2**63 - 1
"""Two such spans still add up in 64 bits; it is 292 years."""

_PART = re.compile(r"([0-9]+)(?:\.([0-9]+))?(ns|us|ms|s|m|h)")
_SPAN = re.compile(rf"(?:{_PART.pattern})(?:\s*{_PART.pattern})*")


def parse_sample_time(text: str) -> int:
    """A sample time h in nanoseconds, such as `3ms`."""
    if len(_PART.findall(text)) != 1 or not _SPAN.fullmatch(text):
        raise ValueError(f"`{text}` is not a sample time; write it like 3ms, 100us or 0.3s")
    h_ns = parse_span(text)
    if not MIN_H_NS <= h_ns <= MAX_H_NS:
        raise ValueError(
            f"h = {h_ns} ns is outside 10us to 3600s; for 333 Hz write 3ms, for 1 kHz 1ms"
        )
    return h_ns


def parse_span(text: str) -> int:
    """A span above zero in nanoseconds, such as `6s`."""
    if not _SPAN.fullmatch(text):
        raise ValueError(
            f"`{text}` is not a number with a unit; write it like 5s, 300ms or 10m"
        )
    span_ns = sum(_part_ns(*part) for part in _PART.findall(text))
    if span_ns == 0:
        raise ValueError(f"`{text}` is zero; give a time above zero, like 5s")
    if span_ns > MAX_SPAN_NS:
        raise ValueError(f"`{text}` is more than 292 years; give a shorter time, like 5s")
    return span_ns


def _part_ns(whole: str, fraction: str, unit: str) -> int:
    scaled = int(whole + fraction) * UNITS_NS[unit]
    parts: int = 10 ** len(fraction)
    part_ns, rest = divmod(scaled, parts)
    if rest:
        raise ValueError(f"`{whole}.{fraction}{unit}` is not a whole number of nanoseconds")
    return part_ns
