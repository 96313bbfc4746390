#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""hils eval as an optimiser drives it: a search of a few lines, wrong lines, several flights at once.

Usage: eval_test.py HILS VEHICLE
"""

import json
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

PATIENCE_S = 300

SCENARIO = """
schema: 1
name: hop
vehicle: %s
home: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}
decimal_year: 2026.5
seed: 1
rates: {sensor_hz: 500, gps_hz: 5, controls_hz: 400}
line: {preset: baud_921600}
steps:
  - arm
  - takeoff: {altitude_m: 0.6}
  - trajectory: {name: jump, shape: step, size_m: 1, duration_s: 4, measure: true}
  - land
  - disarm
"""
STUDY = """
schema: 1
name: hops
scenario: hop.yaml
sampling: sobol
points: 1
vary:
  - {name: position_p, key: controller.params.MPC_XY_P, log: [0.2, 2]}
"""


class EvalTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="cas-test-")
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)
        (self.folder / "hop.yaml").write_text(SCENARIO % VEHICLE)
        (self.folder / "hops.yaml").write_text(STUDY)

    def start(self, *flags):
        program = subprocess.Popen([HILS, "eval", str(self.folder / "hops.yaml"), "--scratch", str(self.folder / "tmp"),
                                    *flags], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, encoding="utf-8")
        self.addCleanup(program.stdout.close)
        self.addCleanup(program.kill)
        return program

    def test_a_search_of_a_few_lines_asks_and_is_told(self):
        program = self.start()

        def error_of(position_p):
            print(json.dumps({"parameters": {"position_p": position_p}, "seed": 2}), file=program.stdin, flush=True)
            answer = json.loads(program.stdout.readline())
            self.assertEqual((answer["outcome"], answer["up"], answer["seed"]), ("passed", 1, 2))
            return answer["figures"]["jump_integrated_error_m_s"]

        low, high = 0.25, 1.0
        slow = error_of(low)
        for _ in range(2):  # the better half
            middle = (low + high) / 2
            low, high = (low, middle) if error_of(middle) > error_of(high) else (middle, high)
        self.assertLess(error_of(high), slow)
        program.stdin.close()
        self.assertEqual(program.wait(PATIENCE_S), 0)
        self.assertEqual(list((self.folder / "tmp").iterdir()), [])

    def test_wrong_lines_are_answered_and_nothing_ends(self):
        lines = ["no json", '{"parameters": {"positon_p": 1}}', '{"id": 3, "parameters": {"position_p": "much"}}', "",
                 '{"id": 4, "parameters": {"position_p": 1}}']
        program = self.start()
        out, _ = program.communicate("\n".join(lines), timeout=PATIENCE_S)  # the last one has no end of line
        answers = [json.loads(line) for line in out.splitlines()]
        self.assertEqual(program.returncode, 0)
        self.assertEqual([answer.get("id") for answer in answers], [None, None, 3, 4])
        self.assertIn("no JSON", answers[0]["error"])
        self.assertIn("did you mean 'position_p'", answers[1]["error"])
        self.assertEqual(answers[2]["outcome"], "refused")
        self.assertIn("MPC_XY_P", answers[2]["cause"])
        self.assertEqual(answers[3]["outcome"], "passed")

    def test_several_at_once_are_told_apart_by_their_ids(self):
        lines = [json.dumps({"id": seed, "seed": seed}) for seed in (1, 2, 2)]
        out, _ = self.start("--jobs", "2").communicate("\n".join(lines) + "\n", timeout=PATIENCE_S)
        answers = [json.loads(line) for line in out.splitlines()]
        self.assertEqual(sorted(answer["id"] for answer in answers), [1, 2, 2])
        truths = {}
        for answer in answers:
            truths.setdefault(answer["id"], set()).add(answer["truth_sha256"])
        self.assertEqual([len(each) for _, each in sorted(truths.items())], [1, 1])  # the same seed, the same bytes
        self.assertNotEqual(truths[1], truths[2])

    def test_it_says_what_may_be_asked(self):
        out, _ = self.start("--describe").communicate(timeout=PATIENCE_S)
        (line,) = out.splitlines()
        told = json.loads(line)
        self.assertEqual(told["schema"], 1)
        self.assertEqual(told["parameters"][0], {"name": "position_p", "keys": ["controller.params.MPC_XY_P"],
                                                 "least": 0.2, "most": 2.0, "log": True, "whole": False})
        self.assertIn("jump_rise_s", told["figures"])


if __name__ == "__main__":
    HILS, VEHICLE = sys.argv[1:3]
    unittest.main(argv=sys.argv[:1])
