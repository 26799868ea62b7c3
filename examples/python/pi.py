"""The paper's PI controller for the motor, with the package webloop."""

import webloop


class Pi:
    integral = 0.0

    def update(self, r, y, dt):
        e = r - y
        self.integral += 0.378 * dt * e
        return 0.1701 * e + self.integral


webloop.control(Pi())
