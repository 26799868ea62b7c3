"""A plant of one's own: what its program prints for what it reads, and how it ends."""

import os
import pathlib
import subprocess
import sys
import unittest

PACKAGE = pathlib.Path(__file__).resolve().parents[1]

PATIENCE_S = 60
"""How long a busy machine may take for anything here."""

LAG = """
import webloop

class Lag:
    y = 0.25

    def step(self, u, dt):
        print("a word of its own")
        self.y += dt * (u - self.y)
        return self.y

webloop.plant(Lag())
"""


def run(program, inputs, **environment):
    """Runs a program with these lines as its input; its exit code, output and errors."""
    variables = {**os.environ, "PYTHONPATH": str(PACKAGE), "WEBLOOP_H_S": "0.01", **environment}
    done = subprocess.run(
        [sys.executable, "-B", "-c", program],
        input=inputs,
        env=variables,
        capture_output=True,
        text=True,
        timeout=PATIENCE_S,
        check=False,
    )
    return done.returncode, done.stdout.split(), done.stderr


class PlantTest(unittest.TestCase):
    def test_it_prints_a_y_at_once_and_one_for_each_u(self):
        code, printed, said = run(LAG, "1.0\n-0.5\n")
        first = 0.25 + 0.01 * (1.0 - 0.25)
        second = first + 0.01 * (-0.5 - first)
        self.assertEqual((code, printed), (0, ["0.25", repr(first), repr(second)]), said)
        self.assertIn("a word of its own", said)

    def test_a_step_that_returns_no_number_ends_it_and_says_which(self):
        for value, words in [("None", "`None`"), ("float('nan')", "nan"), ("'high'", "`'high'`")]:
            program = LAG.replace("return self.y", f"return {value}")
            code, printed, said = run(program, "1.0\n")
            self.assertEqual((code, printed), (1, ["0.25"]), said)
            self.assertIn("step(u=1.0, dt=0.01) returned", said)
            self.assertIn(words, said)

    def test_of_two_inputs_or_outputs_a_line_has_both(self):
        program = LAG.replace("y = 0.25", "y = [0.25, 0]").replace("self.y += dt * (u - self.y)", "self.y = u[1], u[0]")
        code, printed, said = run(program, "1.0,2.5\n-1e-9,0.5\n")
        self.assertEqual((code, printed), (0, ["0.25,0.0", "2.5,1.0", "0.5,-1e-09"]), said)
        code, printed, said = run(program.replace("u[1], u[0]", "u[1], 'high'"), "1.0,2.5\n")
        self.assertEqual((code, printed), (1, ["0.25,0.0"]), said)
        self.assertIn("step(u=(1.0, 2.5), dt=0.01) returned `(2.5, 'high')`; return y, a number, or two", said)

    def test_without_a_step_to_advance_by_it_says_who_should_start_it(self):
        code, _, said = run(LAG, "", WEBLOOP_H_S="")
        self.assertEqual(code, 2)
        self.assertIn("webloop serve plant", said)


if __name__ == "__main__":
    unittest.main()
