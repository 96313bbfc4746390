# SPDX-License-Identifier: BSD-3-Clause
"""Starts `hils`, reports its progress, waits, and reads its results."""

from __future__ import annotations

import json
import os
import re
import signal
import subprocess
import tempfile
import threading
from pathlib import Path
from typing import Any, Callable, Generic, Mapping, Optional, Sequence, TypeVar, Union

from .errors import RUN_ERRORS, CallTimeout, CasError, FormatError, RunError
from .places import program
from .results import Comparison, Run, Sweep, Tuning

Scenario = Union[str, "os.PathLike[str]", Mapping[str, Any]]
"""A scenario's file, or its keys (docs/reference/config.md, Scenario) in a dict."""

Progress = Callable[[str], None]
R = TypeVar("R", Run, Comparison, Sweep, Tuning)

_STOP_PATIENCE_S = 20.0


class Running(Generic[R]):
    """A `hils` that has been started. wait() gives its results; leaving a `with` block early interrupts it."""

    def __init__(self, verb: str, scenario: Scenario, out: Union[str, "os.PathLike[str]"], flags: Sequence[str],
                 read: Callable[[Path, int, str], R], progress: Optional[Progress] = None) -> None:
        self.out = Path(out)
        self._read: Callable[[Path, int, str], R] = read
        self._progress = progress
        hils = program("hils")
        self._folder = tempfile.TemporaryDirectory(prefix="cas-run-")
        self.command = [hils, verb, self._scenario_file(scenario), "--out", str(self.out), *flags]
        self._lines: list[str] = []
        self._process = subprocess.Popen(self.command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                         stderr=subprocess.STDOUT, text=True, errors="replace", process_group=0)
        self._reader = threading.Thread(target=self._follow, daemon=True)
        self._reader.start()

    def _scenario_file(self, scenario: Scenario) -> str:
        if not isinstance(scenario, Mapping):
            return os.fspath(scenario)
        name = re.sub(r"[^\w.-]", "_", str(scenario.get("name", "")))[:100].strip(".") or "scenario"
        file = Path(self._folder.name) / f"{name}.yaml"
        file.write_text(json.dumps(dict(scenario), indent=1), encoding="utf-8")  # JSON is YAML
        return str(file)

    def _follow(self) -> None:
        assert self._process.stdout is not None
        with self._process.stdout as lines:
            for line in lines:
                self._lines.append(line)
                if self._progress is not None:
                    self._progress(line.rstrip("\n"))

    @property
    def done(self) -> bool:
        """Whether it has ended."""
        return self._process.poll() is not None

    @property
    def output(self) -> str:
        """Its output so far."""
        return "".join(self._lines)

    def wait(self, timeout_s: Optional[float] = None, check: bool = True) -> R:
        """Waits for the end and reads the results.

        Raises LimitMissed, WrongUse, NoVerdict or Interrupted by its exit code; with `check` false only where it
        left no results. Raises CallTimeout after `timeout_s`; it goes on then. Ctrl-C ends it, too.
        """
        try:
            code = self._process.wait(timeout_s)
        except subprocess.TimeoutExpired:
            raise CallTimeout(f"hils has not ended in {timeout_s:g} s") from None
        except BaseException:
            self.stop()
            raise
        self._reader.join()
        self._folder.cleanup()
        results: Optional[R] = None
        try:
            if code >= 0 and code not in (2, 130):  # else the results there are of an earlier run
                results = self._read(self.out, code, self.output)
        except FormatError:
            pass
        if results is not None and (code == 0 or not check):
            return results
        kind = RUN_ERRORS.get(130 if code == -signal.SIGINT else code, RunError)
        end = f"ended with {code}" if code >= 0 else f"was ended by signal {-code} ({signal.strsignal(-code)})"
        raise kind(f"hils {end}: {_last_words(self.output)}", code, self.output, results)

    def stop(self) -> None:
        """Interrupts it, as Ctrl-C does."""
        if not self.done:
            self._process.send_signal(signal.SIGINT)
            try:
                self._process.wait(_STOP_PATIENCE_S)
            except subprocess.TimeoutExpired:
                self._process.kill()
                self._process.wait()
        self._reader.join()
        self._folder.cleanup()

    def __enter__(self) -> "Running[R]":
        return self

    def __exit__(self, *_: object) -> None:
        self.stop()


def _last_words(output: str) -> str:
    lines = [line.strip() for line in output.splitlines() if line.strip()]
    own = [line for line in lines if line.startswith(("hils:", "FAILED", "INVALID"))]
    return own[-1] if own else lines[-1] if lines else "it printed nothing"


