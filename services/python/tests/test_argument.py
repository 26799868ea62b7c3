"""The command line: what is taken, and that the rest is a sentence and exit 2."""

import contextlib
import io
import json
import tempfile
import unittest
from math import inf

from webloop import argument
from webloop.setting import UNLIMITED
from webloop.span import parse_sample_time, parse_span


class Spans(unittest.TestCase):
    def test_a_span_is_whole_nanoseconds_with_units(self):
        for text, span_ns in [
            ("3ms", 3_000_000),
            ("100us", 100_000),
            ("6000000000ns", 6_000_000_000),
            ("6s", 6_000_000_000),
            ("10m", 600_000_000_000),
            ("1h", 3_600_000_000_000),
            ("1m30s", 90_000_000_000),
            ("0.3ms", 300_000),
            ("1.5s", 1_500_000_000),
        ]:
            self.assertEqual(parse_span(text), span_ns, text)
        for text in ["", "3", "ms", "-3ms", "3 ms", "NaNms", "1e3us", "0.5ns", ".5s", "3.ms", "0s", "9" * 20 + "s"]:
            with self.assertRaises(ValueError, msg=text):
                parse_span(text)

    def test_a_sample_time_is_one_span_within_its_range(self):
        self.assertEqual(parse_sample_time("10us"), 10_000)
        for text in ["9.999us", "3601s", "0ms", "1s1ms", "3"]:
            with self.assertRaises(ValueError, msg=text):
                parse_sample_time(text)


