"""A step with http.client on a kept connection; figures of how long each took."""

import http.client
import sys
import time

host, port, path, measure_ms = sys.argv[1:]
connection = http.client.HTTPConnection(host, int(port))


def step():
    connection.request("GET", path)
    return connection.getresponse().read()


for _ in range(300):
    step()
took = []
end = time.monotonic() + float(measure_ms) / 1000
while time.monotonic() < end:
    begun = time.monotonic_ns()
    step()
    took.append(time.monotonic_ns() - begun)
took.sort()
for name, share in ("p50_us", 0.5), ("p99_us", 0.99), ("p99.9_us", 0.999):
    print(name, took[int((len(took) - 1) * share)] / 1000)
