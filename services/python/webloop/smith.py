"""A Smith predictor: a PID that sees what its command will do before the link
shows it.

A model of the plant runs with the command. Its output now, less its output of
so many updates ago, which the measured y already tells of, is taken off the
error.
"""

from __future__ import annotations

from collections import deque
from math import isfinite
from typing import Deque, Optional

from webloop.message import Moment, Signal, first
from webloop.model import Model, all_finite
from webloop.pid import Pid


class Smith:
    """A running law, at rest when new."""

    __slots__ = ("_pid", "_model", "_x", "_fresh", "_line", "_output")

    def __init__(self, pid: Pid, model: Model, ticks: int) -> None:
        """`ticks` is the round trip that is expected, in updates."""
        self._pid = pid
        self._model = model
        self._x = model.at_rest()
        # The model's last output, and those before it, the oldest first.
        self._fresh = 0.0
        self._line: Deque[float] = deque([0.0] * ticks, maxlen=ticks)
        self._output = 0.0

    def update(
        self, r: float, y: Signal, dt_s: float, times: Optional[Moment] = None
    ) -> float:
        """The command for the reference r and the newest output y, of two the
        first, `dt_s` after the last.

        Where r or y is not finite the last command is returned again (0 before
        the first). A model that would not stay finite stands still.
        """
        y = first(y)
        if not (isfinite(r) and isfinite(y)):
            return self._output
        fresh = self._fresh
        old = self._line[0] if self._line else fresh
        # An error is a reference against an output of 0, to the bit.
        u = self._pid.update(r - y - (fresh - old), 0.0, dt_s)
        self._output = u
        next_fresh, x = self._model.step(self._x, u)
        if isfinite(next_fresh) and all_finite(x):
            # The oldest falls off the other end.
            self._line.append(fresh)
            self._fresh = next_fresh
            self._x = x
        return u
