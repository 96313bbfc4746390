# SPDX-License-Identifier: BSD-3-Clause
"""hils as a child, with a stand-in that ends as the test wants."""

import json
import math
import os
import sys
import time
import unittest
from unittest import mock

from helpers import PATIENCE_S, FolderTest

import cas

STAND_IN = f"""#!{sys.executable}
import json, os, signal, sys, time
arguments = sys.argv[1:]
out = arguments[arguments.index("--out") + 1]
os.makedirs(out, exist_ok=True)
json.dump(arguments, open(os.path.join(out, "arguments.json"), "w"))
json.dump(json.load(open(arguments[1])), open(os.path.join(out, "scenario.json"), "w"))
code = json.load(open(arguments[1])).get("code", 0)
print("hils: step 1 of 2", file=sys.stderr, flush=True)
if code == "wait":
    signal.signal(signal.SIGINT, lambda *_: sys.exit(130))
    print("waiting", flush=True)
    while True: time.sleep(60)
if code == "killed":
    print("waiting", flush=True)
    os.kill(os.getpid(), signal.SIGKILL)
if code in (0, 1, 3):
    json.dump({{"schema": 2, "passed": code == 0, "valid": code != 3}}, open(os.path.join(out, "summary.json"), "w"))
    json.dump({{"figures": ["up", "crash_s", "rms_x_m"]}}, open(os.path.join(out, "plan.json"), "w"))
    open(os.path.join(out, "results.csv"), "w").write(
        "row,up,crash_s,rms_x_m,incident,cause\\n1,1,,0.5,,\\n2,,,,,\\"died, twice\\"\\n")
if arguments[0] == "tune":
    open(os.path.join(out, "candidates.csv"), "w").write("candidate,p,penalty\\n0,1,0\\n1,2.5,0.25\\n")
    open(os.path.join(out, "gains.params"), "w").write("MPC_XY_P 2.5\\n")
else:
    json.dump({{"variants": []}}, open(os.path.join(out, "comparison.json"), "w"))
print("hils: the end")
sys.exit(code)
"""


