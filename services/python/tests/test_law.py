"""The control laws against the vectors of the reference, and what is no law."""

import json
import pathlib
import unittest

from webloop.law import MAX_TICKS, InvalidLaw, paper_pi, parse_law
from webloop.message import AnswerFacts, Moment, numbers
from webloop.pid import Gains, Pid

VECTORS = pathlib.Path(__file__).resolve().parents[2] / "endpoint/tests/vectors/laws.json"

PID = {"kp": 2.0, "ki": 1.0, "kd": 0.0, "filter_rad_s": None, "limits": None}
MODEL = {"a": [[0.5, 0.0], [1.0, 0.25]], "b": [1.0, 0.0], "c": [0.0, 1.0], "d": 0.0}
LIMITS = {"min": -1.0, "max": None, "anti_windup": "off", "gain_per_s": None}
PULLED = {**LIMITS, "anti_windup": "back-calculation", "gain_per_s": 99.0}

LAWS = {
    "pid": {"law": "pid", **PID},
    "transfer": {"law": "transfer", "model": MODEL, "limits": LIMITS},
    "smith": {"law": "smith", "pid": PID, "model": MODEL, "ticks": 2},
    "state-feedback": {
        "law": "state-feedback",
        "model": {**MODEL, "b": [[1.0], [0.0]], "c": [[0.0, 1.0]], "d": [[0.0]]},
        "gains": [[0.5, 0.25]],
        "observer": [[0.25], [0.125], [0.5]],
        "reference": [[1.5]],
        "others": [],
        "limits": None,
    },
    "aged-feedback": {
        "law": "aged-feedback",
        "model": {**MODEL, "b": [[1.0], [0.0]], "c": [[0.0, 1.0]], "d": [[0.0]]},
        "gains": [[0.5, 0.25]],
        "reference": [[1.5]],
        "others": [],
        "limits": None,
        "h_ns": 3000000,
        "noise": {
            "covariance": [[1.0, 0.5], [0.5, 1.0]],
            "drift": [[1.0, 0.0], [0.0, 0.0]],
            "cross": [[0.0], [0.0]],
            "output": [[0.25]],
        },
    },
}

TWO = {
    "law": "state-feedback",
    "model": {
        "a": MODEL["a"],
        "b": [[1.0, 0.5], [0.0, 0.25]],
        "c": [[0.0, 1.0], [1.0, 0.0]],
        "d": [[0.0, 0.0], [0.0, 0.0]],
    },
    "gains": [[0.5, 0.25], [0.125, 0.0]],
    "observer": [[0.25, 0.0], [0.125, 0.5], [0.5, 0.0], [0.0, 0.5]],
    "reference": [[1.5, 0.5], [0.25, 1.0]],
    "others": [2.0],
    "limits": LIMITS,
}
"""A law of a plant with two inputs and two outputs, whose outputs are a tick old."""


def with_field(law, path, value):
    """A law with another value at a path of names and indices."""
    changed = json.loads(json.dumps(law))
    at = changed
    for name in path[:-1]:
        at = at[name]
    at[path[-1]] = value
    return changed


def signal(value):
    """A signal of the vectors, in which what JSON has no number for is a word."""
    return tuple(map(float, value)) if isinstance(value, list) else float(value)


def times(words):
    """The times of a step, if it has any."""
    if words is None:
        return None
    told = words["told"]
    if told is not None:
        told = AnswerFacts(told["tick"], signal(told["u"]), told["send_ns"])
    return Moment(words["send_ns"], told)


def bits(signal):
    """Each number of a signal, to its last bit."""
    return [value.hex() for value in numbers(signal)]


def without_field(law, name):
    """A law that lacks a field."""
    return {key: value for key, value in law.items() if key != name}


class Vectors(unittest.TestCase):
    def test_every_law_does_what_the_vectors_say_to_the_last_bit(self):
        if not VECTORS.exists():
            self.skipTest(f"there is no {VECTORS.name} yet; the crate system's tests write it")
        cases = json.loads(VECTORS.read_text(encoding="utf-8"))["cases"]
        self.assertEqual({case["law"]["law"] for case in cases}, set(LAWS))
        for case in cases:
            with self.subTest(case=case["case"]):
                law = parse_law(json.dumps(case["law"]))
                for number, step in enumerate(case["steps"]):
                    r, y, dt_s, u = (signal(step[name]) for name in ("r", "y", "dt_s", "u"))
                    found = law.update(r, y, dt_s, times(step.get("times")))
                    self.assertEqual(bits(found), bits(u), number)