class Arguments(unittest.TestCase):
    def test_nothing_given_is_the_paper_s_client(self):
        config = argument.read([])
        self.assertEqual(
            config.settings[:7], ("closed", 3_000_000, 1.0, UNLIMITED, "absolute", "h", "apply")
        )
        self.assertEqual(config.plant, ("127.0.0.1", 8080))
        self.assertEqual((config.settings.transport, config.settings.connection), ("http", "keep"))
        self.assertEqual((config.settings.timeout_ns, config.duration_ns), (5 * 10**9, 6 * 10**9))
        self.assertEqual((config.start_ns, config.out), (None, "serve"))
        self.assertEqual(config.law.gains, (0.1701, 0.378, 0.0, inf))

    def test_every_option_can_be_given(self):
        line = (
            "--plant [::1]:80 --h 1ms --mode open --r -1e-3 --duration 6000000000ns"
            " --outstanding 1 --connection new --schedule relative --integrate elapsed"
            " --late drop --timeout 300ms --start-ns 18446744073709551615 --out a/b"
        )
        config = argument.read(line.split())
        self.assertEqual(
            config.settings[:7], ("open", 1_000_000, -0.001, 1, "relative", "elapsed", "drop")
        )
        self.assertEqual(config.plant, ("::1", 80))
        self.assertEqual((config.settings.transport, config.settings.connection), ("http", "new"))
        self.assertEqual((config.settings.timeout_ns, config.duration_ns), (300_000_000, 6 * 10**9))
        self.assertEqual((config.start_ns, config.out), (2**64 - 1, "a/b"))
        words = json.dumps({"law": "pid", "kp": 2, "ki": 1, "kd": 0, "filter_rad_s": None, "limits": None})
        self.assertEqual(argument.read(["--law", words]).law.gains, (2.0, 1.0, 0.0, inf))

    def test_all_can_be_told_at_once_as_json(self):
        pid = {"law": "pid", "kp": 2, "ki": 1, "kd": 0, "filter_rad_s": None, "limits": None}
        told = {
            "plant": "10.77.0.2:8080",
            "settings": {
                "mode": "open",
                "h": "1ms",
                "r": 0.5,
                "outstanding": 8,
                "transport": "websocket",
                "connection": "keep",
                "schedule": "since-send",
                "integrate": "elapsed",
                "late": "drop",
                "timeout_ns": 300_000_000,
            },
            "law": pid,
            "start_ns": 2**63,
            "duration_ns": 6,
            "reference": [[0, 0.5], [3, -1.0]],
        }
        config = self._read(told)
        self.assertEqual(
            config.settings,
            ("open", 1_000_000, 0.5, 8, "since-send", "elapsed", "drop", "websocket", "keep", 300_000_000),
        )
        self.assertEqual(config.plant, ("10.77.0.2", 8080))
        self.assertEqual((config.start_ns, config.duration_ns), (2**63, 6))
        self.assertEqual((config.law.gains, config.out), ((2.0, 1.0, 0.0, inf), "a"))
        self.assertEqual(config.reference, [(0, 0.5), (3, -1.0)])
        self.assertIsNone(self._read({**told, "reference": None}).reference)
        self.assertFalse(config.claim)
        self.assertTrue(self._read({**told, "claim": True}).claim)
        self.assertFalse(config.again)
        self.assertTrue(self._read({**told, "again": True}).again)
        for change, what in [
            ({"speed": 3}, "`speed` is unknown"),
            ({"plant": "localhost"}, "`localhost` is not an address"),
            ({"settings": {**told["settings"], "gait": 1}}, "`gait` is unknown"),
            ({"settings": {**told["settings"], "late": "never"}}, "late `never`"),
            ({"settings": {**told["settings"], "timeout_ns": "5s"}}, "timeout_ns `5s`"),
            ({"settings": {"mode": "open"}}, "`h` is missing"),
            ({"claim": 1}, "`claim` is `1`"),
            ({"again": "yes"}, "`again` is `yes`"),
            ({"again": True, "start_ns": None}, "`again` without `start_ns`"),
            ({"reference": [[1, 0.5]]}, "`reference` must be"),
            ({"reference": [[0, 0.5], [0, 1]]}, "`reference` must be"),
            ({"reference": [[0, None]]}, "`reference` must be"),
            ({"settings": {**told["settings"], "connection": "new"}}, "connection `new`"),
        ]:
            said = io.StringIO()
            with contextlib.redirect_stderr(said), self.assertRaises(SystemExit) as exit_:
                self._read({**told, **change})
            self.assertEqual(exit_.exception.code, 2, change)
            self.assertIn(what, said.getvalue())

    def _read(self, told):
        with tempfile.NamedTemporaryFile("w", suffix=".json") as file:
            json.dump(told, file)
            file.flush()
            return argument.read(["--settings", file.name, "--out", "a"])

    def test_wrong_usage_ends_with_2_and_says_what_is_wrong_and_what_to_do(self):
        for line, what, remedy in [
            ("--plant localhost:8080", "`localhost:8080`", "like 10.77.0.2:8080"),
            ("--plant 10.0.0.1", "`10.0.0.1`", "like 10.77.0.2:8080"),
            ("--plant ::1:80", "`::1:80`", "like 10.77.0.2:8080"),
            ("--h 3", "`3`", "like 3ms"),
            ("--h 1us", "h = 1000 ns", "write 3ms"),
            ("--mode opened", "mode `opened`", "choose open or closed"),
            ("--transport carrier", "transport `carrier`", "choose http or websocket"),
            ("--outstanding 0", "outstanding is `0`", "give 1 to 8192"),
            ("--r nan", "`nan`", "like 1 or -0.5"),
            ("--law pi", "`pi` is not JSON", "write it like"),
            ('--law {"law":"pi"}', "`law`: `\"pi\"`", "one of pid, transfer"),
            ("--timeout 0s", "`0s`", "like 5s"),
            ("--start-ns -1", "--start-ns", "--help"),
            ("--start-ns soon", "`soon`", "CLOCK_MONOTONIC"),
            ("--transport websocket --connection new", "connection `new`", "choose connection `keep`"),
            ("--h", "--h", "--help"),
            ("--speed 3", "--speed", "--help"),
        ]:
            said = io.StringIO()
            with contextlib.redirect_stderr(said), self.assertRaises(SystemExit) as exit_:
                argument.read(line.split())
            self.assertEqual(exit_.exception.code, 2, line)
            self.assertIn(what, said.getvalue())
            self.assertIn(remedy, said.getvalue())
            self.assertEqual(said.getvalue().count("\n"), 1, said.getvalue())


if __name__ == "__main__":
    unittest.main()
