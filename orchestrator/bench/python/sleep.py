"""Ticks every millisecond with time.sleep until the next deadline; figures of how late each was."""

import sys
import time

H_NS = 1_000_000
count = int(sys.argv[1])
start = time.monotonic_ns() + 10 * H_NS
ticks = []
for k in range(count):
    due = start + k * H_NS
    left = due - time.monotonic_ns()
    if left > 0:
        time.sleep(left / 1e9)
    ticks.append(time.monotonic_ns())
late = sorted(tick - start - k * H_NS for k, tick in enumerate(ticks))
gaps = [after - before for before, after in zip(ticks, ticks[1:])]
mean = sum(gaps) / len(gaps)
for name, share in ("p50_us", 0.5), ("p99_us", 0.99), ("p99.9_us", 0.999):
    print(name, late[int((len(late) - 1) * share)] / 1000)
print("sd_us", (sum((gap - mean) ** 2 for gap in gaps) / len(gaps)) ** 0.5 / 1000)
