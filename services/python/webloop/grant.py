"""Asking the kernel for real-time scheduling and many sockets, and what it granted.

The words are those of the crate `clock`. It is best effort, since many machines
and most containers refuse it: a run goes on without, and its report says so.
"""

from __future__ import annotations

import os
import resource
import threading
from typing import Dict, List

FIFO_PRIORITY = 45
"""Just below the plant's ticker, as the native controller."""


def ask() -> Dict[str, object]:
    """Asks for the calling thread: the least timer slack, and SCHED_FIFO.

    Never fails; threads that it starts later inherit what it gets.
    """
    refused: List[str] = []
    slack_ns = _least_slack(refused)
    priority = 0
    policy = "other"
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(FIFO_PRIORITY))
    except (AttributeError, OSError) as error:
        why = getattr(error, "strerror", None) or "this system has no such call"
        refused.append(
            f"SCHED_FIFO {FIFO_PRIORITY}: {why} (it needs CAP_SYS_NICE or an rtprio limit)"
        )
    else:
        if os.sched_getscheduler(0) == os.SCHED_FIFO:
            policy = "fifo"
            priority = os.sched_getparam(0).sched_priority
    return {
        "asked_priority": FIFO_PRIORITY,
        "policy": policy,
        "priority": priority,
        "slack_ns": slack_ns,
        "refused": "; ".join(refused) or None,
    }


def _least_slack(refused: List[str]) -> int:
    """How late the kernel may let timers be, to gather them. Python has no call
    for it, but Linux has a file."""
    path = f"/proc/{threading.get_native_id()}/timerslack_ns"
    try:
        with open(path, "w", encoding="ascii") as file:
            file.write("1")
    except OSError as error:
        refused.append(f"timer slack of 1 ns: {error.strerror}")
    try:
        with open(path, encoding="ascii") as file:
            return int(file.read())
    except (OSError, ValueError):
        return 0


def raise_open_files() -> int:
    """Raises the limit on open files to the most that the process may give
    itself, and returns it. Best effort: if that is refused, the limit stays."""
    _, most = resource.getrlimit(resource.RLIMIT_NOFILE)
    try:
        resource.setrlimit(resource.RLIMIT_NOFILE, (most, most))
    except (OSError, ValueError):
        pass
    limit, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return 2**64 - 1 if limit == resource.RLIM_INFINITY else limit
