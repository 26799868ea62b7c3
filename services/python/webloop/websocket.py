"""One WebSocket to the plant: its opening, text messages, ping and close.

RFC 6455 by hand on a socket, for the standard library has no client. Sending
and receiving may be done by two threads at once.
"""

from __future__ import annotations

import base64
import hashlib
import math
import os
import select
import socket
import threading
from time import monotonic_ns
from typing import List, Tuple

from webloop import frame
from webloop.exchange import ExchangeError, NoAnswer
from webloop.query import MAX_BYTES, excerpt
from webloop.setting import authority

_GUID = b"258EAFA5-E914-47DA-95CA-C5AB0DC85B11"
"""What both ends append to the key (RFC 6455, section 1.3)."""

_MAX_HEAD_BYTES = 16 * 1024
"""The longest head of the plant's response to the opening."""

_RECEIVE_BYTES = 64 * 1024


class Closed(Exception):
    """The connection is gone; its text says why."""


class WebSocket:
    """An open connection."""

    def __init__(self, plant: Tuple[str, int], target: str, timeout_ns: int) -> None:
        """Connects and opens, within the timeout.

        Raises `ExchangeError` or `NoAnswer`.
        """
        give_up_ns = monotonic_ns() + timeout_ns
        try:
            self._socket = socket.create_connection(plant, _left_s(give_up_ns))
        except socket.timeout:
            raise NoAnswer from None
        except OSError as error:
            raise ExchangeError(error.strerror or str(error)) from None
        self._decoder = frame.Decoder(MAX_BYTES)
        # A pong must not get between the two parts of a command.
        self._sending = threading.Lock()
        try:
            self._socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
            self._early = self._open(plant, target, give_up_ns)
            self._socket.settimeout(None)
        except BaseException:
            self._socket.close()
            raise
        self._poll = select.poll()
        self._poll.register(self._socket, select.POLLIN)

    def send(self, text: str) -> None:
        """Sends a text message, without waiting for room.

        Raises `Closed`, or BlockingIOError where nothing was sent for want of
        room, and the connection is as before.
        """
        self._send(frame.TEXT, text.encode("utf-8"))

    def receive(self, timeout_ns: int) -> List[str]:
        """The text messages that come first; empty if none comes in time.

        Answers pings. Raises `Closed`.
        """
        if self._early:
            data, self._early = self._early, b""
        else:
            if not self._poll.poll(math.ceil(max(timeout_ns, 0) / 1e6)):
                return []
            try:
                data = self._socket.recv(_RECEIVE_BYTES)
            except OSError as error:
                raise Closed(error.strerror or str(error)) from None
            if not data:
                raise Closed("the plant hung up without closing the socket")
        try:
            return [
                _text(message)
                for message in self._decoder.feed(data)
                if not self._controlled(message)
            ]
        except frame.FrameError as error:
            self.close(error.code, str(error))
            raise Closed(f"the plant broke the WebSocket protocol: {error}") from None

    def close(self, code: int = frame.NORMAL, reason: str = "") -> None:
        """Says goodbye and hangs up, without waiting for the plant to do so.
        The receiving thread then finds it closed, and is to `release` it."""
        try:
            self._send(frame.CLOSE, frame.close_payload(code, reason))
        except (Closed, BlockingIOError):
            pass
        try:
            # Unlike close alone, it ends a wait of another thread.
            self._socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass

    def release(self) -> None:
        """Gives the socket back to the system."""
        # Not while the other thread sends: its number may soon be another's.
        with self._sending:
            self._socket.close()

    def _controlled(self, message: frame.Message) -> bool:
        """Deals with a control frame; whether it was one."""
        if message.opcode == frame.PING:
            try:
                self._send(frame.PONG, message.payload)
            except BlockingIOError:
                pass
        elif message.opcode == frame.CLOSE:
            self.close()
            said = excerpt(frame.close_reason(message.payload), frame.MAX_CONTROL_BYTES)
            raise Closed(f"the plant closed the socket: {said}")
        return message.opcode >= frame.CLOSE

    def _send(self, opcode: int, payload: bytes) -> None:
        data = frame.encode(opcode, payload, os.urandom(4))
        with self._sending:
            try:
                sent = self._socket.send(data, socket.MSG_DONTWAIT)
                if sent < len(data):
                    # Half a frame cannot stay so.
                    self._socket.sendall(data[sent:])
            except BlockingIOError:
                raise
            except OSError as error:
                raise Closed(error.strerror or str(error)) from None

    def _open(self, plant: Tuple[str, int], target: str, give_up_ns: int) -> bytes:
        """Asks for the upgrade, and checks the response; what came behind it."""
        key = base64.b64encode(os.urandom(16))
        request = (
            f"GET {target} HTTP/1.1\r\nHost: {authority(plant)}\r\n"
            "Upgrade: websocket\r\nConnection: Upgrade\r\n"
            f"Sec-WebSocket-Key: {key.decode('ascii')}\r\nSec-WebSocket-Version: 13\r\n\r\n"
        )
        head = b""
        try:
            self._socket.sendall(request.encode("ascii"))
            while b"\r\n\r\n" not in head:
                if len(head) > _MAX_HEAD_BYTES:
                    raise ExchangeError("the answer to the handshake does not end")
                self._socket.settimeout(_left_s(give_up_ns))
                data = self._socket.recv(_RECEIVE_BYTES)
                if not data:
                    raise ExchangeError("the plant hung up during the handshake")
                head += data
        except socket.timeout:
            raise NoAnswer from None
        except OSError as error:
            raise ExchangeError(error.strerror or str(error)) from None
        head, _, early = head.partition(b"\r\n\r\n")
        _check(head, key, early)
        return early


def _check(head: bytes, key: bytes, body: bytes) -> None:
    """Whether a response's head opens the socket that was asked for with `key`."""
    status, *lines = head.decode("latin-1").split("\r\n")
    words = status.split(" ", 2)
    if len(words) < 2 or not words[0].startswith("HTTP/1."):
        raise ExchangeError(f"the answer to the handshake is not HTTP: `{excerpt(status)}`")
    if words[1] != "101":
        said = excerpt(body.decode("utf-8", "replace").rstrip(), 200)
        raise ExchangeError(f"{' '.join(words[1:])}: {said}")
    headers = {}
    for line in lines:
        name, _, value = line.partition(":")
        headers[name.strip().lower()] = value.strip()
    accept = base64.b64encode(hashlib.sha1(key + _GUID).digest()).decode("ascii")
    connection = [word.strip().lower() for word in headers.get("connection", "").split(",")]
    if headers.get("upgrade", "").lower() != "websocket" or "upgrade" not in connection:
        raise ExchangeError("the answer to the handshake upgrades to another protocol")
    if headers.get("sec-websocket-accept") != accept:
        raise ExchangeError("the response to the opening belongs to another key")


def _text(message: frame.Message) -> str:
    if message.opcode != frame.TEXT:
        raise frame.FrameError(frame.UNSUPPORTED, "the message is not a text")
    try:
        return message.payload.decode("utf-8")
    except UnicodeDecodeError:
        raise frame.FrameError(frame.INVALID, "the text is not UTF-8") from None


def _left_s(give_up_ns: int) -> float:
    left_ns = give_up_ns - monotonic_ns()
    if left_ns <= 0:
        raise NoAnswer
    return left_ns / 1e9
