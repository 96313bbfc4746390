# SPDX-License-Identifier: BSD-3-Clause
"""A bench of the built programs: it flies, and it leaves nothing behind however it is left."""

import asyncio
import os
import re
import signal
import subprocess
import sys
import time
import unittest
from pathlib import Path

from helpers import PATIENCE_S, SOURCE, FolderTest

import cas


def children_of(bench):
    return [child.process.pid for child in bench._programs]


def is_alive(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return False


def wait_gone(pids):
    deadline = time.monotonic() + PATIENCE_S
    while any(is_alive(pid) for pid in pids):
        if time.monotonic() > deadline:
            return False
        time.sleep(0.02)
    return True


class FlightTest(FolderTest):
    def test_it_takes_off_goes_and_lands_and_leaves_its_records(self):
        with cas.Bench(folder="kept", wind={"mean_m_s": 1, "from_deg": 270},
                       faults=[{"at_s": 8, "for_s": 0.2, "drop": "gps"}]) as bench:
            pids = children_of(bench)
            self.assertEqual(len(pids), 3)
            bench.arm()
            bench.takeoff(2.0)
            self.assertAlmostEqual(bench.sim.pose().up_m, 2.0, delta=0.8)
            bench.goto(1.0, 0.0, 2.0, yaw_deg=0)
            self.assertAlmostEqual(bench.estimate().north_m, 1.0, delta=0.4)
            self.assertEqual(bench.casd.gain.set("position", p=1.2)["p"], 1.2)
            bench.land()
            with self.assertRaises(cas.NotReached):
                bench.wait_until(lambda: False, within_s=0.2, what="nothing")
        self.assertTrue(wait_gone(pids))
        truth = cas.read("kept/truth.csv")
        self.assertGreater(max(truth["z_m"]), 1.5)
        self.assertGreater(cas.read("kept/flight.tlog").counts()["HIL_CONTROLS"], 1000)
        self.assertIn("imu.csv", os.listdir("kept/sensors"))

    def test_in_real_time_time_passes_by_itself(self):
        with cas.Bench(lockstep=False, line={"preset": "baud_921600"}) as bench:
            self.assertGreaterEqual(bench.run_for(0.3)["time_s"], 0.3)
            self.assertEqual(bench.sim.status()["pace"], "realtime")
            self.assertEqual(bench.fcu.call("line.set", {"preset": "baud_115200"})["baud"], 115200)

    def test_two_benches_with_one_seed_fly_the_same(self):
        def fly():
            with cas.Bench(seed=5) as bench:
                bench.arm()
                bench.casd.vehicle.takeoff(2.0)
                bench.run_for(3.0)
                return bench.sim.pose()

        self.assertEqual(fly(), fly())


class EndTest(FolderTest):
    def test_an_exception_ends_the_programs(self):
        for error in (ValueError, KeyboardInterrupt):
            with self.assertRaises(error):
                with cas.Bench() as bench:
                    pids = children_of(bench)
                    raise error()
            self.assertTrue(wait_gone(pids), error)

    def test_a_killed_python_leaves_nothing(self):
        script = ("import sys, time; sys.path.insert(0, sys.argv[1]); import cas\n"
                  "with cas.Bench() as bench:\n"
                  "    print(*[child.process.pid for child in bench._programs], flush=True)\n"
                  "    time.sleep(600)\n")
        for number in (signal.SIGKILL, signal.SIGINT, signal.SIGTERM):
            with subprocess.Popen([sys.executable, "-c", script, str(SOURCE / "python")], stdout=subprocess.PIPE,
                                  stderr=subprocess.DEVNULL, text=True,
                                  env={**os.environ, "TMPDIR": str(self.folder)}) as python:
                pids = [int(word) for word in python.stdout.readline().split()]
                self.assertEqual(len(pids), 3)
                python.send_signal(number)
                python.wait(2 * PATIENCE_S)
            self.assertTrue(wait_gone(pids), number)

    def test_a_program_that_dies_is_named(self):
        with self.assertRaisesRegex(cas.ProgramEnded, "fcu_emulator ended with -9"):
            with cas.Bench() as bench:
                bench._programs[0].process.kill()
                bench._programs[0].process.wait()
                bench.check()

    def test_a_wrong_key_is_told_in_the_programs_words(self):
        with self.assertRaisesRegex(cas.ProgramEnded, "(?s)fcu_emulator ended with 78.*NO_SUCH"):
            with cas.Bench(params={"NO_SUCH": 1}):
                pass


class CommandPortTest(FolderTest):
    def test_over_tcp_the_token_is_proved(self):
        with cas.Bench() as bench:
            casd = next(child for child in bench._programs if child.name == "casd")
            port = re.search(r"command_port (?:127\.0\.0\.1:)?(\d+)", casd.status).group(1)
            token = (bench._places / "casd.token").read_text().strip()
            with cas.Casd(f"127.0.0.1:{port}", token=token) as casd:
                self.assertEqual(casd.status()["program"], "casd")

            async def ask():
                async with await cas.AsyncCasd.connect(f"127.0.0.1:{port}", token=token) as casd:
                    return (await casd.status())["program"]

            self.assertEqual(asyncio.run(ask()), "casd")
            with self.assertRaises(cas.CasError):
                cas.Casd(f"127.0.0.1:{port}", token="x" * 64)

    def test_two_look_at_one_simulator(self):
        async def look(address):
            async with await cas.AsyncSim.connect(address) as sim:
                status = await sim.run_for(0.1)
                return status["time_s"], await sim.pose("iris0")

        with cas.Bench() as bench:
            time_s, pose = asyncio.run(look(bench.sim.client.address))
            self.assertEqual(pose, bench.sim.pose())
            self.assertEqual(time_s, bench.sim.time_s())
            with self.assertRaisesRegex(KeyError, "no vehicle 'iris7'; it has iris0"):
                bench.sim.pose("iris7")

    def test_one_that_runs_is_found(self):
        before = os.environ.get("CAS_RUNTIME_DIR")
        os.environ["CAS_RUNTIME_DIR"] = str(self.folder)
        try:
            if not any(str(path).startswith("/run/cas") for path in cas.running_casds()):
                with self.assertRaisesRegex(cas.NotRunning, "no casd runs.*Start one with"):
                    cas.Casd()
            with cas.Bench() as bench:
                os.environ["CAS_RUNTIME_DIR"] = str(bench._places)
                self.assertIn(bench._places / "casd.sock", cas.running_casds())
        finally:
            os.environ.pop("CAS_RUNTIME_DIR")
            if before is not None:
                os.environ["CAS_RUNTIME_DIR"] = before


if __name__ == "__main__":
    unittest.main()
