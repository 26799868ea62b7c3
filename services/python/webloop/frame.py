"""Frames of a WebSocket as bytes (RFC 6455, section 5), from the client's side.

What a client sends is masked, and what it receives is not. No socket here; the
opening and closing of a connection is in `websocket`.
"""

from __future__ import annotations

from typing import Iterator, NamedTuple, Optional, Tuple

CONTINUATION = 0x0
TEXT = 0x1
BINARY = 0x2
CLOSE = 0x8
PING = 0x9
PONG = 0xA

NORMAL = 1000
"""Close code: the purpose is fulfilled."""
PROTOCOL_ERROR = 1002
"""Close code: the other end broke the protocol."""
UNSUPPORTED = 1003
"""Close code: a kind of message that this end does not take."""
INVALID = 1007
"""Close code: a text that is not UTF-8."""
TOO_BIG = 1009
"""Close code: a message that is longer than this end takes."""

MAX_CONTROL_BYTES = 125
"""The longest payload of a close, a ping or a pong."""


class FrameError(Exception):
    """The other end sent what it must not."""

    def __init__(self, code: int, why: str) -> None:
        super().__init__(why)
        self.code = code
        """The code to close the connection with."""


class Message(NamedTuple):
    """A whole message, or a control frame between the frames of one."""

    opcode: int
    """TEXT, BINARY, CLOSE, PING or PONG."""
    payload: bytes


def encode(opcode: int, payload: bytes, mask: bytes) -> bytes:
    """A whole message in one frame; `mask` is four random bytes."""
    length = len(payload)
    if length < 126:
        head = bytes((0x80 | opcode, 0x80 | length))
    elif length < 1 << 16:
        head = bytes((0x80 | opcode, 0x80 | 126)) + length.to_bytes(2, "big")
    else:
        head = bytes((0x80 | opcode, 0x80 | 127)) + length.to_bytes(8, "big")
    return head + mask + _masked(payload, mask)


def close_payload(code: int, reason: str = "") -> bytes:
    """The payload of a close frame. A long reason is cut, at a character's end."""
    text = reason.encode("utf-8")[: MAX_CONTROL_BYTES - 2]
    return code.to_bytes(2, "big") + text.decode("utf-8", "ignore").encode("utf-8")


def close_reason(payload: bytes) -> str:
    """What a close frame says, for people."""
    if len(payload) < 2:
        return "without a code"
    code = int.from_bytes(payload[:2], "big")
    return f"{code} {payload[2:].decode('utf-8', 'replace')}".rstrip()


def _masked(payload: bytes, mask: bytes) -> bytes:
    length = len(payload)
    # One exclusive or of two long numbers: a loop over bytes costs more than
    # all the rest of a message.
    long_mask = (mask * (length // 4 + 1))[:length]
    masked = int.from_bytes(payload, "big") ^ int.from_bytes(long_mask, "big")
    return masked.to_bytes(length, "big")


class Decoder:
    """Messages from the bytes of a server, in whatever pieces they come."""

    def __init__(self, max_bytes: int) -> None:
        self._max_bytes = max_bytes
        self._buffer = bytearray()
        # The message whose frames are coming, if its first one has.
        self._opcode = CONTINUATION
        self._parts = bytearray()

    def feed(self, data: bytes) -> Iterator[Message]:
        """Takes in bytes, and gives the messages that are whole with them.

        Raises `FrameError`, after which nothing more can be read.
        """
        self._buffer += data
        while True:
            frame = self._frame()
            if frame is None:
                return
            final, opcode, payload = frame
            if opcode >= CLOSE:
                yield Message(opcode, payload)
                continue
            if (opcode == CONTINUATION) != (self._opcode != CONTINUATION):
                raise FrameError(PROTOCOL_ERROR, "the frames of two messages are mixed")
            self._opcode = self._opcode or opcode
            self._parts += payload
            if len(self._parts) > self._max_bytes:
                raise self._too_big(len(self._parts))
            if final:
                message = Message(self._opcode, bytes(self._parts))
                self._opcode = CONTINUATION
                self._parts.clear()
                yield message

    def _frame(self) -> Optional[Tuple[bool, int, bytes]]:
        """One frame off the buffer: whether it is final, its opcode, its
        payload. None if it is not whole yet."""
        buffer = self._buffer
        if len(buffer) < 2:
            return None
        first, second = buffer[0], buffer[1]
        final, opcode, length = bool(first & 0x80), first & 0x0F, second & 0x7F
        if first & 0x70:
            raise FrameError(PROTOCOL_ERROR, "reserved bits are set")
        if second & 0x80:
            raise FrameError(PROTOCOL_ERROR, "the frame is masked; only a client's may be")
        if opcode not in (CONTINUATION, TEXT, BINARY, CLOSE, PING, PONG):
            raise FrameError(PROTOCOL_ERROR, f"opcode {opcode} does not exist")
        if opcode >= CLOSE and (not final or length > MAX_CONTROL_BYTES):
            raise FrameError(PROTOCOL_ERROR, "the control frame is too long or in parts")
        start = 2
        if length >= 126:
            start += 2 if length == 126 else 8
            if len(buffer) < start:
                return None
            length = int.from_bytes(buffer[2:start], "big")
        if length > self._max_bytes and opcode < CLOSE:
            # Not waited for: it could be any number of bytes.
            raise self._too_big(length)
        if len(buffer) < start + length:
            return None
        payload = bytes(buffer[start : start + length])
        del buffer[: start + length]
        return final, opcode, payload

    def _too_big(self, length: int) -> FrameError:
        return FrameError(
            TOO_BIG, f"message of {length} bytes: it has at most {self._max_bytes}"
        )
