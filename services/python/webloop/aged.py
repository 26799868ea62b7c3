"""State feedback whose Kalman filter knows how old each output is.

A port of the crate `control`'s `law::aged` and `law::filter`, which say what it
does and why. An answer names the tick of its outputs and the inputs held from
the next one on; an update steps the filter tick by tick to the newest output,
and predicts ahead to the tick at which its command acts.
"""

from __future__ import annotations

from collections import deque
from math import isfinite
from typing import Callable, Deque, List, NamedTuple, Optional, Sequence, Tuple

from webloop.feedback import Commands
from webloop.message import AnswerFacts, Moment, Signal, numbers
from webloop.model import Matrices, all_finite, dot

MOST_TICKS = 1_000
"""Most ticks that are stepped at once; of more, the first are left out."""

MOST_SENT = 1_000
"""Most commands whose effect is not known yet."""

Rows = Sequence[Sequence[float]]


class Noise(NamedTuple):
    """The noise of a filter as covariances, as rows."""

    covariance: Rows
    drift: Rows
    cross: Rows
    output: Rows


class _Newest(NamedTuple):
    """The newest answer that the filter has taken, or what stands for none."""

    tick: int
    u: Sequence[float]
    send_ns: int
    is_none: bool


class AgedFeedback:
    """A running law, at rest when new."""

    __slots__ = (
        "_model",
        "_commands",
        "_noise",
        "_h_ns",
        "_state",
        "_covariance",
        "_newest",
        "_sent",
        "_output",
    )

    def __init__(self, model: Matrices, commands: Commands, noise: Noise, h_ns: int) -> None:
        """For a model that is sampled every `h_ns`, whose noise fits it."""
        self._model = model
        self._commands = commands
        self._noise = noise
        self._h_ns = h_ns
        # The state before the tick after the newest answer's, and its covariance.
        self._state: Sequence[float] = [0.0] * len(model.a)
        self._covariance = noise.covariance
        self._newest: Optional[_Newest] = None
        self._sent: Deque[Tuple[int, Sequence[float]]] = deque()
        self._output: Signal = commands.rest()

    def update(
        self, r: float, y: Signal, dt_s: float, times: Optional[Moment] = None
    ) -> Signal:
        """The command for the reference r and the newest output y.

        What is not finite changes nothing, nor does an update without times: the
        last command is returned again (0 before the first)."""
        if times is None:
            return self._output
        send_ns, told = times
        outputs = numbers(y)
        inputs = len(self._model.b[0])
        fits = len(outputs) == len(self._model.c) and isfinite(r) and all_finite(outputs)
        if fits and told is not None:
            held = numbers(told.u)
            fits = len(held) == inputs and all_finite(held)
        if not fits:
            return self._output
        if self._newest is None:
            self._newest = _Newest(-1, [0.0] * inputs, send_ns - self._h_ns, True)
        if told is not None and not self._take(self._newest, outputs, told):
            return self._output
        u = self._commands.at(r, self._predicted(self._newest, send_ns))
        if not all_finite(u):
            return self._output
        if len(self._sent) == MOST_SENT:
            self._sent.popleft()
        self._sent.append((send_ns, u))
        self._output = u[0] if len(u) == 1 else (u[0], u[1])
        return self._output

    def _take(self, newest: _Newest, outputs: Sequence[float], told: AnswerFacts) -> bool:
        """Steps the filter to an answer. False, and nothing is changed, if a
        number overflows."""
        if newest.is_none:
            # The first command came to the plant so long before the one answered.
            tick = told.tick - self._ticks(told.send_ns - newest.send_ns)
            newest = newest._replace(tick=tick)
        if told.tick < newest.tick or told.send_ns < newest.send_ns:
            return True
        state, covariance = self._state, self._covariance
        held = self._held(newest, told.send_ns)
        for k in range(max(told.tick - (MOST_TICKS - 1), newest.tick + 1), told.tick + 1):
            seen = outputs if k == told.tick else None
            state, covariance = self._tick(state, covariance, held.at(k), seen)
        if not (all_finite(state) and all(map(all_finite, covariance))):
            return False
        self._state, self._covariance = state, covariance
        while self._sent and self._sent[0][0] <= told.send_ns:
            self._sent.popleft()
        self._newest = _Newest(told.tick, list(numbers(told.u)), told.send_ns, False)
        return True

    def _predicted(self, newest: _Newest, send_ns: int) -> Sequence[float]:
        """The state before the tick at which a command of now acts."""
        x = self._state
        held = self._held(newest, send_ns)
        acts = held.acts(send_ns)
        for k in range(max(newest.tick + 1, acts - MOST_TICKS), acts):
            x = self._step(x, held.at(k))
        return x

    def _tick(
        self, x: Sequence[float], p: Rows, u: Sequence[float], seen: Optional[Sequence[float]]
    ) -> Tuple[List[float], Rows]:
        """A tick with inputs u, whose outputs were seen, or were not: the next
        state and covariance."""
        a, _, c, d = self._model
        drift, cross, output = self._noise[1:]
        # The covariance is symmetric: its columns are its rows.
        ahead = [[dot(row, column) for column in p] for row in a]
        after = self._step(x, u)
        gain: Rows = []
        reach: Rows = []
        if seen is not None:
            reach = [
                [dot(of_c, row, start) for of_c, start in zip(c, starts)]
                for row, starts in zip(ahead, cross)
            ]
            scale = [
                [_added(start, of_c, other, p) for other, start in zip(c, starts)]
                for of_c, starts in zip(c, output)
            ]
            gain = _gain(reach, scale)
            error = [
                new - dot(of_u, u, dot(of_x, x)) for new, of_x, of_u in zip(seen, c, d)
            ]
            after = [dot(gains, error, was) for gains, was in zip(gain, after)]
        spread = [list(row) for row in p]
        is_seen = any(g != 0.0 for row in gain for g in row)
        for i, row in enumerate(ahead):
            for j in range(i, len(a)):
                entry = dot(row, a[j], drift[i][j])
                if is_seen:
                    entry -= dot(gain[i], reach[j])
                spread[i][j] = spread[j][i] = entry
        return after, spread

    def _step(self, x: Sequence[float], u: Sequence[float]) -> List[float]:
        a, b = self._model[:2]
        return [dot(of_u, u, dot(of_x, x)) for of_x, of_u in zip(a, b)]

    def _ticks(self, ns: int) -> int:
        """The whole ticks nearest to a time."""
        return (max(ns, 0) + self._h_ns // 2) // self._h_ns

    def _held(self, newest: _Newest, until_ns: int) -> _Held:
        sent = [command for command in self._sent if command[0] < until_ns]
        return _Held(newest, sent, self._ticks)


class _Held:
    """The inputs that the plant holds from the newest answer on, as far as is
    known."""

    def __init__(
        self,
        newest: _Newest,
        sent: List[Tuple[int, Sequence[float]]],
        ticks: Callable[[int], int],
    ) -> None:
        self._newest = newest
        # The oldest last.
        self._sent = sent[::-1]
        self._ticks = ticks
        self._u = newest.u

    def acts(self, send_ns: int) -> int:
        """The first tick with a command that was sent then."""
        return self._newest.tick + self._ticks(send_ns - self._newest.send_ns) + 1

    def at(self, tick: int) -> Sequence[float]:
        """The inputs of a tick, which is no earlier than that of the last call."""
        while self._sent and self.acts(self._sent[-1][0]) <= tick:
            self._u = self._sent.pop()[1]
        return self._u


def _added(total: float, left: Sequence[float], right: Sequence[float], p: Rows) -> float:
    """left P right, added to `total`."""
    for factor, row in zip(right, p):
        total += dot(left, row) * factor
    return total


def _gain(reach: Rows, scale: Rows) -> Rows:
    """reach times the inverse of scale, which is 1 by 1 or 2 by 2."""
    if len(scale) == 1:
        return [[_over(w, scale[0][0])] for (w,) in reach]
    (s00, s01), (s10, s11) = scale
    det = s00 * s11 - s01 * s10
    return [
        [_over(w0 * s11 - w1 * s10, det), _over(w1 * s00 - w0 * s01, det)] for w0, w1 in reach
    ]


def _over(x: float, y: float) -> float:
    """x / y, and no error where y is 0."""
    return x / y if y != 0.0 else float("nan")
