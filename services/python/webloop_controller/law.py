"""The paper's control law: PI by backward Euler, (a0 s + a1)/s.

A port of the crate `control`'s `Pid` without what the paper's law does not
have: no derivative, no saturation.
"""

from __future__ import annotations

from math import isfinite

PAPER_A0 = 0.1701
"""Proportional gain of the paper's controller."""

PAPER_A1 = 0.378
"""Integral gain of the paper's controller, 1/s."""


class PI:
    """A running controller, at rest when new."""

    __slots__ = ("kp", "ki", "integral", "output")

    def __init__(self, kp: float, ki: float) -> None:
        self.kp = kp
        self.ki = ki
        self.integral = 0.0
        self.output = 0.0

    def update(self, e: float, dt_s: float) -> float:
        """One update with error e = r - y, `dt_s` after the last: the command u.

        The integral includes the error of the same update, as backward Euler
        has it. An `e` that is not finite, a `dt_s` that is not positive and
        finite, and an update whose result would not be finite change nothing:
        the last command is returned again (0 before the first).
        """
        if not (isfinite(e) and isfinite(dt_s) and dt_s > 0.0):
            return self.output
        integral = self.integral + self.ki * dt_s * e
        output = self.kp * e + integral
        if isfinite(integral) and isfinite(output):
            self.integral = integral
            self.output = output
        return self.output


def paper_pi() -> PI:
    """The paper's controller at rest."""
    return PI(PAPER_A0, PAPER_A1)
