"""The paper's DC motor, b0 / ((s + c0) (s + c1)), as a plant of one's own: it steps as the built-in one."""

import webloop


class Motor:
    x = y = 0.0

    def step(self, u, dt):
        self.x = (self.x + dt * 2029.826 * u) / (1 + dt * 26.29)  # backward Euler, as in the paper
        self.y = (self.y + dt * self.x) / (1 + dt * 2.296)
        return self.y


webloop.plant(Motor())
