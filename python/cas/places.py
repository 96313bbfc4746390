# SPDX-License-Identifier: BSD-3-Clause
"""Where the programs of CAS, their shipped files and a running casd's socket are."""

from __future__ import annotations

import os
import shutil
import socket
import stat
from pathlib import Path
from typing import Optional

from .errors import NotRunning, ProgramMissing

SERVICE_FOLDER = Path("/run/cas")


def program(name: str) -> str:
    """The path of a program of CAS: in the folder that CAS_BIN names, else on PATH. Raises ProgramMissing."""
    package = {"casd": "casd", "casctl": "casd", "mavlink_gen": "cas-mavlink-dev"}.get(name, "cas-sim")
    folder = os.environ.get("CAS_BIN")
    if folder:
        path = Path(folder) / name
        if os.access(path, os.X_OK):
            return str(path)
        raise ProgramMissing(f"there is no {name} in {folder}, which CAS_BIN names: build it there "
                             "(scripts/build release), or unset CAS_BIN")
    found = shutil.which(name)
    if found is None:
        raise ProgramMissing(f"{name} is not on PATH: install {package}, or set CAS_BIN to the folder with the "
                             "programs (build/release/bin)")
    return found


def runtime_folder() -> Path:
    """Where the programs of one user find each other (docs/protocol.md, Who may call)."""
    if own := os.environ.get("CAS_RUNTIME_DIR"):
        return Path(own)
    xdg = os.environ.get("XDG_RUNTIME_DIR")
    if xdg and os.access(xdg, os.W_OK):
        return Path(xdg) / "cas"
    if os.access(SERVICE_FOLDER, os.W_OK):
        return SERVICE_FOLDER
    return Path(f"/tmp/cas-{os.getuid()}")


def _trusted(folder: Path) -> list[Path]:
    """The sockets of casds in a folder that others may not write into."""
    try:
        about = folder.stat()
    except OSError:
        return []
    owners = {os.getuid(), 0} | ({about.st_uid} if folder == SERVICE_FOLDER else set())
    if about.st_uid not in owners or about.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return []
    sockets = []
    for path in sorted([*folder.glob("casd.sock"), *folder.glob("casd-*.sock")]):
        entry = path.lstat()
        if stat.S_ISSOCK(entry.st_mode) and entry.st_uid in owners:
            sockets.append(path)
    return sockets


def _answers(path: Path) -> bool:
    with socket.socket(socket.AF_UNIX) as probe:
        probe.settimeout(2)
        try:
            probe.connect(str(path))
        except OSError:
            return False
        return True


def running_casds() -> list[Path]:
    """The sockets of all casds that one may call."""
    folders = list(dict.fromkeys([runtime_folder(), SERVICE_FOLDER]))
    return [path for folder in folders for path in _trusted(folder) if _answers(path)]


def the_casd() -> Path:
    """The socket of the one casd that runs. Raises NotRunning when there is none, or more than one."""
    found = running_casds()
    if not found:
        raise NotRunning(f"no casd runs: there is no socket in {runtime_folder()} or {SERVICE_FOLDER}. Start one with "
                         "`casd topologies/bench_pty.yaml`, or a whole bench with `with cas.Bench() as bench:`")
    if len(found) > 1:
        raise NotRunning("several casds run; say which: " + ", ".join(f"cas.Casd('{path}')" for path in found))
    return found[0]


def token_of(folder: Optional[Path] = None) -> Optional[str]:
    """The token that casd made in the runtime folder; None where there is none, or where it may not be read."""
    try:
        return ((folder or runtime_folder()) / "casd.token").read_text().splitlines()[0]
    except (OSError, IndexError):
        return None
