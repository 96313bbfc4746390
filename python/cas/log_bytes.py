# SPDX-License-Identifier: BSD-3-Clause
"""Bytes of a log that fits into memory."""

from __future__ import annotations

import os
from pathlib import Path

from .errors import FormatError

#: Decoded, a log takes several times its size.
MOST_MIB = 512


def read_log(path: Path) -> bytes:
    """The bytes of a log. FormatError: there are over MOST_MIB of them."""
    with open(path, "rb") as file:
        if os.fstat(file.fileno()).st_size <= MOST_MIB << 20:
            return file.read()
    raise FormatError(f"{path} has over {MOST_MIB} MiB, more than is read into memory here; cut it, or use hils replay")
