"""State feedback with an observer: the law knows the plant and the round trip.

The observer runs a model of the plant with the command, and a line of its
outputs as long as the round trip. The newest y is held against the line's end,
where the output is that y tells of, and corrects the state and the line.
"""

from __future__ import annotations

from math import isfinite
from typing import Sequence

from webloop.model import Model, all_finite, dot
from webloop.pid import Limits


class StateFeedback:
    """A running law, at rest when new."""

    __slots__ = (
        "_model",
        "_gains",
        "_of_state",
        "_of_line",
        "_reference",
        "_limits",
        "_x",
        "_line",
        "_output",
    )

    def __init__(
        self,
        model: Model,
        gains: Sequence[float],
        observer: Sequence[float],
        reference: float,
        limits: Limits,
    ) -> None:
        """`gains` has n numbers for a model with n states, `observer` n for the
        state and then one for each place of the line, at least one."""
        states = len(model.b)
        self._model = model
        self._gains = gains
        self._of_state = observer[:states]
        self._of_line = observer[states:]
        self._reference = reference
        self._limits = limits
        self._x = model.at_rest()
        # Outputs on their way here, the newest first.
        self._line = [0.0] * len(self._of_line)
        self._output = 0.0

    def update(self, r: float, y: float, dt_s: float) -> float:
        """The command for the reference r and the newest output y; one step,
        whatever `dt_s` is.

        What is not finite, taken in or worked out, changes nothing: the last
        command is returned again (0 before the first).
        """
        if not (isfinite(r) and isfinite(y)):
            return self._output
        innovation = y - self._line[-1]
        x = [was + gain * innovation for was, gain in zip(self._x, self._of_state)]
        line = [was + gain * innovation for was, gain in zip(self._line, self._of_line)]
        u = self._limits.clip(self._reference * r - dot(self._gains, x))
        fresh, x = self._model.step(x, u)
        line.insert(0, fresh)
        if isfinite(u) and all_finite(x) and all_finite(line):
            line.pop()
            self._x = x
            self._line = line
            self._output = u
        return self._output
