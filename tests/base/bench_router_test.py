#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tests of the verdicts of scripts/bench_router."""

import contextlib
import importlib.machinery
import importlib.util
import io
import pathlib
import sys
import unittest

sys.dont_write_bytecode = True
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "scripts"))
SCRIPT = str(pathlib.Path(__file__).resolve().parents[2] / "scripts" / "bench_router")
SPEC = importlib.util.spec_from_loader("bench_router", importlib.machinery.SourceFileLoader("bench_router", SCRIPT))
bench_router = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(bench_router)


class JudgeTest(unittest.TestCase):
    def judged(self, figure, **limit):
        bench_router.missed.clear()
        with contextlib.redirect_stdout(io.StringIO()) as said:
            bench_router.judge("packets lost", {}, figure, **limit)
        return said.getvalue().split()[-1], bench_router.missed

    def test_a_figure_within_its_limit_is_ok(self):
        self.assertEqual(self.judged(0, limit=0), ("ok", []))
        self.assertEqual(self.judged(1.5, limit=1.5, least=True), ("ok", []))

    def test_a_figure_beyond_its_limit_is_missed(self):
        self.assertEqual(self.judged(1, limit=0), ("MISSED", ["packets lost"]))
        self.assertEqual(self.judged(1.4, limit=1.5, least=True), ("MISSED", ["packets lost"]))

    def test_a_figure_that_is_none_is_missed(self):
        self.assertEqual(self.judged(None, limit=0), ("MISSED", ["packets lost"]))
        self.assertEqual(self.judged(float("nan"), limit=0), ("MISSED", ["packets lost"]))


if __name__ == "__main__":
    unittest.main()
