"""Two PI controllers side by side, for a plant with two inputs and two outputs: plants/tanks.toml."""

import webloop


class Two:
    def __init__(self):
        self.integrals = [0.0, 0.0]

    def update(self, r, y, dt):
        errors = [r - y[0], 0.5 - y[1]]
        for k, e in enumerate(errors):
            self.integrals[k] += 2.0 * dt * e
        return [3.0 * e + i for e, i in zip(errors, self.integrals)]


webloop.control(Two())
