"""What a controller tells when it has ended: `controller.json`.

The fields that the native controller has too come first, under its words; the
others say which Python it was, and how it sent.
"""

from __future__ import annotations

import json
import os
import platform
from typing import Dict, NamedTuple, Optional

from webloop.end import Counts


class ReportError(Exception):
    """The report could not be written."""


class Report(NamedTuple):
    """What a controller tells."""

    start_ns: int
    """The first deadline, on the run's clock."""
    stop_ns: int
    """Where the deadlines ended."""
    counts: Counts
    """What became of the deadlines."""
    first_failure: Optional[str]
    """Why the first message failed that did."""
    interrupted: bool
    """Whether it was stopped before its time."""
    rows: Dict[str, int]
    """Rows of messages.csv, and those lost."""
    scheduling: Dict[str, object]
    """What the kernel granted to its threads."""
    open_files: int
    """Files and sockets that may be open."""
    transport: str
    """http or websocket."""
    connections: int
    """Connections opened, those of the warm-up among them."""

    def fields(self) -> Dict[str, object]:
        """The report as its file has it."""
        return {
            "start_ns": self.start_ns,
            "stop_ns": self.stop_ns,
            "counts": self.counts.words(),
            "first_failure": self.first_failure,
            "interrupted": self.interrupted,
            "rows": self.rows,
            "granted": {"controller": self.scheduling, "open_files": self.open_files},
            "client": "python",
            "python": platform.python_version(),
            "implementation": platform.python_implementation(),
            "transport": self.transport,
            "connections": self.connections,
        }

    def leave(self, folder: str) -> None:
        """Writes it into a folder: the whole file or none.

        Raises `ReportError`.
        """
        path = os.path.join(folder, "controller.json")
        partial = os.path.join(folder, "controller.partial")
        try:
            with open(partial, "w", encoding="utf-8") as file:
                json.dump(self.fields(), file, indent=2)
                file.write("\n")
                file.flush()
                os.fsync(file.fileno())
            os.replace(partial, path)
        except OSError as error:
            raise ReportError(
                f"cannot write {path}: {error.strerror}; give an output folder that is writable"
                " and has some space"
            ) from None
