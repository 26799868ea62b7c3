"""Commands over one WebSocket: the loop's thread sends, another receives.

Answers find their commands by their numbers. The receiving thread also ends
messages whose time is over, and opens the socket again when it broke; until it
has, messages fail at once.
"""

from __future__ import annotations

import threading
from time import monotonic_ns, sleep
from typing import Dict, List, Optional

from webloop.exchange import Ended, Exchange, ExchangeError, NoAnswer
from webloop.frame import INVALID
from webloop.http_exchange import HttpConnection
from webloop.inbox import Inbox
from webloop.message import Command, Observation, parse_answer
from webloop.query import InvalidMessage
from webloop.row import ANSWERED, FAILED, TIMEOUT
from webloop.session import Session
from webloop.setting import Config
from webloop.websocket import Closed, WebSocket

REOPEN_PAUSE_S = 0.1
"""How long to leave a plant alone that did not open the socket."""


class WebSocketExchange(Exchange):
    """All messages over one socket."""

    def __init__(self, config: Config, ended: Inbox) -> None:
        super().__init__(ended)
        self._config = config
        self._mode = config.settings.mode
        self._target = f"/socket?mode={self._mode}"
        self._session = Session(config.plant) if config.claim else None
        self._socket: Optional[WebSocket] = None
        self._broken = "it was never open"
        self._closing = False
        self._connections = 0
        # When each message under way is given up, by seq, and so in order.
        self._give_up_ns: Dict[int, int] = {}
        # Both threads take messages out; each ends but once.
        self._lock = threading.Lock()

    def open(self, timeout_ns: int) -> Observation:
        look = HttpConnection(self._config.plant, timeout_ns, keep=False)
        observation = look.observe(timeout_ns)
        self._connections += look.opened
        socket = self._opened(timeout_ns)
        self._socket = socket
        threading.Thread(
            target=self._run, args=(socket,), name="receiver", daemon=True
        ).start()
        return observation

    def start(self, command: Command) -> None:
        socket = self._socket
        if socket is None:
            self._end([command.seq], FAILED, self._broken)
            return
        with self._lock:
            self._give_up_ns[command.seq] = command.t_send_ns + self._config.settings.timeout_ns
        try:
            socket.send(command.query())
        except BlockingIOError:
            self._end(self._taken(command.seq), FAILED, "the socket's buffer is full")
        except Closed as error:
            self._end(self._taken(command.seq), FAILED, str(error))
        if self._socket is not socket:
            # It broke meanwhile, and the receiver may not have seen this one.
            self._end(self._taken(command.seq), FAILED, self._broken)

    def close(self) -> None:
        self._closing = True
        if self._socket is not None:
            self._socket.close()
        if self._session is not None:
            self._session.end()

    def connections(self) -> int:
        return self._connections

    def _opened(self, timeout_ns: int) -> WebSocket:
        target = self._target
        if self._session is not None:
            token = self._session.token(timeout_ns)
            target += f"&session={token}"
        try:
            socket = WebSocket(self._config.plant, target, timeout_ns)
        except ExchangeError:
            # The plant may have ended the session.
            if self._session is not None:
                self._session.forget(token)
            raise
        self._connections += 1
        return socket

    def _run(self, socket: Optional[WebSocket]) -> None:
        """The receiving thread, from the first opening to the end."""
        while socket is not None:
            self._broken = self._receive(socket)
            self._socket = None
            socket.release()
            with self._lock:
                under_way = list(self._give_up_ns)
                self._give_up_ns.clear()
            self._end(under_way, FAILED, self._broken)
            socket = self._reopened()

    def _reopened(self) -> Optional[WebSocket]:
        """The socket, open again; none if it is to stay closed."""
        while True:
            sleep(REOPEN_PAUSE_S)
            if self._closing:
                return None
            try:
                socket = self._opened(self._config.settings.timeout_ns)
            except (ExchangeError, NoAnswer) as error:
                self._broken = f"the socket cannot be opened again: {error}"
                continue
            self._socket = socket
            if self._closing:
                # `close` may have looked before it was there.
                socket.close()
            return socket

    def _receive(self, socket: WebSocket) -> str:
        """Receives until the socket breaks; why it did."""
        while True:
            try:
                texts = socket.receive(self._wait_ns())
                t_ns = monotonic_ns()
                for text in texts:
                    answer = parse_answer(self._mode, text)
                    # One that is not under way was given up.
                    if self._taken(answer.seq):
                        self.ended.put(Ended(answer.seq, t_ns, ANSWERED, answer))
            except Closed as error:
                return str(error)
            except InvalidMessage as error:
                # It is not known whose answer it was.
                socket.close(INVALID, str(error))
                return str(error)
            self._give_up()

    def _wait_ns(self) -> int:
        """How long to wait for a message: to the first that is to be given up.
        Those that are sent meanwhile are given up later than that."""
        with self._lock:
            first_ns = next(iter(self._give_up_ns.values()), None)
        if first_ns is None:
            return self._config.settings.timeout_ns
        return first_ns - monotonic_ns()

    def _give_up(self) -> None:
        """Ends the messages whose time is over."""
        now_ns = monotonic_ns()
        late: List[int] = []
        with self._lock:
            for seq, give_up_ns in self._give_up_ns.items():
                if give_up_ns > now_ns:
                    break
                late.append(seq)
            for seq in late:
                del self._give_up_ns[seq]
        self._end(late, TIMEOUT, "")

    def _taken(self, seq: int) -> List[int]:
        """Takes a message off those under way: its number, if it was."""
        with self._lock:
            return [] if self._give_up_ns.pop(seq, None) is None else [seq]

    def _end(self, numbers: List[int], outcome: str, why: str) -> None:
        t_ns = monotonic_ns()
        for seq in numbers:
            self.ended.put(Ended(seq, t_ns, outcome, None, why))