def start(scenario: Scenario, out: Union[str, "os.PathLike[str]"], *, virtual: bool = False, lockstep: bool = False,
          architecture: Optional[str] = None, seed: Optional[int] = None, flags: Sequence[str] = (),
          progress: Optional[Progress] = None) -> Running[Run]:
    """Starts `hils run`; the arguments are those of run()."""
    if virtual and lockstep:
        raise CasError("a run is either virtual (one process, exact and fast) or in lockstep (the real programs)")
    options = [*(["--virtual"] if virtual else []), *(["--lockstep"] if lockstep else []),
               *(["--architecture", architecture] if architecture else []),
               *(["--seed", str(seed)] if seed is not None else []), *flags]
    return Running("run", scenario, out, options, Run, progress)


def run(scenario: Scenario, out: Union[str, "os.PathLike[str]"], *, virtual: bool = False, lockstep: bool = False,
        architecture: Optional[str] = None, seed: Optional[int] = None, flags: Sequence[str] = (),
        progress: Optional[Progress] = None, timeout_s: Optional[float] = None, check: bool = True) -> Run:
    """Flies a scenario and reads its folder `out`.

    `virtual` computes time instead of waiting for it, `lockstep` runs the real programs on the stream's time,
    neither is real time. `architecture` is direct, sitl, ts, loop or tcas. `progress` is called with each line
    that hils prints. `flags` go to `hils run` as they are.

    Raises LimitMissed, WrongUse, NoVerdict or Interrupted by the exit code; their `run` has the results where
    there are any. With `check` false a run that missed a limit is returned: see `passed` and `summary`.
    """
    running = start(scenario, out, virtual=virtual, lockstep=lockstep, architecture=architecture, seed=seed,
                    flags=flags, progress=progress)
    with running:
        return running.wait(timeout_s, check)


def compare(scenario: Scenario, out: Union[str, "os.PathLike[str]"], *, architectures: Sequence[str] = (),
            bauds: Sequence[int] = (), seeds: Optional[int] = None, first_seed: Optional[int] = None,
            warm_up_s: Optional[float] = None, hold_s: Optional[float] = None, virtual: bool = True,
            keep: bool = False, flags: Sequence[str] = (), progress: Optional[Progress] = None,
            timeout_s: Optional[float] = None, check: bool = True) -> Comparison:
    """Flies one scenario in several architectures (`hils compare`) and reads comparison.json. Raises as run()."""
    options: list[str] = []
    for flag, value in (("--architectures", ",".join(architectures)), ("--baud", ",".join(map(str, bauds))),
                        ("--seeds", seeds), ("--first-seed", first_seed), ("--warm-up", warm_up_s),
                        ("--hold", hold_s)):
        if value not in (None, ""):
            options += [flag, str(value)]
    options += [*(["--virtual"] if virtual else []), *(["--keep"] if keep else []), *flags]
    with Running("compare", scenario, out, options, Comparison, progress) as running:
        return running.wait(timeout_s, check)


def sweep(study: Scenario, out: Union[str, "os.PathLike[str]"], *, jobs: Optional[int] = None,
          again: Optional[int] = 0, flags: Sequence[str] = (), progress: Optional[Progress] = None,
          timeout_s: Optional[float] = None, check: bool = True) -> Sweep:
    """Flies a study (`hils sweep`, docs/use/sweep.md) on `jobs` processors, all by default, and reads results.csv.

    `study` is a file or its keys in a dict; files that a dict names are looked for among the shipped ones, or have
    their full path. `again` is how many of the worst runs are flown once more for their reports. A sweep that was
    interrupted goes on with the same `out`. Raises as run(); LimitMissed where a share of the study was missed.
    """
    options = [*(["--jobs", str(jobs)] if jobs is not None else []),
               *(["--again", str(again)] if again is not None else []), *flags]
    with Running("sweep", study, out, options, Sweep, progress) as running:
        return running.wait(timeout_s, check)


def tune(study: Scenario, out: Union[str, "os.PathLike[str]"], *, jobs: Optional[int] = None,
         flags: Sequence[str] = (), progress: Optional[Progress] = None, timeout_s: Optional[float] = None,
         check: bool = True) -> Tuning:
    """Searches gains (`hils tune`, docs/use/tune.md) on `jobs` processors, all by default, and reads its tables.

    `study` is a file or its keys in a dict, as in sweep(). A search that was interrupted goes on with the same `out`.
    Raises as run(); LimitMissed where no candidate is better than the values before.
    """
    options = [*(["--jobs", str(jobs)] if jobs is not None else []), *flags]
    with Running("tune", study, out, options, Tuning, progress) as running:
        return running.wait(timeout_s, check)
