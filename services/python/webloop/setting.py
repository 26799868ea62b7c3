"""How the controller is set up, as checked values.

Each setting is declared here once, with its words, which are those of the crate `endpoint`, and so
are the limits. How settings are typed or read is in `argument`.
"""

from __future__ import annotations

from math import isfinite
from typing import Any, Callable, NamedTuple, Optional, Sequence, Tuple

from webloop.law import Law
from webloop.span import parse_sample_time, parse_span

UNLIMITED = 8192
"""The technical limit on requests under way, as the other clients have it."""


def parse_outstanding(word: str) -> int:
    """How many requests may be under way: a number or `unlimited`."""
    if word == "unlimited":
        return UNLIMITED
    if word.isascii() and word.isdigit() and len(word) <= 5 and 1 <= int(word) <= UNLIMITED:
        return int(word)
    raise ValueError(
        f"outstanding is `{word}`; give 1 to {UNLIMITED}, or `unlimited`"
    )


def parse_reference(word: str) -> float:
    """The reference r: a finite number."""
    try:
        r = float(word)
    except ValueError:
        r = float("nan")
    if not isfinite(r):
        raise ValueError(f"`{word}` is not a reference; give a finite number, like 1 or -0.5")
    return r


def parse_choice(name: str, words: Sequence[str]) -> Callable[[str], str]:
    """Reads one of these words."""

    def parse(word: str) -> str:
        if word not in words:
            raise ValueError(f"{name} `{word}` is unknown; choose {' or '.join(words)}")
        return word

    return parse


class Settings(NamedTuple):
    """How a controller sends."""

    mode: str
    """open: the plant only acknowledges. closed: it applies u and answers with its state."""
    h_ns: int
    """Sample time."""
    r: float
    """The reference."""
    outstanding: int
    """How many requests may be under way."""
    schedule: str
    """absolute: start + k h. relative: h after the last message ended or was sent.
    since-send: h after it was sent, or when one has ended if none more may be under way."""
    integrate: str
    """What the integrator advances by: the nominal h, or the time that has elapsed since the
    last message."""
    late: str
    """Answers that a newer one has overtaken: apply as they arrive, or drop."""
    transport: str = "http"
    """http: a request a message. websocket: all messages over one socket."""
    connection: str = "keep"
    """keep: a message takes an idle connection. new: it opens one and closes it."""
    timeout_ns: int = 5_000_000_000
    """How long a message waits for its answer."""


class Declared(NamedTuple):
    """A setting by its name: how it is typed, and how JSON has it."""

    name: str
    """As an option has it."""
    field: str
    """As `Settings` has it."""
    parse: Callable[[str], object]
    """Reads what is typed; raises `ValueError`."""
    default: str
    """What it is if it is not typed."""
    about: str
    """For the help."""
    placeholder: str = "WORD"
    """For the help."""

    @property
    def key(self) -> str:
        """As JSON has it: a time is there in nanoseconds, but a sample time with its unit."""
        return self.name if self.field == "h_ns" else self.field

    def told(self, value: object) -> Any:
        """Its value from JSON. Raises `ValueError`."""
        if self.key.endswith("_ns"):
            if isinstance(value, int) and not isinstance(value, bool) and value > 0:
                return value
            raise ValueError(f"{self.key} `{value}` is not a whole number of nanoseconds above 0")
        return self.parse(str(value))


def _choice(name: str, words: Sequence[str], default: str, about: str) -> Declared:
    parse = parse_choice(name, words)
    return Declared(name, name, parse, default, f"{' or '.join(words)}: {about}")


DECLARED = (
    Declared("h", "h_ns", parse_sample_time, "3ms", "sample time", "TIME"),
    _choice("mode", ("open", "closed"), "closed", "whether the plant applies the commands"),
    Declared("r", "r", parse_reference, "1", "reference", "NUMBER"),
    Declared(
        "outstanding",
        "outstanding",
        parse_outstanding,
        "unlimited",
        "requests under way: a number, or unlimited",
        "N",
    ),
    _choice("transport", ("http", "websocket"), "http", "how messages go"),
    _choice("connection", ("keep", "new"), "keep", "whether a request keeps its connection"),
    _choice(
        "schedule",
        ("absolute", "relative", "since-send"),
        "absolute",
        "what the next deadline counts from",
    ),
    _choice("integrate", ("h", "elapsed"), "h", "what the integrator advances by"),
    _choice("late", ("apply", "drop"), "apply", "overtaken answers"),
    Declared("timeout", "timeout_ns", parse_span, "5s", "a request is given up after this time", "TIME"),
)
"""Every setting, in the order of the help."""


Reference = Sequence[Tuple[int, float]]
"""The changes of a reference that moves, in order; the first is at 0."""


class Config(NamedTuple):
    """Settings of a controller."""

    settings: Settings
    """How it sends."""
    law: Law
    """What makes u of r and y; at rest, and for one run."""
    plant: Tuple[str, int]
    """The plant's address and port."""
    start_ns: Optional[int]
    """The first deadline on the run's clock; soon, if not given."""
    duration_ns: int
    """Deadlines end this long after the first."""
    out: str
    """The folder of messages.csv and controller.json; made if need be."""
    claim: bool = False
    """Whether to claim the plant for a session first, and again after losing it."""
    again: bool = False
    """Whether an earlier controller of the same run, with the same `start_ns`, was killed: this one
    counts its deadlines on, and appends to its file."""
    reference: Optional[Reference] = None
    """When r changes, in ns after the first deadline, and to what; None if it rests."""


def check(settings: Settings) -> Settings:
    """Refuses settings that do not go together, with a `ValueError`."""
    if settings.transport == "websocket" and settings.connection == "new":
        raise ValueError(
            "connection `new` cannot go with transport `websocket`: all messages share one"
            " socket; choose connection `keep`, or transport `http`"
        )
    return settings


def authority(plant: Tuple[str, int]) -> str:
    """A plant's address as a URL and a Host header have it."""
    host, port = plant
    return f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
