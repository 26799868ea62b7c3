"""The loop: warms up, passes the deadlines, waits for what is under way.

One thread asks the `ControllerEnd` and waits: for the next deadline, for a
message that ended, or a signal to end. The messages are beside it, in an
`Exchange`, and how they ended comes in by an `Inbox`.
"""

from __future__ import annotations

import gc
import os
import signal
import sys
import threading
from time import monotonic_ns, sleep
from typing import Optional

from webloop import grant
from webloop.argument import NAME
from webloop.end import ControllerEnd, Finished, Missed, Send, Sleep
from webloop.exchange import Ended, Exchange, ExchangeError, NoAnswer
from webloop.http_exchange import HttpExchange
from webloop.inbox import Inbox
from webloop.journal import Journal
from webloop.message import Observation, Signal
from webloop.report import Report
from webloop.row import ANSWERED, COLUMNS, FAILED, MessageRow
from webloop.setting import Config, authority
from webloop.websocket_exchange import WebSocketExchange
from webloop.worker import STACK_BYTES

WARM_UP_S = 10
"""How long to wait for a plant that is still starting."""

WARM_UP_PAUSE_S = 0.05
"""How long to leave a plant alone that does not answer yet."""

START_AHEAD_NS = 200_000_000
"""The start, if none is given, is this long after the warm-up."""


class Unreachable(Exception):
    """No answer before the start."""


class _Stop:
    """In the inbox: the request to end."""


def inbox_with_signals() -> Inbox:
    """The loop's inbox, in which SIGTERM and SIGINT arrive from now on."""
    ended = Inbox()
    for number in (signal.SIGTERM, signal.SIGINT):
        signal.signal(number, lambda *_: ended.put(_Stop()))
    return ended


def drive(config: Config, ended: Inbox) -> Report:
    """Runs a controller for its duration, or until it finds in its inbox that
    it is asked to end.

    Raises `Unreachable` or `JournalError`, and what a law of one's own raises.
    A message that fails is a row, not an error.
    """
    threading.stack_size(STACK_BYTES)
    # The journal's thread must not inherit real-time scheduling.
    journal = Journal(os.path.join(config.out, "messages.csv"), COLUMNS, config.again)
    scheduling = grant.ask()
    open_files = grant.raise_open_files()
    exchange: Exchange
    if config.settings.transport == "websocket":
        exchange = WebSocketExchange(config, ended)
    else:
        exchange = HttpExchange(config, ended)

    observation = _warm_up(config, exchange, ended)
    # 0, the output at rest, stands for a plant that was never looked at.
    y: Signal = 0.0 if observation is None else observation.y
    start_ns = config.start_ns
    if start_ns is None:
        start_ns = monotonic_ns() + START_AHEAD_NS
    stop_ns = start_ns + config.duration_ns
    end = ControllerEnd(config.settings, config.law, y, start_ns, stop_ns, config.reference)
    if config.again:
        end.resume(monotonic_ns())
    run = _Run(end, exchange, journal, ended)
    # What was made so far stays: the collector need never look at it again, and
    # what a message makes is gone with it.
    gc.collect()
    gc.freeze()
    try:
        interrupted = observation is None or run.deadlines()
    finally:
        # Also if a law of one's own raised: the rows show how it came to that.
        rows = journal.finish()
    report = Report(
        start_ns=start_ns,
        stop_ns=stop_ns,
        counts=run.end.counts,
        first_failure=run.first_failure,
        interrupted=interrupted,
        rows=rows,
        scheduling=scheduling,
        open_files=open_files,
        transport=config.settings.transport,
        connections=exchange.connections(),
    )
    exchange.close()
    return report


def _warm_up(config: Config, exchange: Exchange, ended: Inbox) -> Optional[Observation]:
    """Waits for the plant, has a connection opened, and looks at the plant.
    None if it was stopped first."""
    give_up_ns = monotonic_ns() + WARM_UP_S * 1_000_000_000
    why = "no attempt ended"

    def attempts() -> None:
        nonlocal why
        while True:
            left_ns = give_up_ns - monotonic_ns()
            if left_ns <= 0:
                return
            try:
                ended.put(exchange.open(min(left_ns, config.settings.timeout_ns)))
                return
            except (ExchangeError, NoAnswer) as error:
                why = str(error)
            sleep(WARM_UP_PAUSE_S)

    # In a thread, so that the signal to end need not wait for an attempt.
    threading.Thread(target=attempts, name="warm-up", daemon=True).start()
    while True:
        left_ns = give_up_ns - monotonic_ns()
        ended.wait(max(left_ns, 0) / 1e9)
        first = ended.take()
        if first is not None:
            return first if isinstance(first, Observation) else None
        if left_ns <= 0:
            raise Unreachable(
                f"no plant answers at http://{authority(config.plant)} after {WARM_UP_S} s:"
                f" {why}; start it, or correct the address"
            )


class _Run:
    """A run of deadlines."""

    def __init__(
        self,
        end: ControllerEnd,
        exchange: Exchange,
        journal: Journal,
        ended: Inbox,
    ) -> None:
        self.end = end
        self.first_failure: Optional[str] = None
        self._exchange = exchange
        self._journal = journal
        self._ended = ended

    def deadlines(self) -> bool:
        """Passes all deadlines and waits for all messages; whether it was asked
        to end first."""
        end, ended = self.end, self._ended
        while True:
            step = end.poll(monotonic_ns())
            timeout_s: Optional[float] = None
            if isinstance(step, Send):
                self._exchange.start(step.command)
                continue
            if isinstance(step, Missed):
                self._record(step.row)
                continue
            if isinstance(step, Sleep):
                timeout_s = max(step.until_ns - monotonic_ns(), 0) / 1e9
            elif isinstance(step, Finished) and end.oldest_under_way() is None:
                return False
            ended.wait(timeout_s)
            # All that has come by now, so that the next command is made from
            # the newest output.
            while True:
                what = ended.take()
                if what is None:
                    break
                if self._take_in(what):
                    return True

    def _take_in(self, what: object) -> bool:
        """Takes in how a message ended; whether it is to stop instead."""
        if not isinstance(what, Ended):
            self._give_up()
            return True
        if what.outcome == ANSWERED and what.answer is not None:
            row = self.end.answered(what.answer, what.t_ns)
        else:
            if what.outcome == FAILED and self.first_failure is None:
                self.first_failure = what.why
                sys.stderr.write(f"{NAME}: message {what.seq} is the first to fail: {what.why}\n")
            row = self.end.lost(what.seq, what.outcome, what.t_ns)
        if row is not None:
            self._record(row)
        return False

    def _give_up(self) -> None:
        """Ends every message under way as failed."""
        now_ns = monotonic_ns()
        while True:
            seq = self.end.oldest_under_way()
            if seq is None:
                return
            row = self.end.lost(seq, FAILED, now_ns)
            if row is not None:
                self._record(row)

    def _record(self, row: MessageRow) -> None:
        self._journal.record(row.line())
