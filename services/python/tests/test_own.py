"""A controller of one's own: how it is called, that a PI makes the built-in client's bits, and how its
program ends."""

import contextlib
import csv
import io
import json
import os
import pathlib
import random
import subprocess
import sys
import tempfile
import unittest
from math import inf, nan

from test_http import Plant, response

from webloop.law import paper_pi
from webloop.own import LawError, Own

PACKAGE = pathlib.Path(__file__).resolve().parents[1]

PATIENCE_S = 60
"""How long a busy machine may take for anything here."""

MESSAGES = 20
"""How many the plant of these tests can answer."""

PI = """
class Mine:
    def __init__(self):
        self.integral = 0.0

    def update(self, r, y, dt):
        e = r - y
        self.integral += 0.378 * dt * e
        return 0.1701 * e + self.integral
"""


def own_pi():
    names = {}
    exec(PI, names)
    return Own(names["Mine"]())


class Returning:
    """Returns the same whatever happens."""

    def __init__(self, value):
        self.value = value

    def update(self, r, y, dt):
        return self.value


class Number:
    """A number as another library has it."""

    def __float__(self):
        return 0.1


class Calls(unittest.TestCase):
    def test_a_pi_makes_the_bits_of_the_built_in_one(self):
        drawn = random.Random(1)
        for integrates_elapsed in (False, True):
            mine, built_in = own_pi(), paper_pi()
            for _ in range(1000):
                r, y = drawn.choice([1.0, -0.5]), drawn.gauss(0.5, 1.0)
                dt_s = drawn.uniform(0.0001, 0.3) if integrates_elapsed else 3_000_000 / 1e9
                u, expected = mine.update(r, y, dt_s), built_in.update(r, y, dt_s)
                self.assertEqual(u.hex(), expected.hex())

    def test_any_finite_number_is_a_command_and_nothing_else_is(self):
        for value, u in [(0.5, 0.5), (2, 2.0), (Number(), 0.1), (-1e-300, -1e-300)]:
            made = Own(Returning(value)).update(1.0, 0.0, 0.01)
            self.assertEqual((made, type(made)), (u, float))
        for value in [None, nan, inf, -inf, "0.5", 10**400, 1j, [0.5], "12", (0.5, nan), (1, 2, 3), {1, 2}, {}]:
            law = Own(Returning(value))
            with self.assertRaises(LawError, msg=repr(value)) as raised:
                law.update(1.0, 0.25, 0.01)
            said = str(raised.exception)
            self.assertIn("call 1 of the controller, update(r=1.0, y=0.25, dt=0.01), returned `", said)
            self.assertIn("return u, a finite number", said)

    def test_of_two_inputs_or_outputs_there_are_two_numbers(self):
        for value in [(0.5, Number()), [0.5, 0.1], [Number(), 2]]:
            u = Own(Returning(value)).update(1.0, (0.0, 0.0), 0.01)
            self.assertEqual((type(u), [type(one) for one in u]), (tuple, [float, float]))
        with self.assertRaises(LawError) as raised:
            Own(Returning((0.5, inf))).update(1.0, (0.25, 0.5), 0.01)
        said = str(raised.exception)
        self.assertIn("update(r=1.0, y=(0.25, 0.5), dt=0.01), returned `(0.5, inf)`", said)
        self.assertIn("or two for a plant with two inputs", said)

        class Asking(Returning):
            def update(self, r, y, dt):
                return y

        self.assertEqual(Own(Asking(None)).update(1.0, (0.25, 0.5), 0.01), (0.25, 0.5))

    def test_a_call_that_raises_is_named_and_shown(self):
        class Raising:
            calls = 0

            def update(self, r, y, dt):
                self.calls += 1
                return 1.0 / (3 - self.calls)

        law = Own(Raising())
        self.assertEqual([law.update(1.0, 0.0, 0.01) for _ in range(2)], [0.5, 1.0])
        shown = io.StringIO()
        with contextlib.redirect_stderr(shown), self.assertRaises(LawError) as raised:
            law.update(1.0, 0.25, 0.01)
        self.assertIn("call 3 of the controller, update(r=1.0, y=0.25, dt=0.01), raised Zero", str(raised.exception))
        self.assertIn("return 1.0 / (3 - self.calls)", shown.getvalue())

    def test_start_is_called_if_there_is_one(self):
        class Starting(Returning):
            def start(self, h, r):
                self.value = (h, r)

        controller = Starting(None)
        Own(controller).start(0.01, 0.5)
        self.assertEqual(controller.value, (0.01, 0.5))
        Own(Returning(0.0)).start(0.01, 0.5)
        shown = io.StringIO()
        with contextlib.redirect_stderr(shown), self.assertRaises(LawError) as raised:
            Starting.start = lambda self, h: None
            Own(controller).start(0.01, 0.5)
        self.assertIn("start(h=0.01, r=0.5) raised TypeError", str(raised.exception))


