# SPDX-License-Identifier: BSD-3-Clause
"""Columns of numbers: NumPy arrays where NumPy is there, else array.array."""

from __future__ import annotations

import array
import bisect
import csv
import io
import math
from pathlib import Path
from typing import Any, Collection, Iterable, Iterator, Mapping, Sequence, Union

from .errors import FormatError
from .log_bytes import read_log

try:
    import numpy
except ImportError:  # the package works without
    numpy = None  # type: ignore[assignment]

HAS_NUMPY = numpy is not None


def column(values: Iterable[Any]) -> Any:
    """Numbers as a NumPy array of floats, or array.array("d"); anything else as a list."""
    if not isinstance(values, array.array):
        values = list(values)
        if values and not all(isinstance(value, (int, float)) for value in values):
            return values
    return numpy.array(values, dtype=float) if HAS_NUMPY else array.array("d", values)


class Table(Mapping[str, Any]):
    """Columns by name, all of one length: `table["time_s"]`. len(table) is the number of columns, `rows` that of
    the rows."""

    def __init__(self, columns: Mapping[str, Iterable[Any]]) -> None:
        self._columns = {name: column(values) for name, values in columns.items()}
        lengths = {len(values) for values in self._columns.values()}
        if len(lengths) > 1:
            raise ValueError("columns of a table have one length")
        #: How many rows there are.
        self.rows: int = lengths.pop() if lengths else 0

    def __getitem__(self, name: str) -> Any:
        try:
            return self._columns[name]
        except KeyError:
            raise KeyError(f"there is no column {name}; there are {', '.join(self._columns)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def row(self, index: int) -> dict[str, Any]:
        """One row by its place."""
        return {name: values[index] for name, values in self._columns.items()}

    def each(self) -> Iterator[dict[str, Any]]:
        """All rows, in order."""
        return (self.row(index) for index in range(self.rows))

    def at(self, name: str, time_s: float, clock: str = "time_s") -> float:
        """Column `name` at a time, s, linear between the two rows around it; the nearest outside of them."""
        times = self[clock]
        values = self[name]
        after = bisect.bisect_left(times, time_s)
        if after == 0:
            return float(values[0])
        if after == self.rows:
            return float(values[-1])
        share = (time_s - times[after - 1]) / (times[after] - times[after - 1])
        return float(values[after - 1] + share * (values[after] - values[after - 1]))

    def between(self, begin_s: float, end_s: float, clock: str = "time_s") -> "Table":
        """The rows from `begin_s` to `end_s`, s, both included."""
        times = self[clock]
        first = bisect.bisect_left(times, begin_s)
        last = bisect.bisect_right(times, end_s)
        return Table({name: values[first:last] for name, values in self._columns.items()})

    def __repr__(self) -> str:
        return f"Table({self.rows} rows: {', '.join(self._columns)})"


def _numbers(texts: list[str]) -> Sequence[Any]:
    """As numbers where all are, an empty cell being not a number; else as they are."""
    try:
        numbers = [float(text) if text else math.nan for text in texts]
    except ValueError:
        return texts
    if texts and not any(texts):
        return texts
    return numbers


def read_csv(path: Union[str, Path], numbers: Collection[str] = ()) -> Table:
    """A CSV file with a head, as CAS writes it. An empty cell among numbers is not a number; a column in which all are
    empty is text, unless `numbers` names it."""
    rows = csv.reader(io.StringIO(read_log(Path(path)).decode("utf-8-sig"), newline=""))
    head = next(rows, None)
    if head is None:
        raise FormatError(f"{path} is empty")
    columns: list[list[str]] = [[] for _ in head]
    for row in rows:
        if len(row) != len(head):
            break  # of a run that was cut off in the middle of a line
        for values, text in zip(columns, row):
            values.append(text)
    return Table({name: [math.nan] * len(texts) if name in numbers and not any(texts) else _numbers(texts)
                  for name, texts in zip(head, columns)})


def rms(values: Iterable[float]) -> float:
    """Root of the mean square; not a number of nothing."""
    squares = [value * value for value in values]
    return math.sqrt(sum(squares) / len(squares)) if squares else math.nan


def quantile(values: Sequence[float], share: float) -> float:
    """The value that `share` (0 to 1) of the values do not exceed; not a number of nothing."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, math.ceil(share * len(ordered)) - 1 if share > 0 else 0)] if ordered else math.nan


def text_table(head: Sequence[str], rows: Iterable[Sequence[Any]]) -> str:
    """Rows under a head, in columns, for a terminal without pictures."""
    cells = [[str(each) for each in head]]
    cells += [[f"{each:.4g}" if isinstance(each, float) else str(each) for each in row] for row in rows]
    widths = [max(len(row[i]) for row in cells) for i in range(len(head))]
    return "\n".join("  ".join(text.rjust(width) for text, width in zip(row, widths)) for row in cells)
