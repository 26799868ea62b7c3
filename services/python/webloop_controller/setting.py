"""How the controller is set up, as checked values.

The words are those of the crate `endpoint`'s `setting`, and so are the limits.
How they are typed is in `argument`.
"""

from __future__ import annotations

from math import isfinite
from typing import NamedTuple, Optional, Tuple

from webloop_controller.law import Law

MODES = ("open", "closed")
"""open: the plant only acknowledges. closed: it applies u and answers with its state."""

CONNECTIONS = ("keep", "new")
"""keep: a message takes an idle connection. new: it opens one and closes it."""

SCHEDULES = ("absolute", "relative", "since-send")
"""absolute: start + k h. relative: h after the last message ended or was sent.
since-send: h after it was sent, or when one has ended if none more may be under way."""

INTEGRATES = ("h", "elapsed")
"""What the integrator advances by: the nominal h, or the time since the last message."""

LATES = ("apply", "drop")
"""Answers that a newer one has overtaken: taken as they arrive, or left out."""

TRANSPORTS = ("http", "websocket")
"""http: a request a message. websocket: all messages over one socket."""

UNLIMITED = 8192
"""The technical limit on requests under way, as the other clients have it."""


def parse_outstanding(word: str) -> int:
    """How many requests may be under way: a number or `unlimited`."""
    if word == "unlimited":
        return UNLIMITED
    if word.isascii() and word.isdigit() and len(word) <= 5 and 1 <= int(word) <= UNLIMITED:
        return int(word)
    raise ValueError(
        f"outstanding `{word}` is unknown; choose a number from 1 to {UNLIMITED}, or unlimited"
    )


def parse_reference(word: str) -> float:
    """The reference r: a finite number."""
    try:
        r = float(word)
    except ValueError:
        r = float("nan")
    if not isfinite(r):
        raise ValueError(f"`{word}` is no reference; give a finite number, like 1 or -0.5")
    return r


class Settings(NamedTuple):
    """What decides when a message is sent and with which u."""

    mode: str
    """open or closed."""
    h_ns: int
    """Sample time."""
    r: float
    """The reference."""
    outstanding: int
    """How many requests may be under way."""
    schedule: str
    """absolute, relative or since-send."""
    integrate: str
    """h or elapsed."""
    late: str
    """apply or drop."""


class Config(NamedTuple):
    """Everything that a controller is told."""

    settings: Settings
    """When it sends, and what."""
    law: Law
    """What makes u of r and y; at rest, and for one run."""
    plant: Tuple[str, int]
    """The plant's address and port."""
    transport: str
    """http or websocket."""
    connection: str
    """keep or new; a WebSocket is always kept."""
    timeout_ns: int
    """How long a message waits for its answer."""
    start_ns: Optional[int]
    """The first deadline on the run's clock; soon, if not given."""
    duration_ns: int
    """Deadlines end this long after the first."""
    out: str
    """The folder of messages.csv and controller.json; made if need be."""


def authority(plant: Tuple[str, int]) -> str:
    """A plant's address as a URL and a Host header have it."""
    host, port = plant
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