class Programs(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        answers = [response(f"seq={k}&tick={k}&t_arrive_ns=9&y={k / 7!r}&u=0.5") for k in range(MESSAGES)]
        self.plant = Plant(answers)
        self.addCleanup(self.plant.close)

    def run_program(self, source, **variables):
        """Runs a program with the package in its path; what it was, once it has ended."""
        program = self.folder / "mine.py"
        program.write_text("import webloop\n" + source, encoding="utf-8")
        kept = {name: value for name, value in os.environ.items() if not name.startswith("WEBLOOP_")}
        return subprocess.run(
            [sys.executable, "-B", str(program)],
            env={**kept, "PYTHONPATH": str(PACKAGE), **variables},
            capture_output=True,
            text=True,
            timeout=PATIENCE_S,
        )

    def told(self):
        """The environment that webloop gives."""
        settings = {
            "mode": "closed",
            "h": "10ms",
            "r": 1.0,
            "outstanding": "unlimited",
            "transport": "http",
            "connection": "keep",
            "schedule": "absolute",
            "integrate": "h",
            "late": "apply",
            "timeout_ns": 5_000_000_000,
        }
        told = {
            "plant": f"127.0.0.1:{self.plant.port}",
            "settings": settings,
            "law": None,
            "start_ns": None,
            "duration_ns": MESSAGES * 10_000_000,
            "reference": None,
        }
        path = self.folder / "settings.json"
        path.write_text(json.dumps(told), encoding="utf-8")
        return {"WEBLOOP_SETTINGS": str(path), "WEBLOOP_OUT": str(self.folder / "out")}

    def rows(self):
        """The rows of messages that were sent, in order of seq."""
        with open(self.folder / "out" / "messages.csv", encoding="utf-8", newline="") as file:
            rows = [row for row in csv.DictReader(file) if row["outcome"] != "missed"]
        return sorted(rows, key=lambda row: int(row["seq"]))

    def test_a_program_runs_the_loop_and_leaves_rows_and_report(self):
        ended = self.run_program(PI + "webloop.control(Mine())\n", **self.told())
        self.assertEqual((ended.returncode, ended.stdout), (0, ""), ended.stderr)
        rows = self.rows()
        self.assertGreater(len(rows), 0)
        built_in = paper_pi()
        for row in rows:
            u = built_in.update(1.0, float(row["y"]), 10_000_000 / 1e9)
            self.assertEqual(float(row["u"]).hex(), u.hex(), row)
        report = json.loads((self.folder / "out" / "controller.json").read_text(encoding="utf-8"))
        self.assertEqual((report["counts"]["due"], report["interrupted"]), (MESSAGES, False))

    def test_options_say_it_too(self):
        options = f"--plant 127.0.0.1:{self.plant.port} --h 10ms --duration 100ms --out {self.folder / 'out'}"
        source = PI + f"webloop.control(Mine(), arguments={options.split()!r})\n"
        ended = self.run_program(source)
        said = f"ready http://127.0.0.1:{self.plant.port}\n"
        self.assertEqual((ended.returncode, ended.stdout), (0, said), ended.stderr)
        self.assertGreater(len(self.rows()), 0)

    def test_a_controller_that_fails_ends_the_run_with_1_and_keeps_the_rows(self):
        for body, what in [
            ("return {}['gain']", "raised KeyError: 'gain'"),
            ("return None", "returned `None`"),
        ]:
            failing = "class Mine:\n    calls = 0\n\n    def update(self, r, y, dt):\n"
            failing += f"        self.calls += 1\n        if self.calls == 3:\n            {body}\n        return 0.5\n"
            told = self.told()
            told["WEBLOOP_OUT"] = str(self.folder / what.split()[0])
            ended = self.run_program(failing + "webloop.control(Mine())\n", **told)
            self.assertEqual((ended.returncode, ended.stdout), (1, ""), ended.stderr)
            last = ended.stderr.splitlines()[-1]
            self.assertTrue(last.startswith("webloop: call 3 of the controller, update(r=1.0, "), ended.stderr)
            self.assertIn(what, last)
            self.assertEqual("mine.py" in ended.stderr, "raised" in what, ended.stderr)
            self.assertTrue((self.folder / what.split()[0] / "messages.csv").exists())

    def test_a_program_that_nobody_told_anything_says_how_it_is_started(self):
        told = self.told()
        for without in told:
            rest = {name: value for name, value in told.items() if name != without}
            ended = self.run_program(PI + "webloop.control(Mine())\n", **rest)
            self.assertEqual(ended.returncode, 2, ended.stderr)
            self.assertEqual(ended.stderr.count("\n"), 1, ended.stderr)
            for word in [without, "`webloop run`", "`webloop conform -- python3 mine.py`"]:
                self.assertIn(word, ended.stderr)
        ended = self.run_program(PI + "webloop.control(Mine())\n", **{**told, "WEBLOOP_SETTINGS": "nowhere"})
        self.assertEqual((ended.returncode, ended.stderr.count("\n")), (2, 1), ended.stderr)
        self.assertIn("cannot read the settings in nowhere", ended.stderr)

    def test_importing_the_package_imports_nothing_else(self):
        source = "import sys\n"
        source += "assert not [name for name in sys.modules if name.startswith('webloop.')]\n"
        source += "webloop.control, webloop.results.read\n"
        source += "assert not hasattr(webloop, 'nothing')\n"
        ended = self.run_program(source)
        self.assertEqual((ended.returncode, ended.stderr), (0, ""))


if __name__ == "__main__":
    unittest.main()
