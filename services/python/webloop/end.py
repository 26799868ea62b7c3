"""The controller's end: a deadline every h, a command at each if it may.

A port of the crate `endpoint`'s `ControllerEnd`, which is the reference.
`poll` is asked for the next step until it says to wait; `answered` and `lost`
tell it how a message ended. Each deadline becomes exactly one row: at once if
nothing was sent, otherwise when its message ends. No socket and no clock here.
"""

from __future__ import annotations

from typing import Dict, NamedTuple, Optional, Union

from webloop.law import Law
from webloop.message import Answer, AnswerFacts, Command, Moment, Signal, first
from webloop.row import ANSWERED, TIMEOUT, MessageRow
from webloop.setting import Reference, Settings


class Send(NamedTuple):
    """Send this command now, then ask again."""

    command: Command


class Missed(NamedTuple):
    """Record this deadline, at which nothing is sent, then ask again."""

    row: MessageRow


class Sleep(NamedTuple):
    """Ask again at this time, or when a message has ended."""

    until_ns: int


class AwaitAnswer:
    """Ask again when the message under way has ended."""


class Finished:
    """There are no more deadlines. Messages may still be under way."""


Step = Union[Send, Missed, Sleep, AwaitAnswer, Finished]

_AWAIT_ANSWER = AwaitAnswer()
_FINISHED = Finished()


class Counts:
    """How many deadlines there were, and what became of them.

    due = sent + missed, and sent = answered + timeout + failed plus those
    still under way.
    """

    __slots__ = ("due", "sent", "missed", "answered", "timeout", "failed")

    def __init__(self) -> None:
        self.due = self.sent = self.missed = 0
        self.answered = self.timeout = self.failed = 0

    def words(self) -> Dict[str, int]:
        """The counts by name, for a report."""
        return {name: getattr(self, name) for name in self.__slots__}


class ControllerEnd:
    """The controller's end of the loop.

    Its first deadline is `start_ns` and its last is before `stop_ns`. `y` is
    the plant's output before the first answer: 0 for a plant at rest. Laws get
    all outputs, rows have the first.
    `reference` has the changes of r; without it r rests at the settings'.
    """

    def __init__(
        self,
        settings: Settings,
        law: Law,
        y: Signal,
        start_ns: int,
        stop_ns: int,
        reference: Optional[Reference] = None,
    ) -> None:
        self.settings = settings
        self.law = law
        # The newest change of r, and those to come; deadlines only go forward.
        self._r = settings.r
        self._changes = list(reversed(reference or ()))
        self._start_ns = start_ns
        self.counts = Counts()
        # The newest output known, and the answer that brought it, by its message.
        self._y = y
        self._y_seq: Optional[int] = None
        self._told: Optional[AnswerFacts] = None
        # When the command before was sent, for `integrate` = elapsed.
        self._last_send_ns: Optional[int] = None
        self._next_seq = 0
        # None while a relative schedule waits for an answer.
        self._next_due_ns: Optional[int] = start_ns
        self._stop_ns = stop_ns
        # By seq, in order of seq.
        self._under_way: Dict[int, MessageRow] = {}

    def resume(self, now_ns: int) -> None:
        """Goes on with the run of an earlier end, which was lost: with the first deadline after
        `now_ns` on the grid start + k h, and its number k, whatever the schedule."""
        h_ns = self.settings.h_ns
        self._next_seq = max((now_ns - self._start_ns) // h_ns + 1, 0)
        self._next_due_ns = self._start_ns + self._next_seq * h_ns

    def poll(self, now_ns: int) -> Step:
        """The next step at `now_ns`. One call passes at most one deadline.

        On an absolute schedule a deadline is over when the next one is due: a
        controller that wakes late sends for the present deadline and records
        those before it as missed, since it cannot send in the past. The other
        schedules have no such grid, and a late message only delays the next.
        """
        due_ns = self._next_due_ns
        if due_ns is None:
            return _AWAIT_ANSWER
        if due_ns >= self._stop_ns:
            return _FINISHED
        if now_ns < due_ns:
            return Sleep(due_ns)
        settings = self.settings
        full = len(self._under_way) >= settings.outstanding
        if full and settings.schedule == "since-send":
            return _AWAIT_ANSWER
        counts = self.counts
        seq = self._next_seq
        self._next_seq = seq + 1
        counts.due += 1

        if settings.schedule == "absolute":
            next_ns = due_ns + settings.h_ns
            self._next_due_ns = next_ns
            over = now_ns >= next_ns
        else:
            waits = settings.outstanding == 1 and settings.schedule == "relative"
            self._next_due_ns = None if waits else now_ns + settings.h_ns
            over = False
        while self._changes and self._changes[-1][0] <= due_ns - self._start_ns:
            self._r = self._changes.pop()[1]
        row = MessageRow(seq, due_ns, self._r)
        if over or full:
            counts.missed += 1
            return Missed(row)
        counts.sent += 1
        return Send(self._send(row, now_ns))

    def answered(self, answer: Answer, now_ns: int) -> Optional[MessageRow]:
        """A message was answered. None if it is not under way (any more)."""
        row = self._end(answer.seq, now_ns)
        if row is None:
            return None
        self.counts.answered += 1
        row.t_receive_ns = now_ns
        row.t_arrive_ns = answer.t_arrive_ns
        row.outcome = ANSWERED
        tick = answer.tick
        if tick is not None:
            row.tick = tick
            # The plant's tick, not seq, is the age of a measurement: a command
            # that was overtaken on its way up brings home the newer output.
            told, send_ns = self._told, row.t_send_ns
            overtaken = told is not None and tick < told.tick
            dropped = overtaken and self.settings.late == "drop"
            y, u = answer.y, answer.u
            if not (dropped or y is None or u is None or send_ns is None):
                self._y = y
                self._y_seq = row.seq
                self._told = AnswerFacts(tick, u, send_ns)
        return row

    def lost(self, seq: int, outcome: str, now_ns: int) -> Optional[MessageRow]:
        """A message ended without a valid answer, by time-out or as failed.
        None if it is not under way."""
        row = self._end(seq, now_ns)
        if row is None:
            return None
        row.outcome = outcome
        if outcome == TIMEOUT:
            self.counts.timeout += 1
        else:
            self.counts.failed += 1
        return row

    def oldest_under_way(self) -> Optional[int]:
        """The oldest message under way, if any."""
        return next(iter(self._under_way), None)

    def _send(self, row: MessageRow, now_ns: int) -> Command:
        """The command for a deadline: from the newest output known right now."""
        settings = self.settings
        if settings.mode == "open":
            # The plant does not apply it; the reference is as good as any.
            u: Signal = row.r
        else:
            y = self._y
            row.y = first(y)
            row.e = row.r - row.y
            dt_s = settings.h_ns / 1e9
            if settings.integrate == "elapsed" and self._last_send_ns is not None:
                dt_s = max(now_ns - self._last_send_ns, 0) / 1e9
            row.y_seq = self._y_seq
            u = self.law.update(row.r, y, dt_s, Moment(now_ns, self._told))
        row.t_send_ns = now_ns
        row.u = first(u)
        self._last_send_ns = now_ns
        self._under_way[row.seq] = row
        return Command(row.seq, now_ns, u)

    def _end(self, seq: int, now_ns: int) -> Optional[MessageRow]:
        """Takes a message off those under way."""
        row = self._under_way.pop(seq, None)
        if row is not None and self._next_due_ns is None:
            # Only a relative schedule with one outstanding waits for this.
            self._next_due_ns = now_ns + self.settings.h_ns
        return row
