# SPDX-License-Identifier: BSD-3-Clause
"""Where the programs of CAS, their shipped files and a running casd's socket are."""

from __future__ import annotations

import contextlib
import os
import shutil
import socket
import stat
from pathlib import Path
from typing import Optional

from .errors import NotRunning, ProgramMissing

SERVICE_FOLDER = Path("/run/cas")
_SHORTEST_TOKEN = 16  # as casd has it
_LISTENS = "0A"  # state of a socket in /proc/net/tcp


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
    """Where the programs of one user find each other (docs/develop/protocol.md, Who may call)."""
    if own := os.environ.get("CAS_RUNTIME_DIR"):
        return Path(own)
    xdg = os.environ.get("XDG_RUNTIME_DIR")
    if xdg and os.access(xdg, os.W_OK):
        return Path(xdg) / "cas"
    if os.access(SERVICE_FOLDER, os.W_OK):
        return SERVICE_FOLDER
    return Path(f"/tmp/cas-{os.getuid()}")


def _owners(folder: Path) -> Optional[set[int]]:
    """The users whose files in a folder count; None if others may write into it, or it is another user's or a symlink."""
    try:
        about = folder.lstat()
    except OSError:
        return None
    owners = {os.getuid(), 0} | ({about.st_uid} if folder == SERVICE_FOLDER else set())
    foreign = about.st_uid not in owners or about.st_mode & (stat.S_IWGRP | stat.S_IWOTH)
    return owners if stat.S_ISDIR(about.st_mode) and not foreign else None


def _trusted(folder: Path) -> list[Path]:
    """The sockets of casds in a folder that others may not write into."""
    owners = _owners(folder)
    if owners is None:
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
    """The token that casd made in the runtime folder; None where there is none, where it may not be read, and where
    another user could have made it or may read it."""
    place = folder or runtime_folder()
    owners = _owners(place)
    if owners is None:
        return None
    try:
        descriptor = os.open(place / "casd.token", os.O_RDONLY | os.O_CLOEXEC | os.O_NONBLOCK)
    except OSError:
        return None
    with open(descriptor, encoding="utf-8", errors="replace") as file:
        about = os.fstat(descriptor)
        if not stat.S_ISREG(about.st_mode) or about.st_uid not in owners or about.st_mode & 0o077:
            return None
        token = file.readline(4096).rstrip("\r\n")
    return token if len(token) >= _SHORTEST_TOKEN else None


def is_own_port(port: int) -> bool:
    """Whether the listeners at a TCP port of this machine are this user's or the service's, as the kernel has it."""
    users = set()
    for table in ("/proc/net/tcp", "/proc/net/tcp6"):
        try:
            rows = Path(table).read_text().splitlines()[1:]
        except OSError:
            continue
        for row in rows:
            words = row.split()
            if words[3] == _LISTENS and int(words[1].rpartition(":")[2], 16) == port:
                users.add(int(words[7]))
    friends = {os.getuid()}
    with contextlib.suppress(OSError):
        friends.add(SERVICE_FOLDER.lstat().st_uid)
    return bool(users) and users <= friends
