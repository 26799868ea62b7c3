"""The command line: what can be typed, read into a checked `Config`.

The options are those of `webloop serve controller`, and `--law`; or all comes at once as JSON.
Wrong usage ends the program with 2 and a sentence.
"""

from __future__ import annotations

import argparse
import ipaddress
import json
import sys
from typing import Callable, List, NoReturn, Optional, Sequence, Tuple, TypeVar

from webloop.law import paper_pi, parse_law
from webloop.query import MAX_COUNT, excerpt
from webloop.setting import DECLARED, Config, Reference, Settings, check, parse_reference
from webloop.span import parse_span

NAME = "webloop"
"""Who speaks, in what the program says."""

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
    try:
        if given.settings is not None:
            return read_settings(given.settings, given.out)
        typed = {declared.field: getattr(given, declared.name) for declared in DECLARED}
        return Config(
            settings=check(Settings(**typed)),
            law=paper_pi() if given.law is None else given.law,
            plant=given.plant,
            start_ns=given.start_ns,
            duration_ns=given.duration,
            out=given.out,
            claim=given.claim,
        )
    except ValueError as error:
        parser.error(str(error))


def read_settings(path: str, out: str) -> Config:
    """What a JSON file says, or standard input for `-`; `out` is not in it. Raises `ValueError`."""
    try:
        with sys.stdin if path == "-" else open(path, encoding="utf-8") as file:
            told = json.load(file)
    except (OSError, ValueError, RecursionError) as error:
        raise ValueError(f"cannot read the settings in {path}: {error}") from None
    if isinstance(told, dict):
        told.setdefault("claim", False)
        told.setdefault("again", False)
    keys = ("plant", "settings", "law", "start_ns", "duration_ns", "reference", "claim", "again")
    plant, settings, law, start_ns, duration_ns, reference, claim, again = _members(
        "the settings", told, keys
    )
    for key, flag in (("claim", claim), ("again", again)):
        if not isinstance(flag, bool):
            raise ValueError(f"`{key}` is `{excerpt(str(flag))}`; give true or false")
    if again and start_ns is None:
        raise ValueError(
            "the settings have `again` without `start_ns`; give the first deadline of the life that was killed"
        )
    values = _members("`settings`", settings, [declared.key for declared in DECLARED])
    read = {declared.field: declared.told(value) for declared, value in zip(DECLARED, values)}
    return Config(
        settings=check(Settings(**read)),
        law=paper_pi() if law is None else parse_law(json.dumps(law)),
        plant=parse_plant(str(plant)),
        start_ns=None if start_ns is None else _parse_start(str(start_ns)),
        duration_ns=_parse_start(str(duration_ns)),
        out=out,
        claim=bool(claim),
        again=bool(again),
        reference=None if reference is None else _parse_reference(reference),
    )


def _members(what: str, value: object, keys: Sequence[str]) -> List[object]:
    """The members of an object that has these and no other, in this order."""
    if not isinstance(value, dict):
        raise ValueError(f"{what} must be an object with {', '.join(keys)}")
    for key in value:
        if key not in keys:
            raise ValueError(f"{what}: `{excerpt(key)}` is unknown; there are {', '.join(keys)}")
    for key in keys:
        if key not in value:
            raise ValueError(f"{what}: `{key}` is missing; there are {', '.join(keys)}")
    return [value[key] for key in keys]


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
        raise ValueError(f"`{text}` is not a time; give whole nanoseconds of CLOCK_MONOTONIC")
    return int(text)


def _parse_reference(changes: object) -> Reference:
    try:
        read = [(_parse_start(str(t_ns)), parse_reference(str(r))) for t_ns, r in changes]  # type: ignore[attr-defined]
        if read[0][0] == 0 and all(one[0] < next[0] for one, next in zip(read, read[1:])):
            return read
    except (TypeError, ValueError, IndexError):
        pass
    raise ValueError("`reference` must be a list of pairs of ns and r; the first is at 0, and times rise")


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
        prog="webloop-controller",
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

    option("plant", parse_plant, "127.0.0.1:8080", "the plant", "ADDRESS:PORT")
    for declared in DECLARED:
        _, _, parse, default, about, placeholder = declared
        option(declared.name, parse, default, about, placeholder)
    parser.add_argument(
        "--claim",
        action="store_true",
        help='claim the plant for a session, as its lease "token" asks',
    )
    option("law", parse_law, None, "the control law; the paper's PI, if not given", "JSON")
    option("duration", parse_span, "6s", "how long to send", "TIME")
    option(
        "start-ns",
        _parse_start,
        None,
        "when to send the first message, in ns of CLOCK_MONOTONIC (default: soon)",
        "T",
    )
    option(
        "settings",
        str,
        None,
        "everything but --out as one JSON value, in place of the other options; - is standard input",
        "FILE",
    )
    option("out", str, "serve", "where messages.csv and controller.json go", "DIR")
    return parser
