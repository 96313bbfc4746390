# SPDX-License-Identifier: BSD-3-Clause
"""The results of `hils` in its folder (docs/reference/config.md, Results), read on demand."""

from __future__ import annotations

import functools
import json
from pathlib import Path
from typing import Any, Union

from .errors import FormatError
from .table import Table, read_csv
from .tlog import Tlog
from .ulog import Ulog

#: Of the summary.json that hils of this version writes.
SUMMARY_SCHEMA = 2


class Run:
    """The folder of one run.

    `summary` is summary.json; `vehicle(NAME)` has the figures of one vehicle, and `truth`, `sensors` and `ulog` are the
    first's.
    """

    def __init__(self, folder: Union[str, Path], exit_code: int = 0, output: str = "") -> None:
        self.folder = Path(folder)
        #: Of the `hils` that made it; 0 where it was read from a folder.
        self.exit_code = exit_code
        self.output = output
        if not (self.folder / "summary.json").is_file():
            raise FormatError(f"there is no run in {self.folder}: no summary.json. `hils run SCENARIO --out "
                              f"{self.folder}` makes one")

    @functools.cached_property
    def summary(self) -> dict[str, Any]:
        """Verdict, pace and the list of vehicles: `passed`, `failures`, `wall_s`, `vehicles`, ..."""
        file = self.folder / "summary.json"
        summary: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        if summary.get("schema") != SUMMARY_SCHEMA:
            raise FormatError(f"{file} has schema {summary.get('schema')}, and this package reads {SUMMARY_SCHEMA}: fly "
                              "the scenario again")
        return summary

    @property
    def passed(self) -> bool:
        """Whether the run is valid and every limit was kept."""
        return bool(self.summary["passed"])

    @property
    def valid(self) -> bool:
        """Whether the machine kept up and the accounts close."""
        return bool(self.summary["valid"])

    @property
    def vehicles(self) -> list[str]:
        """The names of the vehicles."""
        return [each["name"] for each in self.summary["vehicles"]]

    def vehicle(self, name: str = "") -> dict[str, Any]:
        """Verdict and figures of one vehicle, the first without a name: `passed`, `rates`, `rms`, `latency_us`, ..."""
        for each in self.summary["vehicles"]:
            if name in ("", each["name"]):
                found: dict[str, Any] = each
                return found
        raise KeyError(f"the run has no vehicle {name}; it has {', '.join(self.vehicles)}")

    def _of(self, stem: str, suffix: str, name: str) -> Path:
        own = self.vehicle(name)["name"]
        return self.folder / (f"{stem}_{own}{suffix}" if len(self.vehicles) > 1 else stem + suffix)

    def truth_of(self, name: str = "") -> Table:
        """True motion at 100 Hz: `time_s`, x north, y east, z up (m), velocity, roll, pitch, yaw (rad, forward-
        right-down against north-east-down), body rates, rotor speeds."""
        return read_csv(self._of("truth", ".csv", name))

    @functools.cached_property
    def truth(self) -> Table:
        """truth_of() the first vehicle."""
        return self.truth_of()

    @functools.cached_property
    def sensors(self) -> dict[str, Table]:
        """Every sample of every sensor and every motor command, by file: "imu", "gps", ..."""
        folder = self._of("sensors", "", "")
        return {path.stem: read_csv(path) for path in sorted(folder.glob("*.csv"))}

    @functools.cached_property
    def tlog(self) -> Tlog:
        """flight.tlog: the vehicles' messages."""
        return Tlog(self.folder / "flight.tlog")

    @functools.cached_property
    def ulog(self) -> Ulog:
        """flight.ulg: the run under the names of PX4's logger."""
        return Ulog(self._of("flight", ".ulg", ""))

    @functools.cached_property
    def plugin_figures(self) -> dict[str, Any]:
        """Figures of plugins; empty if there are none."""
        file = self.folder / "plugin_figures.json"
        figures: dict[str, Any] = json.loads(file.read_text(encoding="utf-8")) if file.is_file() else {}
        return figures

    def packets(self, program: str) -> Table:
        """A packet ledger of run/, by its stem: each HIL packet's moments at one program."""
        return read_csv(self.folder / "run" / f"{program}.csv")

    def __repr__(self) -> str:
        return f"Run({str(self.folder)!r}, {'passed' if self.passed else 'not passed'})"


