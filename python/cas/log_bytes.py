# SPDX-License-Identifier: BSD-3-Clause
"""Bytes of a log or table that fits into memory."""

from __future__ import annotations

import os
import stat
from pathlib import Path

from .errors import FormatError

#: Decoded, a log takes several times its size.
MOST_MIB = 512


def read_log(path: Path) -> bytes:
    """The bytes of a log or table. FormatError: it is no regular file, or has over MOST_MIB."""
    descriptor = os.open(path, os.O_RDONLY | os.O_NONBLOCK | os.O_NOCTTY | os.O_CLOEXEC)
    status = os.fstat(descriptor)
    if not stat.S_ISREG(status.st_mode):
        os.close(descriptor)
        raise FormatError(f"{path} is no regular file")
    with open(descriptor, "rb") as file:
        if status.st_size <= MOST_MIB << 20:
            return file.read()
    raise FormatError(f"{path} has over {MOST_MIB} MiB, more than is read into memory here; cut it, or use hils replay")
