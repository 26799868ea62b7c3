"""The command line: what can be typed, read into a checked `Config`.

The options are those of `webloop serve controller`, `--transport` and `--law`.
Wrong usage ends the program with 2 and a sentence.
"""

from __future__ import annotations

import argparse
import ipaddress
import sys
from typing import Callable, List, NoReturn, Optional, Sequence, Tuple, TypeVar

from webloop_controller import setting
from webloop_controller.law import paper_pi, parse_law
from webloop_controller.query import MAX_COUNT
from webloop_controller.setting import Config, Settings
from webloop_controller.span import parse_sample_time, parse_span

NAME = "webloop_controller"
"""The program's name in what it says."""

USAGE = 2
"""The exit code of wrong usage."""

T = TypeVar("T")


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        # A sentence and where to look, without a page of options before it.
        sys.stderr.write(f"{NAME}: {message}; `--help` lists the options\n")
        sys.exit(USAGE)


def read(arguments: Sequence[str]) -> Config:
    """Reads the command line; prints help or a usage error and ends the
    program where it has to."""
    parser = _parser()
    given = parser.parse_args(_joined(arguments))
    if given.transport == "websocket" and given.connection == "new":
        parser.error(
            "--connection new cannot go with --transport websocket: all messages share one"
            " socket; leave out one of the two"
        )
    return Config(
        settings=Settings(
            mode=given.mode,
            h_ns=given.h,
            r=given.r,
            outstanding=given.outstanding,
            schedule=given.schedule,
            integrate=given.integrate,
            late=given.late,
        ),
        law=paper_pi() if given.law is None else given.law,
        plant=given.plant,
        transport=given.transport,
        connection=given.connection,
        timeout_ns=given.timeout,
        start_ns=given.start_ns,
        duration_ns=given.duration,
        out=given.out,
    )


def parse_plant(text: str) -> Tuple[str, int]:
    """An address with a port: `10.77.0.2:8080` or `[::1]:8080`."""
    host, colon, port = text.rpartition(":")
    bracketed = host.startswith("[") and host.endswith("]")
    try:
        address = ipaddress.ip_address(host[1:-1] if bracketed else host)
        if not colon or bracketed != (address.version == 6):
            raise ValueError
        if not (port.isascii() and port.isdigit() and len(port) <= 5 and int(port) <= 65535):
            raise ValueError
    except ValueError:
        raise ValueError(
            f"`{text}` is not an address with a port; write it like 10.77.0.2:8080 or [::1]:8080"
        ) from None
    return str(address), int(port)


def _parse_start(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= 20 and int(text) <= MAX_COUNT):
        raise ValueError(f"`{text}` is no time; give whole nanoseconds of CLOCK_MONOTONIC")
    return int(text)


def _choice(name: str, words: Sequence[str]) -> Callable[[str], str]:
    def parse(word: str) -> str:
        if word not in words:
            raise ValueError(f"{name} `{word}` is unknown; choose {' or '.join(words)}")
        return word

    return parse


def _typed(parse: Callable[[str], T]) -> Callable[[str], T]:
    """argparse repeats the text of this one kind of error only."""

    def parsed(text: str) -> T:
        try:
            return parse(text)
        except ValueError as error:
            raise argparse.ArgumentTypeError(str(error)) from None

    return parsed


def _joined(arguments: Sequence[str]) -> List[str]:
    """`--r -1e-3` as `--r=-1e-3`: argparse would take the number for an option."""
    joined: List[str] = []
    for argument in arguments:
        if joined and joined[-1] == "--r":
            joined[-1] = f"--r={argument}"
        else:
            joined.append(argument)
    return joined


def _parser() -> _Parser:
    parser = _Parser(
        prog=NAME,
        description="The paper's controller in Python: sends every h, and ends after its duration.",
        allow_abbrev=False,
        epilog="Exit codes: 0 fine, 1 failed, 2 wrong usage, 3 this machine lacks something,"
        " 130 interrupted.",
    )

    def option(
        name: str,
        parse: Callable[[str], object],
        default: Optional[str],
        text: str,
        value: str = "WORD",
    ) -> None:
        shown = "" if default is None else f" (default: {default})"
        parser.add_argument(
            f"--{name}",
            type=_typed(parse),
            default=default,
            metavar=value,
            help=text + shown,
        )

    def choice(name: str, words: Sequence[str], default: str, text: str) -> None:
        option(name, _choice(name, words), default, f"{' or '.join(words)}: {text}")

    option("plant", parse_plant, "127.0.0.1:8080", "the plant", "ADDRESS:PORT")
    option("h", parse_sample_time, "3ms", "sample time", "TIME")
    choice("mode", setting.MODES, "closed", "whether the answers steer the plant")
    option("r", setting.parse_reference, "1", "reference", "NUMBER")
    option("law", parse_law, None, "the control law; the paper's PI, if not given", "JSON")
    option("duration", parse_span, "6s", "how long to send", "TIME")
    option(
        "outstanding",
        setting.parse_outstanding,
        "unlimited",
        "requests under way: a number, or unlimited",
        "N",
    )
    choice("transport", setting.TRANSPORTS, "http", "how messages go")
    choice("connection", setting.CONNECTIONS, "keep", "what a request does for its connection")
    choice("schedule", setting.SCHEDULES, "absolute", "where the next deadline is")
    choice("integrate", setting.INTEGRATES, "h", "what the integrator advances by")
    choice("late", setting.LATES, "apply", "answers that a newer one has overtaken")
    option("timeout", parse_span, "5s", "after this a request is given up", "TIME")
    option(
        "start-ns",
        _parse_start,
        None,
        "when to send the first message, in ns of CLOCK_MONOTONIC; soon, if not given",
        "T",
    )
    option("out", str, "serve", "where messages.csv and controller.json go", "DIR")
    return parser
