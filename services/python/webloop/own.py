"""A controller of one's own: an object with `update(r, y, dt)`, as the law of the paper's loop.

Here is how such an object is called, and how a program that has one runs. When messages are sent,
and what becomes of them, is decided in `end` and `drive`, as for the built-in client.
"""

from __future__ import annotations

import os
import sys
import traceback
from math import isfinite
from typing import Any, Collection, NoReturn, Optional, Protocol, Sequence, Union

from webloop import argument
from webloop.main import FAILED, run
from webloop.message import Moment, Signal, signal_of
from webloop.query import excerpt
from webloop.setting import Config

EXCERPT_CHARS = 80
"""How much of a wrong result is repeated."""


class Controller(Protocol):
    """What `control` takes.

    If it also has a method `start(h, r)`, that is called once before the first update, in open loop
    too, with the sample time in s and the reference.
    """

    # A controller may say that y is a float, or that it is a tuple: so it is Any here.
    def update(self, r: float, y: Any, dt: float, /) -> Union[float, Collection[float]]:
        """The command u for the reference r and the newest output y: a float, and a tuple of two if
        the plant has two outputs. u is a number, or a tuple, list or array of two if the plant has
        two inputs. `dt` is h in s, or the time since the last message where the setting integrate
        is `elapsed`."""


class LawError(Exception):
    """A controller of one's own raised, or returned no finite number or two."""


class Own:
    """A controller of one's own as a law. Unlike other laws, `update` may raise: `LawError`."""

    __slots__ = ("_controller", "_calls")

    def __init__(self, controller: Controller) -> None:
        self._controller = controller
        self._calls = 0

    def start(self, h_s: float, r: float) -> None:
        """Calls the controller's `start`, if it has one. Raises `LawError`."""
        start = getattr(self._controller, "start", None)
        if not callable(start):
            return
        try:
            start(h_s, r)
        except Exception as error:
            raise _raised(f"start(h={h_s}, r={r})", error) from None

    def update(
        self, r: float, y: Signal, dt_s: float, times: Optional[Moment] = None
    ) -> Signal:
        """The controller's command for the reference r and the newest output y, `dt_s` after the
        last. Raises `LawError`."""
        self._calls += 1
        try:
            u = self._controller.update(r, y, dt_s)
        except Exception as error:
            raise _raised(self._call(r, y, dt_s), error) from None
        try:
            return signal_of(u, _finite)
        except (TypeError, ValueError, OverflowError, LookupError):
            said = excerpt(repr(u), EXCERPT_CHARS)
            raise LawError(
                f"{self._call(r, y, dt_s)} returned `{said}`; return u, a finite number, or two for a"
                " plant with two inputs"
            ) from None

    def _call(self, r: float, y: Signal, dt_s: float) -> str:
        return f"call {self._calls} of the controller, update(r={r}, y={y}, dt={dt_s}),"


def control(controller: Controller, *, arguments: Optional[Sequence[str]] = None) -> NoReturn:
    """Runs the paper's loop with this controller as its law, and ends the program.

    The environment says which plant, when and how: WEBLOOP_SETTINGS and WEBLOOP_OUT, which `webloop
    run` and `webloop conform` set. With `arguments`, the options of the built-in client say it
    instead, but for `--law`.

    Exit codes: 0 fine, 1 failed, 2 wrong usage, 130 told to end.
    """
    sys.exit(_controlled(controller, arguments))


def _controlled(controller: Controller, arguments: Optional[Sequence[str]]) -> int:
    try:
        config = _told() if arguments is None else argument.read(arguments)
    except ValueError as error:
        return _say(error, argument.USAGE)
    law = Own(controller)
    try:
        law.start(config.settings.h_ns / 1e9, config.settings.r)
        return run(config._replace(law=law), says_ready=arguments is not None)
    except LawError as error:
        return _say(error, FAILED)


def _told() -> Config:
    """What the environment says. Raises `ValueError`."""
    for name in ("WEBLOOP_SETTINGS", "WEBLOOP_OUT"):
        if not os.environ.get(name):
            raise ValueError(
                f"{name} is not set, so there is no plant to control: start this program by"
                " `webloop run` with an experiment that names it, or by"
                " `webloop conform -- python3 mine.py`"
            )
    return argument.read_settings(os.environ["WEBLOOP_SETTINGS"], os.environ["WEBLOOP_OUT"])


def _finite(number: Any) -> float:
    """A finite number. Raises `TypeError` if it is no number, else `ValueError` or `OverflowError`."""
    if not isfinite(number):
        raise ValueError
    # A number of another library, such as numpy's, prints itself with its type.
    return float(number)


def _raised(call: str, error: Exception) -> LawError:
    """Shows where the controller raised. Called where that is being handled."""
    traceback.print_exc()
    return LawError(f"{call} raised {type(error).__name__}: {error}; the lines above say where")


def _say(error: Exception, code: int) -> int:
    sys.stderr.write(f"{argument.NAME}: {error}\n")
    return code
