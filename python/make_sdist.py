#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Makes cas-VERSION.tar.gz, which pip installs, without network; takes setuptools.    Usage: make_sdist.py OUT"""

from __future__ import annotations

import os
import shutil
import sys
import tempfile
from pathlib import Path

HERE = Path(__file__).resolve().parent


def main() -> int:
    """By the command line."""
    if len(sys.argv) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    try:
        from setuptools import build_meta
    except ImportError:
        print("make_sdist: setuptools is missing: install python3-setuptools", file=sys.stderr)
        return 1
    out = Path(sys.argv[1]).resolve()
    out.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:  # links become files, and the tree stays clean
        copy = Path(folder) / "cas"
        shutil.copytree(HERE, copy, ignore=shutil.ignore_patterns("__pycache__", ".mypy_cache", "*.egg-info"))
        os.chdir(copy)
        sys.argv[1:] = []
        print(out / build_meta.build_sdist(str(out)))
    return 0


if __name__ == "__main__":
    sys.exit(main())
