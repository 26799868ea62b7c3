"""Reads a run's rows with two figures of them, and writes its messages again, with polars or csv; MB/s."""

import os
import sys
import tempfile
import time

os.environ["POLARS_MAX_THREADS"] = "1"
way, folder = sys.argv[1:]
FILES = [os.path.join(folder, name) for name in ("ticks.csv", "arrivals.csv", "messages.csv")]


def polars(target):
    import polars

    # What it does once is not measured.
    polars.read_csv(FILES[0])
    begun = time.monotonic()
    frames = [polars.read_csv(path) for path in FILES]
    frames[0].select(polars.col("y").max())
    frames[2].select((polars.col("t_receive_ns") - polars.col("t_send_ns")).quantile(0.99))
    read = time.monotonic()
    frames[2].write_csv(target)
    return begun, read, time.monotonic()


def csv(target):
    import csv

    begun = time.monotonic()
    tables = []
    for path in FILES:
        with open(path, newline="") as file:
            tables.append(list(csv.DictReader(file)))
    max(float(row["y"]) for row in tables[0])
    took = (int(row["t_receive_ns"]) - int(row["t_send_ns"]) for row in tables[2] if row["t_receive_ns"])
    took = sorted(took)
    took[int(0.99 * len(took))]
    read = time.monotonic()
    with open(target, "w", newline="") as file:
        writer = csv.DictWriter(file, tables[2][0].keys(), lineterminator="\n")
        writer.writeheader()
        writer.writerows(tables[2])
    return begun, read, time.monotonic()


with tempfile.TemporaryDirectory() as place:
    target = os.path.join(place, "messages.csv")
    begun, read, written = {"polars": polars, "csv": csv}[way](target)
    print("read_mb_s", sum(map(os.path.getsize, FILES)) / 1e6 / (read - begun))
    print("write_mb_s", os.path.getsize(target) / 1e6 / (written - read))
