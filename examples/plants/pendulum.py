"""An inverted pendulum that can fall: theta'' = g/l sin theta - d theta' + u, by Runge and Kutta.

y is the angle from upright in rad. The input u is a torque over mass and length squared, and no motor
gives more than 30 of it, so once it has fallen beyond some angle it is lost.
"""

from math import sin

import webloop

G_OVER_L, DAMPING, U_MAX = 9.81, 0.1, 30.0


class Pendulum:
    y = 0.0

    def __init__(self):
        self.rate = 0.0

    def step(self, u, dt):
        u = max(-U_MAX, min(U_MAX, u))

        def change(angle, rate):
            return rate, G_OVER_L * sin(angle) - DAMPING * rate + u

        angle, rate = self.y, self.rate
        a1, r1 = change(angle, rate)
        a2, r2 = change(angle + dt / 2 * a1, rate + dt / 2 * r1)
        a3, r3 = change(angle + dt / 2 * a2, rate + dt / 2 * r2)
        a4, r4 = change(angle + dt * a3, rate + dt * r3)
        self.y += dt / 6 * (a1 + 2 * a2 + 2 * a3 + a4)
        self.rate += dt / 6 * (r1 + 2 * r2 + 2 * r3 + r4)
        return self.y


webloop.plant(Pendulum())
