"""Where the loop waits: what other threads and signals' handlers put in, or a time.

It is not `queue.SimpleQueue`, whose `get` with a timeout may wait for ever
(seen in CPython 3.11): one that finds its lock free and its time over at the
same moment goes on with a time-out below zero, which means none.
"""

from __future__ import annotations

import threading
from collections import deque
from typing import Deque, Optional


class Inbox:
    """Takes things from any thread, and from a signal's handler; one thread
    takes them out."""

    def __init__(self) -> None:
        self._things: Deque[object] = deque()
        self._bell = threading.Lock()
        self._bell.acquire()

    def put(self, thing: object) -> None:
        """Puts a thing in, and wakes who waits."""
        self._things.append(thing)
        try:
            self._bell.release()
        except RuntimeError:
            # It rings already.
            pass

    def wait(self, timeout_s: Optional[float] = None) -> None:
        """Waits until a thing is there or the time is over, `None` being never.
        It may return before either: look, and wait again."""
        if not self._things:
            self._bell.acquire(timeout=-1 if timeout_s is None else timeout_s)

    def take(self) -> Optional[object]:
        """The thing that came first; None if the inbox is empty."""
        try:
            return self._things.popleft()
        except IndexError:
            return None