class Comparison:
    """The folder of `hils compare`; `figures` is comparison.json."""

    def __init__(self, folder: Union[str, Path], exit_code: int = 0, output: str = "") -> None:
        self.folder = Path(folder)
        self.exit_code = exit_code
        self.output = output
        file = self.folder / "comparison.json"
        if not file.is_file():
            raise FormatError(f"there is no comparison in {self.folder}: no comparison.json. `hils compare SCENARIO "
                              f"--out {self.folder}` makes one")
        self.figures: Any = json.loads(file.read_text(encoding="utf-8"))


class Sweep:
    """The folder of `hils sweep` (docs/use/sweep.md)."""

    def __init__(self, folder: Union[str, Path], exit_code: int = 0, output: str = "") -> None:
        self.folder = Path(folder)
        self.exit_code = exit_code
        self.output = output
        if not (self.folder / "results.csv").is_file():
            raise FormatError(f"there is no collected sweep in {self.folder}: no results.csv. `hils sweep collect "
                              f"{self.folder}` makes it")

    @functools.cached_property
    def runs(self) -> Table:
        """A row a run: `row`, `point`, `seed`, the parameters, `outcome`, `up`, and the figures; what a run has not is
        not a number."""
        plan = self.folder / "plan.json"
        figures = json.loads(plan.read_text(encoding="utf-8")).get("figures", []) if plan.is_file() else []
        return read_csv(self.folder / "results.csv", numbers=set(figures))

    @functools.cached_property
    def machine(self) -> Table:
        """Cost and host of each run."""
        return read_csv(self.folder / "machine.csv")


class Tuning:
    """The folder of `hils tune` (docs/use/tune.md)."""

    def __init__(self, folder: Union[str, Path], exit_code: int = 0, output: str = "") -> None:
        self.folder = Path(folder)
        self.exit_code = exit_code
        self.output = output
        if not (self.folder / "candidates.csv").is_file():
            raise FormatError(f"there is no tuning in {self.folder}: no candidates.csv. `hils tune STUDY --out "
                              f"{self.folder}` makes one")

    @functools.cached_property
    def candidates(self) -> Table:
        """A row a candidate: its values, objectives, guards, `penalty`, `weighted_sum`; the first is the one before."""
        return read_csv(self.folder / "candidates.csv")

    @functools.cached_property
    def front(self) -> Table:
        """Those of them that hold all guards and are beaten by no other in all objectives."""
        return read_csv(self.folder / "front.csv")

    @functools.cached_property
    def gains(self) -> dict[str, float]:
        """The vehicle's parameters of the best candidate, by name."""
        lines = (self.folder / "gains.params").read_text(encoding="utf-8").split("\n")
        return {name: float(value) for name, value in (line.split() for line in lines if line)}


def read(path: Union[str, Path]) -> Any:
    """Reads a results folder of any kind: a run's folder (Run), a comparison's (Comparison), a sweep's (Sweep), a tuning's (Tuning), a
    .tlog (Tlog), a .ulg (Ulog), a .csv (Table)."""
    path = Path(path)
    if path.is_dir():
        if (path / "comparison.json").is_file():
            return Comparison(path)
        if (path / "candidates.csv").is_file():
            return Tuning(path)
        return Sweep(path) if (path / "plan.json").is_file() else Run(path)
    readers: dict[str, Any] = {".tlog": Tlog, ".ulg": Ulog, ".csv": read_csv}
    if path.suffix in readers and path.is_file():
        return readers[path.suffix](path)
    if not path.exists():
        raise FormatError(f"there is no {path}")
    raise FormatError(f"{path} is nothing that cas reads: a folder of hils, .tlog, .ulg or .csv")
