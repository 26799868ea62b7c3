"""Rows from the loop to a file, by a thread of its own.

The loop only appends a line to a list. The thread takes what there is several
times a second, so that a run that is killed leaves its rows on disk. It does no
work of its own on them: while it works, no other thread of Python does.
"""

from __future__ import annotations

import os
import threading
from collections import deque
from typing import Deque, Dict, Optional, Sequence

FLUSH_EVERY_S = 0.1
"""How often rows go to the file."""

CAPACITY = 1 << 16
"""Rows that may wait for the file: at 1 kHz a minute, in which it may stand still."""


class JournalError(Exception):
    """Why a file of rows is missing or incomplete."""


class Journal:
    """A file of rows being written.

    Made before the loop asks for real-time scheduling, which its thread would
    inherit: a disk must never go before a deadline.
    """

    def __init__(self, path: str, columns: Sequence[str], again: bool = False) -> None:
        """Makes the file with its header, and the folder if need be. `again` appends to the file
        that a killed life of the same run left, if it did.

        Raises `JournalError`, also if the file exists and this is not `again`, or if it has another
        header.
        """
        self._path = path
        self._waiting: Deque[str] = deque()
        self._rows = 0
        self._overflow = 0
        self._error: Optional[OSError] = None
        self._last = threading.Event()
        try:
            os.makedirs(os.path.dirname(path) or ".", exist_ok=True)
            self._file = open(path, "a+b" if again else "xb", buffering=0)
        except OSError as error:
            raise JournalError(
                f"cannot create {path}: {error.strerror}; give an output folder that is"
                " writable and has no rows of an earlier run"
            ) from None
        self._begin(",".join(columns) + "\n")
        self._thread = threading.Thread(target=self._run, name="journal", daemon=True)
        self._thread.start()

    def _begin(self, header: str) -> None:
        """Writes the header, or ends what is there. Raises `JournalError`."""
        if self._file.tell() == 0:
            self._write(header)
            return
        self._file.seek(0)
        if self._file.read(len(header)) != header.encode("ascii"):
            self._file.close()
            raise JournalError(
                f"cannot go on with {self._path}: its header is not {header.rstrip()}; give the folder"
                " of a run that was killed, or run without `again`"
            )
        self._file.seek(-1, os.SEEK_END)
        if self._file.read(1) != b"\n":
            # Torn by the kill. It stays, but no row is glued to it.
            self._write("\n")

    def record(self, line: str) -> None:
        """Hands over a row, or counts it as lost if too many wait."""
        if len(self._waiting) < CAPACITY:
            self._waiting.append(line)
        else:
            self._overflow += 1

    def finish(self) -> Dict[str, int]:
        """Ends the file with every row that was recorded, and counts them.

        Raises `JournalError` if any write failed since the beginning.
        """
        self._last.set()
        self._thread.join()
        self._file.close()
        if self._error is not None:
            raise JournalError(
                f"cannot write {self._path}: {self._error.strerror}; its rows end early, so"
                " free some space and run again"
            )
        return {"rows": self._rows, "overflow": self._overflow}

    def _run(self) -> None:
        last = False
        while not last and self._error is None:
            # Asked before the rows are taken: those recorded before the end
            # are then surely among them.
            last = self._last.wait(FLUSH_EVERY_S)
            count = len(self._waiting)
            if count:
                self._write("".join([self._waiting.popleft() for _ in range(count)]))
                self._rows += count

    def _write(self, text: str) -> None:
        rest = text.encode("ascii")
        try:
            while rest:
                rest = rest[self._file.write(rest) :]
        except OSError as error:
            self._error = error