class Update(unittest.TestCase):
    def test_what_is_not_a_number_leaves_the_integrator_and_repeats_the_last_command(self):
        law = Pid(Gains(2.0, 1.0))
        before = law.update(1.0, 0.0, 0.5)
        self.assertEqual(before, 2.5)
        nan, inf = float("nan"), float("inf")
        for r, dt_s in [(nan, 0.5), (inf, 0.5), (1.0, 0.0), (1.0, -1.0), (1.0, nan), (1e300, 1e300)]:
            self.assertEqual(law.update(r, 0.0, dt_s), before)
        self.assertEqual(law.update(1.0, 0.0, 0.5), 3.0)

    def test_every_law_holds_its_command_where_an_output_is_not_a_number(self):
        for name, words in LAWS.items():
            law, untouched = parse_law(json.dumps(words)), parse_law(json.dumps(words))
            self.assertEqual(law.update(1.0, float("nan"), 0.003), 0.0, name)
            for step in range(5):
                y = 0.125 * step
                u = untouched.update(1.0, y, 0.003)
                self.assertEqual(law.update(1.0, y, 0.003), u, name)
                for broken in ("nan", "inf", "-inf"):
                    self.assertEqual(law.update(1.0, float(broken), 0.003), u, name)
                    self.assertEqual(law.update(float(broken), y, 0.003), u, name)

    def test_the_paper_s_pi_is_one_of_them(self):
        words = {"law": "pid", **PID, "kp": 0.1701, "ki": 0.378}
        # The rest of an update, without limits that are ever met.
        wide = {**words, "limits": {**LIMITS, "min": -1e9}}
        laws = [paper_pi(), parse_law(json.dumps(words)), parse_law(json.dumps(wide))]
        for step in range(1000):
            commands = {law.update(1.0, step / 700.0, 0.003).hex() for law in laws}
            self.assertEqual(len(commands), 1, step)

    def test_a_smith_predictor_with_the_model_of_the_plant_sees_no_round_trip(self):
        # Once the round trip is over, y is what the model said then, and the
        # PID's error is that of a loop without a link.
        words = {**LAWS["smith"], "ticks": 3}
        law, direct = parse_law(json.dumps(words)), Pid(Gains(2.0, 1.0))
        model = parse_law(json.dumps({**LAWS["transfer"], "limits": None}))
        y, line = 0.0, [0.0] * 3
        for _ in range(20):
            u = law.update(1.0, line[0], 0.01)
            self.assertAlmostEqual(u, direct.update(1.0, y, 0.01))
            line = line[1:] + [y]
            y = model.update(u, 0.0, 0.01)

    def test_state_feedback_of_two_inputs_and_outputs(self):
        nan = float("nan")
        law = parse_law(json.dumps(TWO))
        self.assertEqual(law.update(1.0, (0.0, nan), 0.01), (0.0, 0.0))
        # Both references at rest: 1.5 + 0.5 * 2 and 0.25 + 2.
        self.assertEqual(law.update(1.0, (0.0, 0.0), 0.01), (2.5, 2.25))
        # The model is at (3.625, 0.5625) now; its outputs a tick ago were 0.
        u = law.update(1.0, (0.5, -0.5), 0.01)
        x = (3.625 + 0.25 * 0.5, 0.5625 + 0.125 * 0.5 - 0.5 * 0.5)
        self.assertEqual(u, (2.5 - 0.5 * x[0] - 0.25 * x[1], 2.25 - 0.125 * x[0]))
        for y in [(nan, 0.0), (0.0, float("inf")), 0.5]:
            self.assertEqual(law.update(1.0, y, 0.01), u, y)
        self.assertEqual(law.update(1.0, (1e3, 0.0), 0.01)[0], -1.0)

    def test_the_other_laws_act_on_the_first_of_two_outputs(self):
        for name in ("pid", "transfer", "smith"):
            one, two = (parse_law(json.dumps(LAWS[name])) for _ in range(2))
            for y in (0.0, 0.25, 0.5):
                self.assertEqual(two.update(1.0, (y, 7.0), 0.01), one.update(1.0, y, 0.01), name)


