"""The reader of results: what a field becomes, which cells there are, and what is damaged."""

import pathlib
import sys
import tempfile
import types
import unittest
from unittest import mock

from webloop.results import read

FILES = {
    "plan.json": '{"cells": [{"id": "b-1"}, {"id": "a-2"}, {"id": "a-3"}]}',
    "summary.csv": (
        "cell,rate,h_ns,repeat,settling_ms,disturbed,rise_ms\n"
        "b-1,333 Hz,3000000,1,318.5,,\n"
        'a-2,333 Hz,3000000,2,,"plant, 3 ms",\n'
    ),
    "cells/b-1/ticks.csv": "k,t_due_ns,t_tick_ns,u,y,seq\n0,9007199254740993,10,0.1,1e-9,\n1,12,13,1,0,7\n",
    "cells/b-1/second.csv": "k,u2,y2\n0,0.5,\n1,0,\n",
    "cells/b-1/messages.csv": "seq,t_due_ns,t_send_ns,u,tick,outcome\n0,12,,,,missed\n1,15,16,0.5,3,answered\n2,18,1",
    "cells/b-1/arrivals.csv": "n,seq,u,outcome\n",
    "cells/b-1/probes.csv": "phase,seq,t_back_ns,due_lost\nempty,0,5,false\nduring,1,,true\n",
    "cells/a-2/ticks.csv": "k,u\n0,0.5\n1\n",
    "cells/a-2/arrivals.csv": "n,u\n0.5,0.5\n",
    "cells/a-2.unfinished-1/ticks.csv": "k\n",
}


class Folders(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        for name, text in FILES.items():
            path = self.folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
        self.results = read(self.folder)

    def test_columns_have_types_and_empty_fields_are_none(self):
        cell = self.results.cells[0]
        first = {"k": 0, "t_due_ns": 2**53 + 1, "t_tick_ns": 10, "u": 0.1, "y": 1e-9, "seq": None}
        second = {"k": 1, "t_due_ns": 12, "t_tick_ns": 13, "u": 1.0, "y": 0.0, "seq": 7}
        self.assertEqual(cell.ticks, [first, second])
        self.assertEqual([type(value) for value in cell.ticks[1].values()], [int, int, int, float, float, int])
        self.assertEqual(
            cell.probes,
            [
                {"phase": "empty", "seq": 0, "t_back_ns": 5, "due_lost": False},
                {"phase": "during", "seq": 1, "t_back_ns": None, "due_lost": True},
            ],
        )
        self.assertEqual(cell.second, [{"k": 0, "u2": 0.5, "y2": None}, {"k": 1, "u2": 0.0, "y2": None}])
        self.assertIsNone(self.results.cells[1].second)
        self.assertEqual((cell.arrivals, list(cell.arrivals.types)), ([], ["n", "seq", "u", "outcome"]))
        self.assertEqual(
            self.results.summary[1],
            {
                "cell": "a-2",
                "rate": "333 Hz",
                "h_ns": 3_000_000,
                "repeat": 2.0,
                "settling_ms": None,
                "disturbed": "plant, 3 ms",
                "rise_ms": None,
            },
        )

    def test_the_unfinished_last_line_of_a_killed_run_is_dropped(self):
        messages = self.results.cells[0].messages
        self.assertEqual([row["outcome"] for row in messages], ["missed", "answered"])
        self.assertEqual(messages[0]["u"], None)

    def test_cells_are_those_of_the_plan_that_have_a_folder_in_its_order(self):
        self.assertEqual([cell.name for cell in self.results.cells], ["b-1", "a-2"])

    def test_what_is_not_there_or_damaged_is_said_with_its_path(self):
        with self.assertRaises(ValueError) as raised:
            read(self.folder / "cells")
        self.assertIn("`webloop run`", str(raised.exception))
        damaged = self.results.cells[1]
        with self.assertRaises(ValueError) as raised:
            _ = damaged.ticks
        self.assertIn("ticks.csv is damaged: line 3 has 1 fields for 2 columns", str(raised.exception))
        with self.assertRaises(ValueError) as raised:
            _ = damaged.arrivals
        self.assertIn("arrivals.csv is damaged: `n` is not a whole number", str(raised.exception))
        with self.assertRaises(FileNotFoundError):
            _ = damaged.messages

    def test_a_library_is_imported_when_it_is_asked_for(self):
        rows = self.results.cells[0].ticks
        for library, convert in [("pandas", rows.to_pandas), ("polars", rows.to_polars)]:
            with mock.patch.dict(sys.modules, {library: None}), self.assertRaises(ImportError) as raised:
                convert()
            self.assertIn(f"`pip install {library}`", str(raised.exception))

    def test_a_library_gets_columns_with_their_types(self):
        rows = self.results.cells[0].ticks
        made = {name: [row[name] for row in rows] for name in rows[0]}
        polars = types.SimpleNamespace(DataFrame=lambda columns, schema: (columns, schema))
        with mock.patch.dict(sys.modules, {"polars": polars}):
            columns, schema = rows.to_polars()
        self.assertEqual(columns, made)
        self.assertEqual(schema, {"k": int, "t_due_ns": int, "t_tick_ns": int, "u": float, "y": float, "seq": int})
        pandas = types.SimpleNamespace(DataFrame=dict, Series=lambda values, dtype: (values, dtype))
        with mock.patch.dict(sys.modules, {"pandas": pandas}):
            frame = rows.to_pandas()
        self.assertEqual(frame["seq"], (made["seq"], "Int64"))
        self.assertEqual(frame["u"], (made["u"], "float64"))


if __name__ == "__main__":
    unittest.main()
