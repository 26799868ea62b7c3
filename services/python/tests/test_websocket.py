"""The WebSocket's client against a small plant of these tests, over loopback."""

import base64
import hashlib
import socket
import threading
import time
import unittest
from queue import SimpleQueue

from test_frame import served
from test_inbox import within

from webloop.argument import read
from webloop.exchange import ExchangeError
from webloop.frame import CLOSE, PING, TEXT, close_payload
from webloop.inbox import Inbox
from webloop.message import Command
from webloop.websocket_exchange import WebSocketExchange

PATIENCE_S = 20
"""How long a busy machine may take for anything here."""


class Plant:
    """Answers `/state`, opens sockets, and leaves what is in them to a script."""

    def __init__(self, script, accept=None):
        self._script = script
        self._accept = accept
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self.targets = []
        threading.Thread(target=self._run, daemon=True).start()

    def close(self):
        self._listener.close()

    def _run(self):
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection):
        with connection:
            head = b""
            while b"\r\n\r\n" not in head:
                head += connection.recv(4096)
            lines = head.decode().split("\r\n")
            target = lines[0].split(" ")[1]
            if target == "/state":
                body = b"t_ns=1&tick=1&y=0.25&u=0.0"
                connection.sendall(b"HTTP/1.1 200 OK\r\nContent-Length: %d\r\n\r\n" % len(body) + body)
                return
            self.targets.append(target)
            key = next(line.split(": ")[1] for line in lines if line.startswith("Sec-WebSocket-Key"))
            digest = hashlib.sha1((key + "258EAFA5-E914-47DA-95CA-C5AB0DC85B11").encode()).digest()
            accept = self._accept or base64.b64encode(digest).decode()
            connection.sendall(
                b"HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\n"
                b"Connection: Upgrade\r\nSec-WebSocket-Accept: " + accept.encode() + b"\r\n\r\n"
            )
            try:
                self._script(connection)
            except OSError:
                pass


def received(connection):
    """A client's frame: its opcode and payload, unmasked here byte by byte."""

    def exactly(count):
        data = b""
        while len(data) < count:
            piece = connection.recv(count - len(data))
            if not piece:
                raise OSError("hung up")
            data += piece
        return data

    first, second = exactly(2)
    assert second & 0x80, "a client's frame is masked"
    assert second & 0x7F < 126, "what the controller sends is short"
    mask = exactly(4)
    payload = exactly(second & 0x7F)
    return first & 0x0F, bytes(byte ^ mask[at % 4] for at, byte in enumerate(payload))


def answer_to(payload):
    seq = dict(pair.split("=") for pair in payload.decode().split("&"))["seq"]
    return served(TEXT, f"seq={seq}&t_arrive_ns=9".encode())


class Exchanges(unittest.TestCase):
    def opened(self, script, timeout="20s", accept=None):
        plant = Plant(script, accept)
        self.addCleanup(plant.close)
        line = f"--plant 127.0.0.1:{plant.port} --transport websocket --mode open --timeout {timeout}"
        self.ended = Inbox()
        exchange = WebSocketExchange(read(line.split()), self.ended)
        self.addCleanup(exchange.close)
        return plant, exchange

    def open(self, script, timeout="20s"):
        plant, exchange = self.opened(script, timeout)
        observation = exchange.open(PATIENCE_S * 10**9)
        self.assertEqual(observation.y, 0.25)
        self.assertEqual(plant.targets, ["/socket?mode=open"])
        return exchange

    def start(self, exchange, *numbers):
        for seq in numbers:
            exchange.start(Command(seq, time.monotonic_ns(), 0.5))

    def end(self):
        return within(self.ended, PATIENCE_S)

    def test_answers_find_their_commands_in_any_order_and_pieces(self):
        pongs = SimpleQueue()

        def script(connection):
            answers = [answer_to(received(connection)[1]) for _ in range(3)]
            connection.sendall(served(PING, b"there?"))
            pongs.put(received(connection))
            for byte in b"".join(reversed(answers)):
                connection.sendall(bytes((byte,)))
            received(connection)

        exchange = self.open(script)
        self.start(exchange, 0, 1, 2)
        ended = [self.end() for _ in range(3)]
        self.assertEqual([(end.seq, end.outcome) for end in ended], [(2, "answered"), (1, "answered"), (0, "answered")])
        self.assertEqual(ended[0].answer.t_arrive_ns, 9)
        self.assertEqual(pongs.get(timeout=PATIENCE_S), (0xA, b"there?"))

    def test_a_close_ends_what_is_under_way_with_its_reason_and_the_socket_opens_again(self):
        def script(connection):
            _, payload = received(connection)
            if b"seq=0&" in payload:
                received(connection)
                connection.sendall(served(CLOSE, close_payload(1008, "field `u` is missing")))
            else:
                connection.sendall(answer_to(payload))
            received(connection)

        exchange = self.open(script)
        self.start(exchange, 0, 1)
        for seq in (0, 1):
            end = self.end()
            self.assertEqual((end.seq, end.outcome), (seq, "failed"))
            self.assertIn("1008 field `u` is missing", end.why)
        # Messages fail at once until the socket is open again.
        give_up = time.monotonic() + PATIENCE_S
        outcome = "failed"
        seq = 1
        while outcome == "failed" and time.monotonic() < give_up:
            seq += 1
            self.start(exchange, seq)
            outcome = self.end().outcome
            time.sleep(0.01)
        self.assertEqual(outcome, "answered")

    def test_silence_is_a_time_out_and_a_late_answer_is_nobody_s(self):
        def script(connection):
            first = received(connection)[1]
            second = received(connection)[1]
            connection.sendall(answer_to(first) + answer_to(second))
            received(connection)

        exchange = self.open(script, timeout="100ms")
        self.start(exchange, 0)
        end = self.end()
        self.assertEqual((end.seq, end.outcome), (0, "timeout"))
        # This one was sent late enough for the answer to come.
        exchange.start(Command(1, time.monotonic_ns() + PATIENCE_S * 10**9, 0.5))
        end = self.end()
        self.assertEqual((end.seq, end.outcome), (1, "answered"))

    def test_an_answer_that_cannot_be_read_breaks_the_socket(self):
        def script(connection):
            received(connection)
            connection.sendall(served(TEXT, b"seq=0&t_arrive_ns=soon"))
            received(connection)

        exchange = self.open(script)
        self.start(exchange, 0)
        end = self.end()
        self.assertEqual((end.seq, end.outcome), (0, "failed"))
        self.assertIn("`soon`", end.why)

    def test_an_opening_that_answers_another_key_is_none(self):
        _, exchange = self.opened(lambda _: None, accept="AAAA")
        with self.assertRaisesRegex(ExchangeError, "another key"):
            exchange.open(PATIENCE_S * 10**9)


if __name__ == "__main__":
    unittest.main()
