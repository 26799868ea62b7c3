"""Requests against a small plant of these tests: how each message ends."""

import socket
import threading
import time
import unittest

from test_inbox import within

from webloop.argument import read
from webloop.http_exchange import HttpExchange
from webloop.inbox import Inbox
from webloop.message import Command

PATIENCE_S = 20
"""How long a busy machine may take for anything here."""


def response(body, status="200 OK"):
    return f"HTTP/1.1 {status}\r\nContent-Length: {len(body)}\r\n\r\n{body}".encode()


class Plant:
    """Answers `/state`, and each command as a script has it for its number:
    bytes to send, b"" to hang up, None to stay silent."""

    def __init__(self, script):
        self._script = script
        self._listener = socket.create_server(("127.0.0.1", 0))
        self.port = self._listener.getsockname()[1]
        self.accepted = 0
        threading.Thread(target=self._run, daemon=True).start()

    def close(self):
        self._listener.close()

    def _run(self):
        while True:
            try:
                connection, _ = self._listener.accept()
            except OSError:
                return
            self.accepted += 1
            threading.Thread(target=self._serve, args=(connection,), daemon=True).start()

    def _serve(self, connection):
        with connection, connection.makefile("rb") as requests:
            for line in requests:
                if not line.startswith(b"GET "):
                    continue
                target = line.split(b" ")[1].decode()
                if target == "/state":
                    connection.sendall(response("t_ns=1&tick=1&y=0.25&u=0.0"))
                    continue
                seq = int(target.split("seq=")[1].split("&")[0])
                what = self._script[seq]
                if what:
                    connection.sendall(what)
                elif what is not None:
                    return


class Exchanges(unittest.TestCase):
    def open(self, script, options=""):
        plant = Plant(script)
        self.addCleanup(plant.close)
        line = f"--plant 127.0.0.1:{plant.port} --mode open {options}"
        self.ended = Inbox()
        exchange = HttpExchange(read(line.split()), self.ended)
        self.addCleanup(exchange.close)
        self.assertEqual(exchange.open(PATIENCE_S * 10**9).y, 0.25)
        return plant, exchange

    def outcome(self, exchange, seq):
        exchange.start(Command(seq, time.monotonic_ns(), 0.5))
        end = within(self.ended, PATIENCE_S)
        self.assertEqual(end.seq, seq)
        return end.outcome, end.why

    def test_each_message_ends_as_its_answer_is_and_the_next_one_has_its_chance(self):
        script = [
            response("seq=0&t_arrive_ns=9"),
            b"",
            response("seq=2&t_arrive_ns=9"),
            response("seq=2&t_arrive_ns=9"),
            response("no such field\n", "400 Bad Request"),
            response("x" * 5000),
            b"SSH-2.0-nonsense\r\n",
            response("seq=7&t_arrive_ns=9"),
        ]
        _, exchange = self.open(script)
        for seq, (outcome, why) in enumerate(
            [
                ("answered", ""),
                ("failed", "without response"),
                ("answered", ""),
                ("failed", "the answer is to command 2, the command was 3"),
                ("failed", "400 Bad Request: no such field"),
                ("failed", "a message has at most 1024"),
                ("failed", "SSH-2.0"),
                ("answered", ""),
            ]
        ):
            ended, said = self.outcome(exchange, seq)
            self.assertEqual(ended, outcome, said)
            self.assertIn(why, said)

    def test_silence_is_a_time_out(self):
        _, exchange = self.open([None, response("seq=1&t_arrive_ns=9")], "--timeout 100ms")
        self.assertEqual(self.outcome(exchange, 0), ("timeout", ""))

    def test_messages_at_one_time_have_a_connection_each_and_one_at_a_time_share_one(self):
        silent = [None] * 3
        plant, exchange = self.open(silent)
        for seq in range(3):
            exchange.start(Command(seq, time.monotonic_ns(), 0.5))
        give_up = time.monotonic() + PATIENCE_S
        while plant.accepted < 3 and time.monotonic() < give_up:
            time.sleep(0.01)
        self.assertEqual(plant.accepted, 3)

        answers = [response(f"seq={seq}&t_arrive_ns=9") for seq in range(5)]
        for options, accepted in [("", 1), ("--connection new", 6)]:
            plant, exchange = self.open(answers, options)
            for seq in range(5):
                self.assertEqual(self.outcome(exchange, seq), ("answered", ""))
            self.assertEqual((plant.accepted, exchange.connections()), (accepted, accepted))


if __name__ == "__main__":
    unittest.main()