class Refusals(unittest.TestCase):
    def test_what_is_no_law_is_refused_with_the_field_and_what_to_give(self):
        pid, transfer, smith, feedback, aged = LAWS.values()
        for law, names in [
            (7, "one of pid, transfer, smith, state-feedback"),
            ([pid], "`law`: `null`"),
            ({}, "`law`: `null`"),
            ({**pid, "law": "bang-bang"}, "`law`: `\"bang-bang\"`"),
            ({**pid, "law": ["pid"]}, "`law`"),
            ({**pid, "gain": 1.0}, "`gain` is unknown"),
            *[(without_field(pid, name), f"`{name}` is missing") for name in PID],
            ({**pid, "kp": "1"}, "`kp`: `\"1\"`"),
            ({**pid, "kp": True}, "`kp`: `true`"),
            ({**pid, "ki": float("nan")}, "`ki`: `NaN`"),
            ({**pid, "ki": 10**400}, "`ki`: `1000"),
            ({**pid, "kd": None}, "`kd`: `null`"),
            ({**pid, "filter_rad_s": 0.0}, "`filter_rad_s`: `0.0`"),
            ({**pid, "limits": []}, "`limits`: `[]`"),
            ({**pid, "limits": {}}, "`limits.min` is missing"),
            ({**pid, "limits": {**LIMITS, "max": -1.0}}, "from -1.0 to -1.0 is empty"),
            ({**pid, "limits": {**LIMITS, "anti_windup": "on"}}, "off or conditional or back-"),
            ({**pid, "limits": {**LIMITS, "gain_per_s": 1.0}}, "null where anti_windup is off"),
            ({**pid, "limits": {**PULLED, "gain_per_s": None}}, "`limits.gain_per_s`: `null`"),
            ({**pid, "limits": {**PULLED, "gain_per_s": -1}}, "`limits.gain_per_s`: `-1`"),
            ({**transfer, "limits": PULLED}, "`limits.anti_windup`"),
            ({**transfer, "model": None}, "`model`: `null`"),
            (without_field(transfer, "model"), "`model` is missing"),
            (with_field(transfer, ["model", "a"], 1), "`model.a`: `1`"),
            (with_field(transfer, ["model", "a", 0], [1.0]), "`model.a[0]` has 1 numbers; give 2"),
            (with_field(transfer, ["model", "a", 1, 1], None), "`model.a[1][1]`: `null`"),
            (with_field(transfer, ["model", "b"], [1.0]), "`model.b` has 1 numbers; give 2"),
            (with_field(transfer, ["model", "c"], []), "`model.c` has 0 numbers; give 2"),
            (with_field(transfer, ["model", "d"], []), "`model.d`: `[]`"),
            (with_field(transfer, ["model", "e"], 0), "`model.e` is unknown"),
            ({**smith, "pid": pid}, "`pid.law` is unknown"),
            (with_field(smith, ["pid", "kp"], None), "`pid.kp`: `null`"),
            ({**smith, "ticks": -1}, "`ticks`: `-1`"),
            ({**smith, "ticks": 0.5}, "`ticks`: `0.5`"),
            ({**smith, "ticks": True}, "`ticks`: `true`"),
            ({**smith, "ticks": MAX_TICKS + 1}, f"from 0 to {MAX_TICKS}"),
            ({**feedback, "gains": [1.0, 2.0]}, "`gains[0]`: `1.0` is wrong; give a list"),
            ({**feedback, "gains": [[1.0]]}, "`gains[0]` has 1 numbers; give 2, one for each row of `model.a`"),
            ({**feedback, "observer": [[1.0], [1.0]]}, "`observer` has 2 rows; give 2 for the model's states and 1"),
            ({**feedback, "reference": {}}, "`reference`: `{}`"),
            ({**feedback, "others": [1.0]}, "`others` has 1 numbers; give at most 0"),
            (without_field(feedback, "others"), "`others` is missing"),
            (without_field(aged, "h_ns"), "`h_ns` is missing"),
            ({**aged, "h_ns": 0}, "`h_ns`: `0` is wrong; give a whole number above zero"),
            ({**aged, "h_ns": 3e6}, "`h_ns`: `3000000.0` is wrong"),
            ({**aged, "noise": {}}, "`noise.covariance` is missing"),
            (with_field(aged, ["noise", "drift"], [[1.0, 0.0]]), "`noise.drift` has 1 rows; give 2"),
            (with_field(aged, ["noise", "output", 0, 0], None), "`noise.output[0][0]`: `null`"),
            ({**TWO, "gains": []}, "`gains` has 0 rows; give one or two, one for each input"),
            (with_field(TWO, ["model", "c"], [[0.0, 1.0]] * 3), "`model.c` has 3 rows; give one or two"),
            (with_field(TWO, ["model", "a", 1], [1.0]), "`model.a[1]` has 1 numbers; give 2"),
            (with_field(TWO, ["model", "b"], [[1.0, 1.0]]), "`model.b` has 1 rows; give 2, one for each row of `mod"),
            (with_field(TWO, ["model", "b", 1], [1.0]), "`model.b[1]` has 1 numbers; give 2, one for each row of `g"),
            (with_field(TWO, ["model", "c", 0, 1], None), "`model.c[0][1]`: `null`"),
            (with_field(TWO, ["model", "d"], 0.0), "`model.d`: `0.0` is wrong; give a list"),
            (with_field(TWO, ["gains", 1], [0.0]), "`gains[1]` has 1 numbers; give 2"),
            (with_field(TWO, ["observer"], [[0.0, 0.0]] * 5), "`observer` has 5 rows; give 2 for the model's states"),
            (with_field(TWO, ["observer", 3], [0.0]), "`observer[3]` has 1 numbers; give 2, one for each row of"),
            (with_field(TWO, ["reference", 0], [1.0]), "`reference[0]` has 1 numbers; give 2, one for each ref"),
            (with_field(TWO, ["reference"], [[1.0, 0.0]]), "`reference` has 1 rows; give 2, one for each row of"),
            (with_field(TWO, ["others"], [1.0, 2.0]), "`others` has 2 numbers; give at most 1"),
        ]:
            with self.assertRaises(InvalidLaw, msg=law) as refused:
                parse_law(json.dumps(law))
            self.assertIn(names, str(refused.exception))

    def test_what_is_no_json_is_refused_with_an_example(self):
        for text in ["", "pid", "{", "'{}'", "[" * 100_000]:
            with self.assertRaises(InvalidLaw, msg=text[:9]) as refused:
                parse_law(text)
            self.assertIn('write it like {"law":"pid"', str(refused.exception))
            self.assertNotIn("\n", str(refused.exception))


if __name__ == "__main__":
    unittest.main()
