"""The paper's PI controller for the motor, with Python's standard library alone: a request at a time,
on one kept connection, at the deadlines start + k h. Deadlines that pass while an answer is late are
skipped, and the integral advances by them too.
"""
import http.client
import os
import time

if os.environ["WEBLOOP_MODE"] != "closed":
    raise SystemExit(127)  # an open loop is not supported
h, r, duration = (float(os.environ[f"WEBLOOP_{name}"]) for name in ("H_S", "R", "DURATION_S"))
start = int(os.environ["WEBLOOP_START_NS"]) / 1e9
plant = http.client.HTTPConnection(os.environ["WEBLOOP_PLANT"].removeprefix("http://"), timeout=5)


def get(path, y):
    """The output that the plant answers; y if it answers none."""
    try:
        plant.request("GET", path)
        text = plant.getresponse().read().decode("latin-1")
    except (OSError, http.client.HTTPException):
        plant.close()  # the next request connects again
        return y
    _, found, rest = text.partition("&y=")
    return float(rest.partition("&")[0]) if found else y


y, integral, k, passed = 0.0, 0.0, 0, 1
while plant.sock is None and time.monotonic() < start - 0.05:
    y = get("/state", y)
    time.sleep(0.02)
while True:
    time.sleep(max(0.0, start + k * h - time.monotonic()))
    if k * h >= duration:
        break
    e = r - y
    integral += 0.378 * (passed * h) * e
    y = get("/closed?u=" + repr(0.1701 * e + integral).replace("+", ""), y)
    passed = max(1, int((time.monotonic() - start) / h) - k)
    k += passed
