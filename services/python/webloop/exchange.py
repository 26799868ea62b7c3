"""The seam between the loop and the network: how a command goes out, and how
its answer comes back.

The loop knows nothing of HTTP. It hands a command to an `Exchange`, which must
not keep it waiting, and finds how the message ended in an inbox.
"""

from __future__ import annotations

from typing import NamedTuple, Optional

from webloop.inbox import Inbox
from webloop.message import Answer, Command, Observation


class ExchangeError(Exception):
    """The connection broke, or the answer is invalid; its text says why."""


class NoAnswer(Exception):
    """No answer in time."""

    def __init__(self) -> None:
        super().__init__("no answer in time")


class Ended(NamedTuple):
    """How one message ended, and when."""

    seq: int
    """The number of its command."""
    t_ns: int
    """When it ended, on the run's clock."""
    outcome: str
    """answered, timeout or failed."""
    answer: Optional[Answer] = None
    """The answer of one that was answered."""
    why: str = ""
    """What was wrong with one that failed."""


class Exchange:
    """A way to the plant and back.

    `open` is called from a thread of its own until it succeeds, before the
    first `start`; `start` and `close` from the loop's thread.
    """

    def __init__(self, ended: Inbox) -> None:
        self.ended = ended
        """Where each message that was started ends, exactly once, as `Ended`."""

    def open(self, timeout_ns: int) -> Observation:
        """Opens a first connection and looks at the plant. One attempt.

        Raises `ExchangeError` or `NoAnswer`.
        """
        raise NotImplementedError

    def start(self, command: Command) -> None:
        """Sends a command, or has it sent, without waiting for anything."""
        raise NotImplementedError

    def close(self) -> None:
        """Hangs up. Messages under way need not end any more."""
        raise NotImplementedError

    def connections(self) -> int:
        """How many connections were opened so far."""
        raise NotImplementedError
