"""Messages and rows: what is written, what reads back, and what is refused."""

import random
import struct
import unittest
from math import isfinite

from webloop.message import (
    Command,
    parse_answer,
    parse_answer_to,
    parse_observation,
)
from webloop.query import MAX_COUNT, InvalidMessage, decimal, fields, finite
from webloop.row import COLUMNS, MessageRow


class Messages(unittest.TestCase):
    def test_a_command_is_the_query_of_the_paper(self):
        self.assertEqual(Command(7, 1_200_000, 0.35).query(), "seq=7&t_send_ns=1200000&u=0.35")

    def test_answers_and_observations_are_read_in_any_order_and_escaping(self):
        state = parse_answer("closed", "y=-1e-7&seq=7&%74ick=3&t_arrive_ns=9&u=1e16")
        self.assertEqual(state, (7, 9, 3, -1e-7, 1e16))
        acknowledgement = parse_answer("open", f"seq={MAX_COUNT}&t_arrive_ns=0")
        self.assertEqual(acknowledgement, (MAX_COUNT, 0, None, None, None))
        self.assertEqual(parse_observation("t_ns=1&tick=2&y=.5&u=1."), (1, 2, 0.5, 1.0))

    def test_of_two_inputs_or_outputs_a_field_has_both(self):
        self.assertEqual(Command(7, 1, (0.35, -1e16)).query(), "seq=7&t_send_ns=1&u=0.35,-1e16")
        state = parse_answer("closed", "seq=7&tick=3&t_arrive_ns=9&y=0.82,.03&u=1")
        self.assertEqual(state.y, (0.82, 0.03))
        self.assertEqual(parse_observation("t_ns=1&tick=2&y=0.5&u=1%2C2"), (1, 2, 0.5, (1.0, 2.0)))
        for y, why in [
            ("1,2,3", "`y` has 3 numbers; a plant has one or two outputs"),
            ("1,", "`y`: `` is not a finite decimal number"),
            ("1, 2", "`y`: ` 2` is not a finite decimal number"),
            ("1,NaN", "`y`: `NaN` is not a finite decimal number"),
        ]:
            with self.assertRaisesRegex(InvalidMessage, why):
                parse_observation(f"t_ns=1&tick=2&y={y}&u=0")
        with self.assertRaisesRegex(InvalidMessage, "`u` has 4 numbers; a plant has one or two inputs"):
            parse_answer("closed", "seq=7&tick=3&t_arrive_ns=9&y=0.82&u=1,2,3,4")

    def test_what_is_wrong_is_refused_and_named(self):
        for text, why in [
            ("", "`seq` is missing"),
            ("seq=1", "`t_arrive_ns` is missing"),
            ("seq=1&t_arrive_ns=2&seq=1", "`seq` appears twice"),
            ("seq=1&t_arrive_ns=2&tick=3", "`tick` is unknown"),
            ("seq=-1&t_arrive_ns=2", "`seq`: `-1` is not a whole number"),
            ("seq=+1&t_arrive_ns=2", "`seq`: ` 1` is not a whole number"),
            ("seq=1_0&t_arrive_ns=2", "`seq`: `1_0` is not a whole number"),
            ("seq=\u0663&t_arrive_ns=2", "is not a whole number"),
            (f"seq={MAX_COUNT + 1}&t_arrive_ns=2", "is not a whole number"),
            ("seq=1&t_arrive_ns=" + "2" * 1024, "a message has at most 1024"),
        ]:
            with self.assertRaisesRegex(InvalidMessage, why):
                parse_answer("open", text)
        for value in ["", "inf", "NaN", "1e400", "1_0", " 1", "0x1", "1e", "--1", "\u0663"]:
            with self.assertRaisesRegex(InvalidMessage, "`y`: .* is not a finite decimal number"):
                finite("y", value)
        with self.assertRaisesRegex(InvalidMessage, r"`a\\nb` is unknown"):
            fields("a%0Ab=1", ("seq",))

    def test_an_answer_to_another_command_is_refused(self):
        with self.assertRaisesRegex(InvalidMessage, "to command 8, the command was 7"):
            parse_answer_to(Command(7, 0, 0.0), "open", "seq=8&t_arrive_ns=0")

    def test_every_number_reads_back_the_same_from_a_query(self):
        # A plus sign in a query is a space, and `repr` writes 1e+16.
        numbers = [0.0, -0.0, 1.0, 1e16, -1e300, 5e-324, 0.1]
        draw = random.Random(1)
        while len(numbers) < 2000:
            (number,) = struct.unpack("d", draw.randbytes(8))
            if isfinite(number):
                numbers.append(number)
        for number in numbers:
            (value,) = fields(f"u={decimal(number)}", ("u",))
            self.assertEqual(repr(finite("u", value)), repr(number))


class Rows(unittest.TestCase):
    def test_a_line_has_the_columns_in_order_and_nothing_is_an_empty_field(self):
        missed = MessageRow(4, 12, 1.0)
        self.assertEqual(missed.line(), "4,12,,,,1.0,,,,,missed,\n")
        full = MessageRow(0, 0, 1.0)
        values = (0, 1, 2, 3, 4, 1.0, 0.0, 1e-9, -0.5, 0, "answered", 7)
        for column, value in zip(COLUMNS, values):
            setattr(full, column, value)
        self.assertEqual(full.line(), "0,1,2,3,4,1.0,0.0,1e-09,-0.5,0,answered,7\n")


if __name__ == "__main__":
    unittest.main()
