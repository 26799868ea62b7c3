"""A row of `messages.csv`: one deadline of the controller, and its message.

A port of the crate `endpoint`'s `MessageRow`. All times are nanoseconds on the
run's monotonic clock; an empty field means that there was nothing to record.
"""

from __future__ import annotations

from typing import Optional

COLUMNS = (
    "seq",
    "t_due_ns",
    "t_send_ns",
    "t_receive_ns",
    "t_arrive_ns",
    "r",
    "y",
    "e",
    "u",
    "tick",
    "outcome",
    "y_seq",
)
"""The columns of `messages.csv`, in order."""

ANSWERED = "answered"
"""The message was sent and a valid answer came."""
TIMEOUT = "timeout"
"""The message was sent and no answer came within the timeout."""
FAILED = "failed"
"""The message was sent, and the connection or the answer was broken."""
MISSED = "missed"
"""Nothing was sent: no request was free, or the moment had passed."""


class MessageRow:
    """One deadline; rows are written in the order in which messages ended."""

    __slots__ = COLUMNS

    def __init__(self, seq: int, t_due_ns: int, r: float) -> None:
        self.seq = seq
        self.t_due_ns = t_due_ns
        self.t_send_ns: Optional[int] = None
        self.t_receive_ns: Optional[int] = None
        self.t_arrive_ns: Optional[int] = None
        self.r = r
        self.y: Optional[float] = None
        self.e: Optional[float] = None
        self.u: Optional[float] = None
        self.tick: Optional[int] = None
        self.outcome = MISSED
        self.y_seq: Optional[int] = None

    def line(self) -> str:
        """The row as a line of CSV. Numbers and words need no quotes, and
        `repr` writes the fewest digits that read back to the same number."""
        send, receive, arrive = self.t_send_ns, self.t_receive_ns, self.t_arrive_ns
        y, e, u, tick, y_seq = self.y, self.e, self.u, self.tick, self.y_seq
        return (
            f"{self.seq},{self.t_due_ns},"
            f"{'' if send is None else send},"
            f"{'' if receive is None else receive},"
            f"{'' if arrive is None else arrive},"
            f"{self.r!r},"
            f"{'' if y is None else repr(y)},"
            f"{'' if e is None else repr(e)},"
            f"{'' if u is None else repr(u)},"
            f"{'' if tick is None else tick},"
            f"{self.outcome},"
            f"{'' if y_seq is None else y_seq}\n"
        )
