"""A plant of one's own: an object with `step(u, dt)`, stepped by webloop's plant each h.

webloop's plant keeps the deadlines and speaks HTTP; this program only advances when it is told a u,
on its standard input, and prints y. So the same program runs in real and in virtual time.
"""

from __future__ import annotations

import os
import sys
from math import isnan
from typing import NoReturn, Protocol

NAME = "webloop.plant"
"""How it calls itself in errors."""


class Plant(Protocol):
    """What `plant` takes. With an attribute `y`, that is the output before the first step; else 0."""

    def step(self, u: float, dt: float, /) -> float:
        """Advances by dt = h, in s, under the input u, and returns the output y."""


class PlantError(Exception):
    """A plant of one's own raised, or returned no number."""


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
        answers.write(f"{_number(getattr(model, 'y', 0.0), 'y before the first step')!r}\n")
        answers.flush()
        for line in lines:
            u = float(line)
            answers.write(f"{_number(model.step(u, dt), f'step(u={u}, dt={dt})')!r}\n")
            answers.flush()
    except PlantError as error:
        sys.stderr.write(f"{NAME}: {error}\n")
        sys.exit(1)
    except BrokenPipeError:
        # Nobody asks any more.
        pass
    sys.exit(0)


def _number(y: object, what: str) -> float:
    """The number that an output is; one of another library, such as numpy's, too."""
    try:
        number = float(y)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise PlantError(f"{what} returned `{y!r}`; return y, a number") from None
    if isnan(number):
        raise PlantError(f"{what} returned nan; return y, a number")
    return number
