"""State feedback with an observer: the law knows the plant and the round trip.

The observer runs a model of the plant with the command, and a line of its
outputs as long as the round trip. The newest y is held against the line's end,
where the output is that y tells of, and corrects the state and the line. The
plant may have two inputs or two outputs.
"""

from __future__ import annotations

from math import isfinite
from typing import List, Optional, Sequence

from webloop.message import Moment, Signal, numbers
from webloop.model import Matrices, all_finite, dot
from webloop.pid import Limits


class Commands:
    """What turns states into commands: u = reference r - gains x."""

    __slots__ = ("_gains", "_reference", "_others", "_limits")

    def __init__(
        self,
        gains: Sequence[Sequence[float]],
        reference: Sequence[Sequence[float]],
        others: Sequence[float],
        limits: Limits,
    ) -> None:
        """For a model with n states and m inputs `gains` is m by n. `reference`
        has a row for each input: the factor of r, and of each of `others`, the
        references of the outputs after the first."""
        self._gains = gains
        self._reference = [(row[0], row[1:]) for row in reference]
        self._others = others
        self._limits = limits

    def at(self, r: float, x: Sequence[float]) -> List[float]:
        """The command for each input at the state x."""
        clip = self._limits.clip
        return [
            clip(dot(factors, self._others, factor * r) - dot(gains, x))
            for (factor, factors), gains in zip(self._reference, self._gains)
        ]

    def rest(self) -> Signal:
        """The command of a law at rest."""
        return 0.0 if len(self._gains) == 1 else (0.0, 0.0)


class StateFeedback:
    """A running law, at rest when new."""

    __slots__ = ("_model", "_commands", "_observer", "_state", "_output")

    def __init__(
        self, model: Matrices, commands: Commands, observer: Sequence[Sequence[float]]
    ) -> None:
        """For a model with n states and p outputs `observer` has a row for each
        state, then p for each tick that an output is on its way, at least one;
        p numbers a row."""
        self._model = model
        self._commands = commands
        self._observer = observer
        # The model's states, then its outputs on their way here, the newest first.
        self._state = [0.0] * len(observer)
        self._output = commands.rest()

    def update(
        self, r: float, y: Signal, dt_s: float, times: Optional[Moment] = None
    ) -> Signal:
        """The command for the reference r and the newest output y; one step,
        whatever `dt_s` is.

        What is not finite, taken in or worked out, changes nothing, nor do more
        or fewer outputs than the model's: the last command is returned again (0
        before the first).
        """
        a, b, c, d = self._model
        outputs = numbers(y)
        if len(outputs) != len(c) or not (isfinite(r) and all_finite(outputs)):
            return self._output
        oldest = self._state[-len(c) :]
        errors = [new - old for new, old in zip(outputs, oldest)]
        state = [dot(gains, errors, was) for was, gains in zip(self._state, self._observer)]
        x, line = state[: len(a)], state[len(a) :]
        u = self._commands.at(r, x)
        ahead = [dot(of_u, u, dot(of_x, x)) for of_x, of_u in zip(a, b)]
        ahead += [dot(of_u, u, dot(of_x, x)) for of_x, of_u in zip(c, d)]
        ahead += line
        if all_finite(u) and all_finite(ahead):
            # The oldest outputs have come to the line's end.
            self._state = ahead[: -len(c)]
            self._output = u[0] if len(u) == 1 else (u[0], u[1])
        return self._output
