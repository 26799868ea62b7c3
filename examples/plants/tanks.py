"""Two tanks with a pump each, which exchange a part of what they differ by: two inputs, two outputs."""

import webloop


class Tanks:
    y = (0.0, 0.0)  # the levels

    def step(self, u, dt):
        left, right = self.y
        across = 0.3 * (left - right)
        self.y = (
            left + dt * (u[0] - 0.5 * left - across),
            right + dt * (2.0 * u[1] - 0.2 * right + across),
        )
        return self.y


webloop.plant(Tanks())
