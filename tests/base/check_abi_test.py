#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tests of scripts/check_abi with libraries that export nothing.

Usage: check_abi_test.py COMPILER
"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
COMPILER = sys.argv.pop() if len(sys.argv) > 1 else "c++"


def check(prefix):
    done = subprocess.run([ROOT / "scripts/check_abi", prefix], capture_output=True, text=True, check=False)
    return done.returncode, done.stdout


class CheckAbiTest(unittest.TestCase):
    def test_a_symbol_that_went_is_named(self):
        with tempfile.TemporaryDirectory() as folder:
            for name in ("libcas_base", "libcas_sim"):
                subprocess.run([COMPILER, "-shared", "-fPIC", "-x", "c++", "/dev/null", "-o", f"{folder}/{name}.so"],
                               check=True)
            code, said = check(folder)
        gone = (ROOT / "tests/abi/libcas_base.symbols").read_text().splitlines()[0]
        self.assertEqual(code, 1)
        self.assertIn("libcas_base does not export any more", said)
        self.assertIn(gone, said)
        self.assertNotIn("export all", said)

    def test_a_library_that_is_not_there_is_no_good_one(self):
        with tempfile.TemporaryDirectory() as folder:
            code, said = check(folder)
        self.assertEqual(code, 1)
        self.assertIn("there is no libcas_base.so", said)


if __name__ == "__main__":
    unittest.main()
