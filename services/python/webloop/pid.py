"""PI and PID control by backward Euler: kp + ki/s + kd N s/(s + N), and limits.

A port of the crate `control`'s `pid`, sum by sum in the same order, so that
both give the same bits. What a law may be is checked in `law`.
"""

from __future__ import annotations

from math import inf, isfinite
from typing import NamedTuple, Optional

from webloop.message import Moment, Signal, first

OFF = "off"
"""The integral goes on while the command is limited, and winds up."""

CONDITIONAL = "conditional"
"""It stands still while the error would drive the command further past its limit."""

BACK_CALCULATION = "back-calculation"
"""It is driven back by a gain times the part of the command that was cut off."""


class Limits(NamedTuple):
    """Limits of the actuator."""

    min: float = -inf
    """The smallest command; infinite for none."""
    max: float = inf
    """The largest command; infinite for none."""
    anti_windup: str = OFF
    """off, conditional or back-calculation: what an integral does at a limit."""
    gain_per_s: float = 0.0
    """The tracking gain of back-calculation, 1/s."""

    def clip(self, value: float) -> float:
        """The nearest value within; what is not a number stays that."""
        if value < self.min:
            return self.min
        return self.max if value > self.max else value


class Gains(NamedTuple):
    """Gains of the parallel form."""

    kp: float
    """Proportional gain."""
    ki: float
    """Integral gain, 1/s."""
    kd: float = 0.0
    """Derivative gain, s."""
    filter_rad_s: float = inf
    """N, the pole of the derivative's filter; infinite for the plain difference."""


class Pid:
    """A running controller, at rest when new."""

    __slots__ = (
        "gains",
        "limits",
        "_kp",
        "_ki",
        "_plain",
        "_integral",
        "_derivative",
        "_error",
        "_output",
    )

    def __init__(self, gains: Gains, limits: Optional[Limits] = None) -> None:
        self.gains = gains
        self.limits = limits
        self._kp = gains.kp
        self._ki = gains.ki
        # The paper's PI pays for nothing that it does not have.
        self._plain = gains.kd == 0.0 and limits is None
        self._integral = 0.0
        self._derivative = 0.0
        self._error = 0.0
        self._output = 0.0

    def update(
        self, r: float, y: Signal, dt_s: float, times: Optional[Moment] = None
    ) -> float:
        """One update with error e = r - y, `dt_s` after the last: the command u.
        Of two outputs y is the first.

        The integral includes the error of the same update, as backward Euler
        has it. An `e` that is not finite, a `dt_s` that is not positive and
        finite, and an update whose result would not be finite change nothing:
        the last command is returned again (0 before the first).
        """
        e = r - first(y)
        if not (isfinite(e) and isfinite(dt_s) and dt_s > 0.0):
            return self._output
        integral = self._integral + self._ki * dt_s * e
        output = self._kp * e + integral
        if not self._plain:
            return self._whole(e, dt_s, integral, output)
        if isfinite(integral) and isfinite(output):
            self._integral = integral
            self._output = output
        return self._output

    def _whole(self, e: float, dt_s: float, integral: float, pi: float) -> float:
        """The rest of an update, with a derivative, limits, or both."""
        derivative = 0.0 if self.gains.kd == 0.0 else self._differentiated(e, dt_s)
        wanted = output = pi + derivative
        limits = self.limits
        if limits is not None:
            output = limits.clip(wanted)
            if limits.anti_windup == CONDITIONAL:
                if (wanted - output) * self._ki * e > 0.0:
                    integral = self._integral
            elif limits.anti_windup == BACK_CALCULATION:
                pull = limits.gain_per_s * dt_s
                integral += pull / (1.0 + pull) * (output - wanted)
        if isfinite(integral) and isfinite(derivative) and isfinite(output):
            self._integral = integral
            self._derivative = derivative
            self._error = e
            self._output = output
        return self._output

    def _differentiated(self, e: float, dt_s: float) -> float:
        """kd N s/(s + N) by backward Euler, divided by N, so that an infinite N
        leaves the difference quotient."""
        kd, lag_s = self.gains.kd, 1.0 / self.gains.filter_rad_s
        return (lag_s * self._derivative + kd * (e - self._error)) / (lag_s + dt_s)
