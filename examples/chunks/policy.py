"""A policy that answers with a chunk of commands, as policies of robots do.

It shows how a loop fares whose policy looks at y only every N samples. At a look it predicts the motor
from y on under the paper's PI, and so plans the next N commands. They are sent one each h, also while
answers are late; then the next chunk replaces them. The model is the motor itself, so only what it does
not know, such as the link's delay and what is lost, waits for the next look. Try another N or model.
"""

import sys

import webloop

N = int(sys.argv[1]) if len(sys.argv) > 1 else 8  # commands of a chunk; with 1 it is the plain PI
KP, KI = 0.1701, 0.378  # the paper's PI
B0, C0, C1 = 2029.826, 26.29, 2.296  # the motor, B0 / ((s + C0) (s + C1))


class Policy:
    def __init__(self):
        self.chunk = []
        self.integral = 0.0
        self.x = 0.0  # the motor's fast state, y' + C1 y, by the model

    def update(self, r, y, dt):
        if not self.chunk:
            self.chunk = self.plan(r, y, dt)
        return self.chunk.pop(0)

    def plan(self, r, y, h):
        """The next N commands, if the plant's output is y now."""
        chunk = []
        for _ in range(N):
            e = r - y
            self.integral += KI * h * e
            u = KP * e + self.integral
            self.x = (self.x + h * B0 * u) / (1.0 + h * C0)  # backward Euler, as the plant is sampled
            y = (y + h * self.x) / (1.0 + h * C1)
            chunk.append(u)
        return chunk


webloop.control(Policy())
