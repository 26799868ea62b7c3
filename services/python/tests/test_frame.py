"""WebSocket frames: what is sent, and what is made of any pieces that come."""

import random
import unittest

from webloop import frame
from webloop.frame import (
    BINARY,
    CLOSE,
    CONTINUATION,
    PING,
    TEXT,
    Decoder,
    FrameError,
    close_payload,
    close_reason,
    encode,
)


def served(opcode, payload, final=True):
    """A frame as a server sends it: not masked."""
    head = bytes(((0x80 if final else 0) | opcode,))
    if len(payload) < 126:
        return head + bytes((len(payload),)) + payload
    if len(payload) < 1 << 16:
        return head + b"\x7e" + len(payload).to_bytes(2, "big") + payload
    return head + b"\x7f" + len(payload).to_bytes(8, "big") + payload


class Encoding(unittest.TestCase):
    def test_the_example_of_the_standard(self):
        # RFC 6455, section 5.7: a single-frame masked text message "Hello".
        self.assertEqual(
            encode(TEXT, b"Hello", bytes.fromhex("37fa213d")),
            bytes.fromhex("818537fa213d7f9f4d5158"),
        )

    def test_a_length_is_written_in_the_fewest_bytes(self):
        for length, head in [
            (0, "8180"),
            (125, "81fd"),
            (126, "81fe007e"),
            (65535, "81feffff"),
            (65536, "81ff0000000000010000"),
        ]:
            data = encode(TEXT, bytes(length), b"\1\2\3\4")
            self.assertTrue(data.startswith(bytes.fromhex(head) + b"\1\2\3\4"), length)
            self.assertEqual(len(data), len(head) // 2 + 4 + length)
            self.assertEqual(data[-length:] if length else b"", (b"\1\2\3\4" * 16385)[:length])


class Decoding(unittest.TestCase):
    def test_messages_are_whole_in_whatever_pieces_they_come(self):
        data = (
            served(TEXT, b"one")
            + served(TEXT, b"tw", final=False)
            + served(PING, b"!")
            + served(CONTINUATION, b"o")
            + served(TEXT, b"x" * 1000)
            + served(CLOSE, close_payload(1008, "why"))
        )
        whole = [(TEXT, b"one"), (PING, b"!"), (TEXT, b"two"), (TEXT, b"x" * 1000), (CLOSE, b"\x03\xf0why")]
        draw = random.Random(1)
        for longest in [1, 2, 7, 300, len(data)]:
            decoder = Decoder(1024)
            got, at = [], 0
            while at < len(data):
                piece = draw.randint(1, longest)
                got += decoder.feed(data[at : at + piece])
                at += piece
            self.assertEqual(got, whole)

    def test_what_a_server_must_not_send_is_refused_with_its_code(self):
        for data, code in [
            (bytes((0xC1, 0)), frame.PROTOCOL_ERROR),
            (bytes((0x81, 0x80)), frame.PROTOCOL_ERROR),
            (bytes((0x83, 0)), frame.PROTOCOL_ERROR),
            (served(PING, b"!", final=False), frame.PROTOCOL_ERROR),
            (served(PING, b"!" * 126), frame.PROTOCOL_ERROR),
            (served(CONTINUATION, b"x"), frame.PROTOCOL_ERROR),
            (served(TEXT, b"x", final=False) + served(BINARY, b"x"), frame.PROTOCOL_ERROR),
            (bytes.fromhex("817f7fffffffffffffff"), frame.TOO_BIG),
            (served(TEXT, b"x" * 900, final=False) + served(CONTINUATION, b"x" * 900), frame.TOO_BIG),
        ]:
            with self.assertRaises(FrameError) as refused:
                list(Decoder(1024).feed(data))
            self.assertEqual(refused.exception.code, code, data[:10])


class Closing(unittest.TestCase):
    def test_a_reason_is_cut_at_a_character_and_reads_back(self):
        self.assertEqual(close_reason(close_payload(1008, "why")), "1008 why")
        long = close_payload(1000, "ä" * 100)
        self.assertLessEqual(len(long), frame.MAX_CONTROL_BYTES)
        self.assertEqual(close_reason(long), "1000 " + "ä" * 61)
        self.assertEqual(close_reason(b""), "without a code")


if __name__ == "__main__":
    unittest.main()
