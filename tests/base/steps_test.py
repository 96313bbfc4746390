#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tests of the progress that scripts show (scripts/steps.py)."""

import contextlib
import io
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
import steps  # noqa: E402


class StepsTest(unittest.TestCase):
    def test_a_line_tells_what_is_done_of_how_much_and_how_long_yet(self):
        self.assertEqual(steps.line("bench", 3, 12, 62.4, "hover"), "bench: 3 of 12, 1:02, about 3:07 left; hover")

    def test_nothing_is_foretold_before_the_first_part_is_done_and_after_the_last(self):
        self.assertEqual(steps.line("bench", 0, 12, 5, ""), "bench: 0 of 12, 0:05")
        self.assertEqual(steps.line("bench", 12, 12, 61, ""), "bench: 12 of 12, 1:01")

    def test_without_a_terminal_each_part_is_a_line_of_its_own(self):
        with contextlib.redirect_stderr(io.StringIO()) as said:
            parts = steps.Steps("bench", 2)
            parts.next("one")
            parts.again("one, second look")  # for terminals
            parts.next("two")
            parts.clear()
        lines = said.getvalue().splitlines()
        self.assertEqual(lines[0], "bench: 0 of 2, 0:00; one")
        self.assertTrue(lines[1].startswith("bench: 1 of 2, 0:00") and lines[1].endswith("; two"), lines)
        self.assertEqual(len(lines), 2)


if __name__ == "__main__":
    unittest.main()
