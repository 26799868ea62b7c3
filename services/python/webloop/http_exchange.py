"""Commands over HTTP: one blocking GET a message, by the standard library's
`http.client`, as the paper's client had it.

A lone exchange over loopback takes 0.17 ms with it, and 0.05 ms with a reader
of responses of our own. Even at 1 kHz that is an eighth of a core, and what the
paper's client really costs is part of what is to be seen, so it stays.
"""

from __future__ import annotations

import http.client
import socket
from time import monotonic_ns
from typing import List, Optional, Tuple

from webloop.exchange import Ended, Exchange, ExchangeError, NoAnswer
from webloop.inbox import Inbox
from webloop.message import (
    Answer,
    Command,
    Observation,
    parse_answer_to,
    parse_observation,
)
from webloop.query import MAX_BYTES, InvalidMessage, excerpt
from webloop.row import FAILED
from webloop.session import HEADER, LOST, Session
from webloop.setting import Config
from webloop.worker import Worker

IDLE_NS = 4_000_000_000
"""How long a kept connection may idle. It is below the plant's limit of 5 s:
else a request could meet the close of its connection."""

EXCERPT_CHARS = 200
"""How much of a refusal is repeated."""


class HttpConnection:
    """One connection to the plant, opened when it is needed."""

    def __init__(
        self,
        plant: Tuple[str, int],
        timeout_ns: int,
        keep: bool,
        session: Optional[Session] = None,
    ) -> None:
        self._session = session
        self._client = http.client.HTTPConnection(*plant)
        self._timeout_ns = timeout_ns
        self._keep = keep
        self._used_ns = 0
        self.opened = 0
        """How often it was opened."""

    def command(self, command: Command, mode: str) -> Tuple[Answer, int]:
        """Sends a command; its answer, and when that was there."""
        text, t_ns = self.get(f"/{mode}?{command.query()}", self._timeout_ns)
        try:
            return parse_answer_to(command, mode, text), t_ns
        except InvalidMessage as error:
            raise ExchangeError(str(error)) from None

    def observe(self, timeout_ns: int) -> Observation:
        """Looks at the plant."""
        text, _ = self.get("/state", timeout_ns)
        try:
            return parse_observation(text)
        except InvalidMessage as error:
            raise ExchangeError(str(error)) from None

    def get(self, target: str, timeout_ns: int) -> Tuple[str, int]:
        """The text of a successful response, and when it was there.

        Raises `ExchangeError` or `NoAnswer`; the connection is closed then.
        """
        give_up_ns = monotonic_ns() + timeout_ns
        try:
            self._ready(give_up_ns)
            headers = {}
            if self._session is not None:
                headers[HEADER] = self._session.token(timeout_ns)
            self._client.request("GET", target, headers=headers)
            self._client.sock.settimeout(_left_s(give_up_ns))
            response = self._client.getresponse()
            # A valid body is short. The rest of a longer one is not waited for.
            body = response.read(MAX_BYTES + 1)
            t_ns = monotonic_ns()
        except socket.timeout:
            self.close()
            raise NoAnswer from None
        except (OSError, http.client.HTTPException) as error:
            self.close()
            raise ExchangeError(_why(error)) from None
        self._used_ns = t_ns
        if not (self._keep and response.isclosed()):
            self.close()
        # What is not UTF-8 is no number either, and is refused with its field.
        text = body.decode("utf-8", "replace")
        if response.status != 200:
            if response.status == LOST and self._session is not None:
                self._session.forget(headers[HEADER])
            said = excerpt(text.rstrip(), EXCERPT_CHARS)
            raise ExchangeError(f"{response.status} {response.reason}: {said}")
        return text, t_ns

    def close(self) -> None:
        """Closes the connection; the next message opens it again."""
        self._client.close()

    def _ready(self, give_up_ns: int) -> None:
        client = self._client
        if client.sock is not None and monotonic_ns() - self._used_ns > IDLE_NS:
            client.close()
        if client.sock is None:
            client.timeout = _left_s(give_up_ns)
            # It sets TCP_NODELAY by itself.
            client.connect()
            self.opened += 1
        client.sock.settimeout(_left_s(give_up_ns))


class HttpExchange(Exchange):
    """Blocking requests, each on a worker of its own that keeps its connection.

    There are as many workers as were needed at one time. The one that became
    idle last goes first, so that few connections are in use and those are warm.
    """

    def __init__(self, config: Config, ended: Inbox) -> None:
        super().__init__(ended)
        self._config = config
        self._session = Session(config.plant) if config.claim else None
        self._workers: List[Worker] = []
        self._idle: List[Worker] = []

    def open(self, timeout_ns: int) -> Observation:
        connection = self._connection()
        observation = connection.observe(timeout_ns)
        self._idle.append(self._worker(connection))
        return observation

    def start(self, command: Command) -> None:
        try:
            worker = self._idle.pop() if self._idle else self._worker(self._connection())
        except RuntimeError as error:
            why = f"no thread for the request: {error}"
            self.ended.put(Ended(command.seq, monotonic_ns(), FAILED, why=why))
            return
        worker.give(command)

    def close(self) -> None:
        for worker in self._workers:
            worker.end()
        if self._session is not None:
            self._session.end()

    def connections(self) -> int:
        return sum(worker.connection.opened for worker in self._workers)

    def _connection(self) -> HttpConnection:
        config = self._config
        return HttpConnection(
            config.plant,
            config.settings.timeout_ns,
            config.settings.connection == "keep",
            self._session,
        )

    def _worker(self, connection: HttpConnection) -> Worker:
        worker = Worker(connection, self._config.settings.mode, self._idle, self.ended)
        self._workers.append(worker)
        return worker


def _left_s(give_up_ns: int) -> float:
    left_ns = give_up_ns - monotonic_ns()
    if left_ns <= 0:
        raise socket.timeout
    return left_ns / 1e9


def _why(error: Exception) -> str:
    return getattr(error, "strerror", None) or str(error) or type(error).__name__
