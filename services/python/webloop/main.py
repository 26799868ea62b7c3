"""What the program does: reads its arguments, runs, leaves its report."""

from __future__ import annotations

import sys
from typing import Sequence

from webloop import argument
from webloop.drive import Unreachable, drive, inbox_with_signals
from webloop.journal import JournalError
from webloop.report import ReportError
from webloop.setting import Config, authority

FINE = 0
FAILED = 1
INTERRUPTED = 130


def main(arguments: Sequence[str]) -> int:
    """Runs the controller, and gives the exit code."""
    return run(argument.read(arguments), says_ready=True)


def run(config: Config, says_ready: bool) -> int:
    """Runs a controller, and gives the exit code; `says_ready` if someone waits for that line."""
    # Before it reports that it is ready, and may get the signal to end.
    ended = inbox_with_signals()
    if says_ready:
        # Its arguments are fine; the plant it waits for by itself. That nobody
        # reads the line is no error.
        try:
            print(f"ready http://{authority(config.plant)}", flush=True)
        except OSError:
            pass
    try:
        report = drive(config, ended)
        report.leave(config.out)
    except (Unreachable, JournalError, ReportError) as error:
        sys.stderr.write(f"{argument.NAME}: {error}\n")
        return FAILED
    return INTERRUPTED if report.interrupted else FINE
