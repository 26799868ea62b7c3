"""The controller's end against the vectors of the reference, step by step."""

import json
import pathlib
import unittest

from webloop.end import AwaitAnswer, ControllerEnd, Finished, Missed, Send, Sleep
from webloop.law import paper_pi
from webloop.message import parse_answer
from webloop.row import COLUMNS, FAILED, TIMEOUT
from webloop.setting import Settings, parse_outstanding
from webloop.span import parse_sample_time

VECTORS = (
    pathlib.Path(__file__).resolve().parents[2] / "endpoint/tests/vectors/controller.json"
)


def settings_of(words):
    """Settings from the words of a vector."""
    return Settings(
        mode=words["mode"],
        h_ns=parse_sample_time(words["h"]),
        r=words["r"],
        outstanding=parse_outstanding(str(words["outstanding"])),
        schedule=words["schedule"],
        integrate=words["integrate"],
        late=words["late"],
    )


def wake(end, now_ns):
    """What the end does at a time, until it says to wait, in a vector's words."""
    steps = []
    while True:
        step = end.poll(now_ns)
        if isinstance(step, Send):
            steps.append({"send": step.command.query()})
        elif isinstance(step, Missed):
            steps.append({"missed": step.row.seq, "t_due_ns": step.row.t_due_ns})
        elif isinstance(step, Sleep):
            return steps + [{"sleep_until_ns": step.until_ns}]
        elif isinstance(step, AwaitAnswer):
            return steps + ["await-answer"]
        elif isinstance(step, Finished):
            return steps + ["finished"]


def row_of(row):
    """A row in a vector's words."""
    return None if row is None else {column: getattr(row, column) for column in COLUMNS}


class Vectors(unittest.TestCase):
    def test_the_end_does_what_the_vectors_say(self):
        vectors = json.loads(VECTORS.read_text(encoding="utf-8"))
        law = paper_pi()
        self.assertEqual(law.gains[:2], (vectors["law"]["kp"], vectors["law"]["ki"]))
        self.assertGreater(len(vectors["cases"]), 0)
        for case in vectors["cases"]:
            with self.subTest(case=case["case"]):
                self.play(case)

    def play(self, case):
        settings = settings_of(case["settings"])
        end = ControllerEnd(settings, paper_pi(), 0.0, case["start_ns"], case["stop_ns"], case["reference"])
        for number, step in enumerate(case["steps"]):
            with self.subTest(step=number):
                at_ns = step["at_ns"]
                if "wake" in step:
                    self.assertEqual(wake(end, at_ns), step["then"])
                elif "answer" in step:
                    answer = parse_answer(settings.mode, step["answer"])
                    self.assertEqual(row_of(end.answered(answer, at_ns)), step["row"])
                elif "timeout" in step:
                    row = end.lost(step["timeout"], TIMEOUT, at_ns)
                    self.assertEqual(row_of(row), step["row"])
                elif "failure" in step:
                    row = end.lost(step["failure"], FAILED, at_ns)
                    self.assertEqual(row_of(row), step["row"])
                else:
                    self.fail(f"an event that is new here: {step}")
        self.assertEqual(end.counts.words(), case["counts"])

    def test_a_law_gets_and_gives_all_signals_and_a_row_has_the_first(self):
        class Swapping:
            def update(self, r, y, dt_s, times):
                self.times = times
                return y[1], y[0]

        settings = Settings("closed", 10, 1.0, 1, "absolute", "h", "apply")
        law = Swapping()
        end = ControllerEnd(settings, law, (0.25, 0.5), 0, 20)
        self.assertEqual(end.poll(0).command.u, (0.5, 0.25))
        self.assertEqual(law.times, (0, None))
        row = end.answered(parse_answer("closed", "seq=0&tick=1&t_arrive_ns=2&y=3,4&u=0.5,0.25"), 3)
        self.assertEqual((row.y, row.e, row.u, row.y_seq), (0.25, 0.75, 0.5, None))
        self.assertEqual(end.poll(10).command.u, (4.0, 3.0))
        self.assertEqual(law.times, (10, (1, (0.5, 0.25), 0)))

    def test_an_end_that_goes_on_has_the_deadlines_and_numbers_of_one_from_the_start(self):
        for schedule in ("absolute", "relative", "since-send"):
            settings = Settings("closed", 10, 1.0, 1, schedule, "h", "apply")
            for now_ns, seq, due_ns in [(0, 0, 100), (99, 0, 100), (100, 1, 110), (104, 1, 110), (139, 4, 140)]:
                end = ControllerEnd(settings, paper_pi(), 0.0, 100, 150, [(0, 1.0), (30, 2.0)])
                end.resume(now_ns)
                self.assertEqual(wake(end, now_ns), [{"sleep_until_ns": due_ns}])
                self.assertEqual(end.poll(due_ns).command.seq, seq)
                self.assertEqual(end.lost(seq, FAILED, due_ns).r, 2.0 if due_ns >= 130 else 1.0)
            end.resume(150)
            self.assertIsInstance(end.poll(150), Finished)


if __name__ == "__main__":
    unittest.main()
