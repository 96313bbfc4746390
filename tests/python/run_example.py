#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Runs python/examples/NAME.py in a fresh folder.    Usage: run_example.py NAME"""

import subprocess
import sys
import tempfile

from helpers import SOURCE

with tempfile.TemporaryDirectory(prefix="cas-example-") as folder:
    script = SOURCE / "python" / "examples" / f"{sys.argv[1]}.py"
    sys.exit(subprocess.run([sys.executable, str(script)], cwd=folder, check=False).returncode)
