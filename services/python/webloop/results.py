"""The folder of a campaign, which `webloop run` and `webloop collect` leave, as lists and dicts.

It reads rows as they are written and makes nothing of them. What a column means is in the folder's
`datapackage.json`. The names of files are those of the crate `plan`.
"""

from __future__ import annotations

import csv
import io
import json
import os
from functools import cached_property
from importlib import import_module
from typing import Any, Callable, Dict, Iterable, List, Optional, Sequence, Tuple, Union

Row = Dict[str, Any]
"""A row by its columns; an empty field is None."""

INTEGERS = ("seq", "tick", "k", "n")
"""Columns of whole numbers, beside those whose names end with `_ns`."""

_BOOLS = {"true": True, "false": False}
_PARSE: Dict[type, Callable[[str], Any]] = {int: int, float: float, bool: _BOOLS.__getitem__, str: str}

# They tell an empty field from a number, and keep nanoseconds whole.
_PANDAS: Dict[type, str] = {int: "Int64", float: "float64", bool: "boolean", str: "object"}


class Rows(List[Row]):
    """The rows of one file, in its order."""

    def __init__(self, rows: Iterable[Row], types: Dict[str, type]) -> None:
        super().__init__(rows)
        self.types = types
        """The type of each column, in the order of the file: int, float, bool or str."""

    def to_pandas(self) -> Any:
        """The rows as a `pandas.DataFrame`. Raises `ImportError` without pandas."""
        pandas = _library("pandas")
        return pandas.DataFrame(
            {name: pandas.Series(values, dtype=_PANDAS[self.types[name]]) for name, values in self._columns()}
        )

    def to_polars(self) -> Any:
        """The rows as a `polars.DataFrame`. Raises `ImportError` without polars."""
        return _library("polars").DataFrame(dict(self._columns()), schema=self.types)

    def _columns(self) -> List[Tuple[str, List[Any]]]:
        return [(name, [row[name] for row in self]) for name in self.types]


class Cell:
    """A run of the plan. Each file is read when it is first asked for."""

    def __init__(self, folder: str) -> None:
        self.folder = folder
        self.name = os.path.basename(folder)
        """The cell's id."""

    @cached_property
    def ticks(self) -> Rows:
        """The plant's ticks."""
        return read_rows(os.path.join(self.folder, "ticks.csv"))

    @cached_property
    def second(self) -> Optional[Rows]:
        """The second input u2 and output y2 at each tick k; None for a plant that has neither."""
        path = os.path.join(self.folder, "second.csv")
        return read_rows(path) if os.path.exists(path) else None

    @cached_property
    def messages(self) -> Rows:
        """The controller's deadlines with their messages, in the order in which these ended."""
        return read_rows(os.path.join(self.folder, "messages.csv"))

    @cached_property
    def arrivals(self) -> Rows:
        """The commands that reached the plant."""
        return read_rows(os.path.join(self.folder, "arrivals.csv"))

    @cached_property
    def probes(self) -> Rows:
        """The echoes, with their predictions."""
        return read_rows(os.path.join(self.folder, "probes.csv"))


class Results:
    """A campaign."""

    def __init__(self, folder: str, cells: List[Cell]) -> None:
        self.folder = folder
        self.cells = cells
        """The cells that have a folder, in the plan's order."""

    @cached_property
    def summary(self) -> Rows:
        """A row for each cell, with its figures."""
        return read_rows(os.path.join(self.folder, "summary.csv"))


def read(folder: Union[str, os.PathLike[str]]) -> Results:
    """A campaign's folder. Raises `ValueError` if it is none."""
    path = os.fspath(folder)
    try:
        with open(os.path.join(path, "plan.json"), encoding="utf-8") as file:
            names = [str(cell["id"]) for cell in json.load(file)["cells"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ValueError(
            f"cannot read the plan.json of `{path}`: {error}; give a folder that `webloop run` or"
            " `webloop collect` left"
        ) from None
    folders = [os.path.join(path, "cells", name) for name in names]
    return Results(path, [Cell(cell) for cell in folders if os.path.isdir(cell)])


def read_rows(path: str) -> Rows:
    """The rows of any such file. A last line that a killed run left unfinished is dropped.

    Raises `OSError`, or `ValueError` if the file is damaged.
    """
    with open(path, encoding="utf-8", newline="") as file:
        text = file.read()
    lines = list(csv.reader(io.StringIO(text[: text.rfind("\n") + 1], newline="")))
    header = lines[0] if lines else []
    for number, line in enumerate(lines, 1):
        if len(line) != len(header):
            what = f"line {number} has {len(line)} fields for {len(header)} columns"
            raise ValueError(f"{path} is damaged: {what}; run it again")
    typed = [_typed(path, name, [line[place] for line in lines[1:]]) for place, name in enumerate(header)]
    rows = (dict(zip(header, values)) for values in zip(*(values for _, values in typed)))
    return Rows(rows, {name: kind for name, (kind, _) in zip(header, typed)})


def _typed(path: str, name: str, fields: Sequence[str]) -> Tuple[type, List[Any]]:
    """A column's type, and its values: whole numbers by its name, else the first type that fits."""
    is_whole = name in INTEGERS or name.endswith("_ns")
    kinds: Sequence[type] = (int,) if is_whole else (float, bool, str)
    for kind in kinds:
        try:
            return kind, [_PARSE[kind](field) if field else None for field in fields]
        except (ValueError, KeyError):
            continue
    raise ValueError(f"{path} is damaged: `{name}` is not a whole number in each row; run it again")


def _library(name: str) -> Any:
    try:
        return import_module(name)
    except ImportError as error:
        raise ImportError(f"`to_{name}` needs {name} ({error}); `pip install {name}` installs it") from None
