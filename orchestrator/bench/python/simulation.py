"""The paper's loop at 1 kHz in virtual time, without a network: how many seconds of it a second has."""

import sys
import time

H = 0.001
# The motor B0 / ((s + C0) (s + C1)), and the law (A0 s + A1) / s.
B0, C0, C1 = 2029.826, 26.29, 2.296
A0, A1 = 0.1701, 0.378


def plain(seconds):
    """By backward Euler, as the paper has it, with the command of the tick before."""
    y1 = y2 = integral = u = 0.0
    gain = 1.0 / (1.0 + (C0 + C1) * H + C0 * C1 * H * H)
    b0, a1, a2 = B0 * H * H * gain, (2.0 + (C0 + C1) * H) * gain, gain
    rows = []
    for k in range(int(seconds / H)):
        y = b0 * u + a1 * y1 - a2 * y2
        y1, y2 = y, y1
        e = 1.0 - y
        integral += e * H
        u = A0 * e + A1 * integral
        rows.append((k, k * H, u, y))
    return rows


def with_control(seconds):
    """With python-control's functions, whose closed loop has no delay."""
    import control
    import numpy

    motor = control.tf([B0], [1.0, C0 + C1, C0 * C1])
    law = control.tf([A0, A1], [1.0, 0.0])
    loop = control.ss(control.feedback(control.c2d(motor, H) * control.c2d(law, H)))
    t = numpy.arange(0, seconds, H)
    return control.input_output_response(loop, t, numpy.ones_like(t))


way = sys.argv[1]
run, seconds = (plain, 100.0) if way == "plain" else (with_control, 5.0)
if way != "plain":
    import control as _
begun = time.monotonic()
run(seconds)
print("x_real", seconds / (time.monotonic() - begun))