class HilsTest(FolderTest):
    def setUp(self):
        super().setUp()
        stand_in = self.folder / "hils"
        stand_in.write_text(STAND_IN)
        stand_in.chmod(0o755)
        patch = mock.patch.dict(os.environ, {"CAS_BIN": str(self.folder)})
        patch.start()
        self.addCleanup(patch.stop)

    def test_a_run_gets_its_flags_and_a_scenario_made_of_a_dict(self):
        lines = []
        run = cas.run({"name": "mine", "code": 0}, "out/a", virtual=True, architecture="ts", seed=7,
                      flags=["--gcs", "udp:14550"], progress=lines.append, timeout_s=PATIENCE_S)
        self.assertTrue(run.passed)
        arguments = json.loads((self.folder / "out/a/arguments.json").read_text())
        self.assertEqual(arguments[0], "run")
        self.assertTrue(arguments[1].endswith("/mine.yaml"))
        self.assertEqual(arguments[2:], ["--out", "out/a", "--virtual", "--architecture", "ts", "--seed", "7", "--gcs",
                                         "udp:14550"])
        self.assertEqual(json.loads((self.folder / "out/a/scenario.json").read_text())["name"], "mine")
        self.assertEqual(lines, ["hils: step 1 of 2", "hils: the end"])

    def test_exit_codes_are_exceptions_with_the_results_that_there_are(self):
        for code, kind, has_results in ((1, cas.LimitMissed, True), (2, cas.WrongUse, False),
                                        (3, cas.NoVerdict, True), (130, cas.Interrupted, False)):
            with self.assertRaisesRegex(kind, f"hils ended with {code}: hils: the end") as caught:
                cas.run({"code": code}, f"out/{code}", timeout_s=PATIENCE_S)
            self.assertEqual(caught.exception.exit_code, code)
            self.assertEqual(caught.exception.run is not None, has_results)
        self.assertFalse(cas.run({"code": 1}, "out/c", check=False, timeout_s=PATIENCE_S).passed)
        with self.assertRaises(cas.WrongUse):
            cas.run({"code": 2}, "out/d", check=False, timeout_s=PATIENCE_S)

    def test_one_that_a_signal_ended_is_named_and_an_earlier_run_is_not_taken_for_its_results(self):
        cas.run({"code": 0}, "out/k", timeout_s=PATIENCE_S)
        for check in (True, False):
            with self.assertRaisesRegex(cas.RunError, r"hils was ended by signal 9 \(Killed\): ") as caught:
                cas.run({"code": "killed"}, "out/k", check=check, timeout_s=PATIENCE_S)
            self.assertEqual((caught.exception.exit_code, caught.exception.run), (-9, None))

    def test_the_name_of_a_scenario_leads_nowhere(self):
        for number, (name, file) in enumerate((("../../a b", "_.._a_b.yaml"), ("..", "scenario.yaml"), (7, "7.yaml"))):
            cas.run({"name": name}, f"out/n{number}", timeout_s=PATIENCE_S)
            arguments = json.loads((self.folder / f"out/n{number}/arguments.json").read_text())
            self.assertEqual(os.path.basename(arguments[1]), file)

    def test_leaving_the_block_interrupts_it(self):
        with cas.start({"code": "wait"}, "out/w") as running:
            deadline = time.monotonic() + PATIENCE_S
            while "waiting" not in running.output and time.monotonic() < deadline:
                time.sleep(0.01)
            with self.assertRaises(cas.CallTimeout):
                running.wait(0.01)
            self.assertFalse(running.done)
        self.assertTrue(running.done)

    def test_a_comparison_is_read(self):
        comparison = cas.compare({"code": 0}, "out/cmp", architectures=["direct", "ts"], seeds=2, hold_s=5)
        self.assertEqual(comparison.figures, {"variants": []})
        arguments = json.loads((self.folder / "out/cmp/arguments.json").read_text())
        self.assertEqual(arguments[4:], ["--architectures", "direct,ts", "--seeds", "2", "--hold", "5", "--virtual"])

    def test_a_sweep_is_a_table(self):
        with self.assertRaises(cas.LimitMissed) as caught:
            cas.sweep({"name": "envelope", "code": 1}, "out/sweep", jobs=2, timeout_s=PATIENCE_S)
        runs = caught.exception.run.runs
        self.assertEqual((runs.rows, list(runs["row"]), runs["cause"]), (2, [1, 2], ["", "died, twice"]))
        self.assertEqual(runs["rms_x_m"][0], 0.5)
        self.assertTrue(math.isnan(runs["up"][1]))
        self.assertTrue(all(math.isnan(each) for each in runs["crash_s"]))  # numbers, also where no run has one
        self.assertEqual(runs["incident"], ["", ""])
        arguments = json.loads((self.folder / "out/sweep/arguments.json").read_text())
        self.assertEqual((arguments[0], arguments[4:]), ("sweep", ["--jobs", "2", "--again", "0"]))

    def test_a_tuning_is_a_table_and_gains(self):
        tuning = cas.tune({"name": "gains", "code": 0}, "out/tune", jobs=3, timeout_s=PATIENCE_S)
        self.assertEqual((list(tuning.candidates["penalty"]), tuning.gains), ([0, 0.25], {"MPC_XY_P": 2.5}))
        self.assertIsInstance(cas.read("out/tune"), cas.Tuning)
        arguments = json.loads((self.folder / "out/tune/arguments.json").read_text())
        self.assertEqual((arguments[0], arguments[4:]), ("tune", ["--jobs", "3"]))

    def test_a_program_that_is_not_there_is_named_with_its_package(self):
        os.remove("hils")
        with self.assertRaisesRegex(cas.ProgramMissing, "there is no hils in .*CAS_BIN"):
            cas.run({}, "out/x")
        with mock.patch.dict(os.environ, {"PATH": str(self.folder)}):
            del os.environ["CAS_BIN"]
            with self.assertRaisesRegex(cas.ProgramMissing, "install cas-sim, or set CAS_BIN"):
                cas.run({}, "out/x")


if __name__ == "__main__":
    unittest.main()
