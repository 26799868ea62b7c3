"""A thread that sends one blocking request at a time.

It knows neither the schedule nor the law: a command comes into its mailbox, and
how the message ended goes into the inbox of the loop.
"""

from __future__ import annotations

import threading
from queue import SimpleQueue
from time import monotonic_ns
from typing import List, Optional, Protocol, Tuple

from webloop.exchange import Ended, ExchangeError, NoAnswer
from webloop.inbox import Inbox
from webloop.message import Answer, Command
from webloop.row import ANSWERED, FAILED, TIMEOUT

STACK_BYTES = 256 * 1024
"""What a worker needs, with room: thousands may be waiting at one time."""


class Connection(Protocol):
    """What a worker sends its requests over."""

    opened: int
    """How often it was opened."""

    def command(self, command: Command, mode: str) -> Tuple[Answer, int]:
        """Sends a command; its answer, and when that was there."""

    def close(self) -> None:
        """Closes the connection."""


class Worker:
    """A thread with a connection of its own, started at once."""

    def __init__(
        self,
        connection: Connection,
        mode: str,
        idle: List[Worker],
        ended: Inbox,
    ) -> None:
        """It puts itself into `idle` whenever it can take a command again.

        Raises RuntimeError if the system has no thread left.
        """
        self.connection = connection
        self._mode = mode
        self._idle = idle
        self._ended = ended
        self._mailbox: SimpleQueue[Optional[Command]] = SimpleQueue()
        # A worker that waits for an answer must not keep the program from ending.
        threading.Thread(target=self._run, name="worker", daemon=True).start()

    def give(self, command: Command) -> None:
        """Has it send a command; it must be idle."""
        self._mailbox.put(command)

    def end(self) -> None:
        """Has it end once its message has."""
        self._mailbox.put(None)

    def _run(self) -> None:
        while True:
            command = self._mailbox.get()
            if command is None:
                self.connection.close()
                return
            ended = self._sent(command)
            # In this order: whoever sees that the message ended finds the
            # worker idle, so there are never more workers than messages.
            self._idle.append(self)
            self._ended.put(ended)

    def _sent(self, command: Command) -> Ended:
        try:
            answer, t_ns = self.connection.command(command, self._mode)
            return Ended(command.seq, t_ns, ANSWERED, answer)
        except NoAnswer:
            return Ended(command.seq, monotonic_ns(), TIMEOUT)
        except ExchangeError as error:
            return Ended(command.seq, monotonic_ns(), FAILED, why=str(error))
