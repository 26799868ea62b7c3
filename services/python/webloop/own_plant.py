"""A plant of one's own: an object with `step(u, dt)`, stepped by webloop's plant each h.

webloop's plant keeps the deadlines and speaks HTTP; this program only advances when it is told a u,
on its standard input, and prints y: a number a line, or two with a comma between them. So the same
program runs in real and in virtual time.
"""

from __future__ import annotations

import os
import sys
from math import isnan
from typing import Any, Collection, NoReturn, Protocol, Union

from webloop.message import numbers, signal_of

NAME = "webloop.plant"
"""How it calls itself in errors."""


class Plant(Protocol):
    """What `plant` takes. With an attribute `y`, that is the output before the first step; else 0."""

    # A plant may say that u is a float, or that it is a tuple: so it is Any here.
    def step(self, u: Any, dt: float, /) -> Union[float, Collection[float]]:
        """Advances by dt = h, in s, under the input u, and returns the output y. u is a float, and a
        tuple of two if the plant has two inputs; y is a number, or a tuple, list or array of two, and
        so is the attribute."""


class PlantError(Exception):
    """A plant of one's own returned no number, nor two."""


def plant(model: Plant) -> NoReturn:
    """Steps this plant for as long as webloop asks, then ends the program.

    A system file names it: `[plant]` with `run = ["python3", "./mine.py"]`. What it prints by itself
    goes to standard error, so that it is no y.
    """
    lines, answers = sys.stdin, sys.stdout
    sys.stdout = sys.stderr
    try:
        dt = float(os.environ["WEBLOOP_H_S"])
    except (KeyError, ValueError):
        sys.stderr.write(
            f"{NAME}: WEBLOOP_H_S is not set, so there is no step to advance by: start this program by"
            " `webloop serve plant --system mine.toml` or `webloop conform --plant -- python3 mine.py`\n"
        )
        sys.exit(2)
    try:
        answers.write(_line(getattr(model, "y", 0.0), "y before the first step"))
        answers.flush()
        for line in lines:
            inputs = tuple(map(float, line.split(",")))
            u = inputs if len(inputs) > 1 else inputs[0]
            answers.write(_line(model.step(u, dt), f"step(u={u}, dt={dt})"))
            answers.flush()
    except PlantError as error:
        sys.stderr.write(f"{NAME}: {error}\n")
        sys.exit(1)
    except BrokenPipeError:
        # Nobody asks any more.
        pass
    sys.exit(0)


def _line(y: object, what: str) -> str:
    """The line for an output, or for two; numbers of another library, such as numpy's, too."""
    try:
        return ",".join(map(repr, numbers(signal_of(y, _number)))) + "\n"
    except (TypeError, ValueError, OverflowError, LookupError):
        raise PlantError(f"{what} returned `{y!r}`; return y, a number, or two of a plant with two outputs") from None


def _number(y: Any) -> float:
    """A number, which may be infinite. Raises `TypeError`, `ValueError` or `OverflowError`."""
    number = float(y)
    if isnan(number):
        raise ValueError
    return number
