"""A transfer function as the control law: a sampled model with input e, output u.

It is sampled once, beforehand: a step a message, however long the last is ago.
"""

from __future__ import annotations

from math import isfinite
from typing import Optional

from webloop.message import Moment, Signal, first
from webloop.model import Model, all_finite
from webloop.pid import Limits


class Transfer:
    """A running law, at rest when new."""

    __slots__ = ("_model", "_limits", "_x", "_output")

    def __init__(self, model: Model, limits: Limits) -> None:
        self._model = model
        self._limits = limits
        self._x = model.at_rest()
        self._output = 0.0

    def update(
        self, r: float, y: Signal, dt_s: float, times: Optional[Moment] = None
    ) -> float:
        """The command for the reference r and the newest output y, of two the
        first; one step, whatever `dt_s` is.

        What is not finite, taken in or worked out, changes nothing: the last
        command is returned again (0 before the first).
        """
        y = first(y)
        if not (isfinite(r) and isfinite(y)):
            return self._output
        wanted, x = self._model.step(self._x, r - y)
        u = self._limits.clip(wanted)
        if isfinite(u) and all_finite(x):
            self._x = x
            self._output = u
        return self._output
