#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Fails the n-th read, write, open, close, ... or allocation of casd, of hils and of hilsim.

Each run ends right (the recording, or the results, have everything), or it says in one sentence what
failed, with another exit code or a recording that lacks no more than it says. A crash, a hang or a
silent loss makes this test fail. Prints a table for docs/develop/results/casd_torture.md.
tests/support/failing_calls.cpp lists the calls of each kind.

  failing_calls.py BUILD_FOLDER           every n up to a bound, then fewer and fewer (long)
  failing_calls.py BUILD_FOLDER --sample  a fixed few
"""
import argparse
import collections
import contextlib
import filecmp
import json
import os
import pathlib
import re
import signal
import socket
import struct
import subprocess
import sys
import tempfile
import time

CALLS = {"read": "Input/output error", "write": "No space left on device", "open": "Too many open files",
         "close": "Input/output error", "fsync": "Input/output error", "rename": "Input/output error",
         "accept": "Too many open files", "receive": "Cannot allocate memory",
         "send": "No buffer space available", "malloc": "bad_alloc"}
SOURCE = pathlib.Path(__file__).resolve().parents[2]
PACKETS = 300
STRETCH = 40  # allocations in a row that fail
PATIENCE_S = 20.0
SAMPLE = (1, 4, 20)
ALL_UP_TO = 50  # beyond it every n is a quarter more than the one before
# code: exit code, None for a run that hangs; words: output with the sentence about the failure;
# reached: a call has failed; made: number of calls of that kind
Run = collections.namedtuple("Run", "code words reached made")


def environment(build, call, n, program, mark):
    """Environment of a program under test. @param program  its name, with ":THREAD" that of one thread"""
    return {**os.environ, "LD_PRELOAD": str(build / "tests/failing_calls.so"),
            "CAS_TEST_FAIL": f"{call}:{n}:{program}", "CAS_TEST_FAILED": str(mark)}


def run_of(code, words, mark):
    """The Run that left this mark."""
    made = 0
    with contextlib.suppress(OSError, ValueError):
        made = int(mark.with_name(mark.name + ".count").read_text())
    return Run(code, words, mark.exists(), made)


def heartbeat(number):
    """A MAVLink 1 HEARTBEAT with a number of its own as custom_mode."""
    body = bytes([9, number & 255, 1, 1, 0]) + struct.pack("<IBBBBB", number, 2, 12, 0x20, 3, 3)
    crc = 0xFFFF
    for byte in body + bytes([50]):
        low = (byte ^ crc) & 0xFF
        low = (low ^ (low << 4)) & 0xFF
        crc = (crc >> 8) ^ (low << 8) ^ (low << 3) ^ (low >> 4)
    return b"\xfe" + body + struct.pack("<H", crc)


def free_port(kind):
    with socket.socket(socket.AF_INET, kind) as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def wait_for(condition, seconds):
    end = time.monotonic() + seconds
    while not (answer := condition()) and time.monotonic() < end:
        time.sleep(0.01)
    return answer


def ask_status(port):
    """Whether casd answers a client, which asks again if its connection ends."""
    for _ in range(2):
        with contextlib.suppress(OSError):
            with socket.create_connection(("127.0.0.1", port), 5) as client:
                client.settimeout(5)
                client.sendall(b'{"jsonrpc":"2.0","id":1,"method":"casd.status"}\n')
                if client.recv(1) != b"":
                    return True
    return False


def recorded(folder):
    numbers = set()
    for file in folder.rglob("*.tlog*"):
        for found in re.finditer(rb"\xfe\x09.\x01\x01\x00(....)\x02\x0c\x20", file.read_bytes(), re.S):
            numbers.add(struct.unpack("<I", found[1])[0])
    return numbers


def run_casd(build, folder, call, n, thread=""):
    """casd records a vehicle that sends."""
    port, command = free_port(socket.SOCK_DGRAM), free_port(socket.SOCK_STREAM)
    (folder / "rec").mkdir()
    (folder / "casd.yaml").write_text(
        f"schema: 1\ncommand_port: {{port: {command}, unix: none, loopback_without_token: true}}\n"
        f"log: {{folder: {folder}/rec, tlog: flight}}\n"
        f"links:\n  - {{name: v, type: udp_server, local: '127.0.0.1:{port}'}}\n")
    log, mark = folder / "words", folder / "failed"
    with log.open("wb") as out:
        casd = subprocess.Popen([build / "bin/casd", folder / "casd.yaml"], stdout=out, stderr=out,
                                env=environment(build, call, n, "casd" + thread, mark))
    answered, code = False, None
    try:
        wait_for(lambda: casd.poll() is not None or b"ready:" in log.read_bytes(), PATIENCE_S)
        with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as vehicle:
            for number in range(PACKETS):
                with contextlib.suppress(OSError):  # casd has ended
                    vehicle.sendto(heartbeat(number), ("127.0.0.1", port))
                time.sleep(0.001)
            answered = casd.poll() is None and ask_status(command)
            time.sleep(0.2)
        casd.send_signal(signal.SIGTERM)
        code = casd.wait(PATIENCE_S)
    except subprocess.TimeoutExpired:
        pass
    finally:
        casd.kill()
        casd.wait()
    whole = answered and code == 0 and recorded(folder / "rec") == set(range(PACKETS))
    return run_of(code, log.read_text(errors="replace"), mark), whole


def run_to_its_end(build, command, call, n, program, mark):
    """Runs a program until it ends. @return the Run, and whether the program ended well"""
    try:
        ended = subprocess.run(command, capture_output=True, text=True, errors="replace", check=False,
                               timeout=6 * PATIENCE_S, env=environment(build, call, n, program, mark))
    except subprocess.TimeoutExpired:
        return run_of(None, "", mark), False
    return run_of(ended.returncode, ended.stderr, mark), ended.returncode == 0


def run_hils(build, folder, call, n):
    """hils flies in one process, on the virtual clock."""
    return run_to_its_end(build, [build / "bin/hils", "run", SOURCE / "config/scenarios/hover.yaml", "--architecture",
                                  "direct", "--out", folder / "out"], call, n, "hils", folder / "failed")


def simulation(folder):
    file = folder / "hilsim.yaml"
    file.write_text(
        "schema: 1\nworld: {gravity_m_s2: 9.80665, ground: true}\n"
        "home: {lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488}\ndecimal_year: 2026.5\n"
        "step_us: 1000\npace: free_run\nseed: 1\nvehicles:\n"
        f"  - name: iris0\n    vehicle: {SOURCE}/config/vehicles/iris_paper.yaml\n    plugins:\n"
        "      - plugin: motor\n      - plugin: imu\n      - plugin: gps\n      - plugin: magnetometer\n"
        "      - plugin: barometer\n      - {plugin: mavlink_interface, transport: bus}\n"
        "      - {plugin: recorder, file: truth.csv, rate_hz: 100, sensor_dir: sensors, ulog: flight.ulg}\n")
    return file


def run_hilsim(build, folder, call, n):
    """hilsim runs alone, as fast as it can. It may write below `out` only."""
    out = folder / "out"
    out.mkdir()
    return run_to_its_end(build, [build / "bin/hilsim", simulation(folder), "--output", out, "--duration", "5",
                                  "--stats", out / "stats.json", "--ledger", "ledger.csv"],
                          call, n, "hilsim", out / "failed")


def run_lockstep(build, folder, call, n):
    """hilsim takes part in a lockstep flight of all programs, with its sockets."""
    scenario = (SOURCE / "config/scenarios/hover.yaml").read_text()
    short = scenario.replace("../vehicles", str(SOURCE / "config/vehicles")).replace("duration_s: 30", "duration_s: 1")
    (folder / "short.yaml").write_text(short[:short.index("limits:")] + "limits: {lost: 0}\n")
    return run_to_its_end(build, [build / "bin/hils", "run", folder / "short.yaml", "--lockstep",
                                  "--out", folder / "out"], call, n, "hilsim", folder / "out/failed")


LOCKSTEP = "hilsim, lockstep"
PROGRAMS = {"casd": run_casd, "hils": run_hils, "hilsim": run_hilsim}
RESULTS = ("truth.csv", "flight.ulg", "flight.tlog", "sensors/imu.csv", "sensors/gps.csv", "sensors/barometer.csv",
           "sensors/magnetometer.csv")


def figures(folder):
    """Figures of the flight, without those of the machine, which differ from run to run."""
    file = folder / "summary.json"
    return json.loads(file.read_text())["vehicles"] if file.exists() else None


def is_same_flight(ours, reference):
    if figures(ours) != figures(reference):
        return False
    made = [name for name in RESULTS if (reference / name).exists()]
    return made and all((ours / name).exists() and filecmp.cmp(ours / name, reference / name, shallow=False)
                        for name in made)


def outcome(call, run, whole):
    """One word, or what must not be."""
    if run.code is None:
        return "!! hangs"
    if run.code < 0 or run.code >= 128 or "terminate called" in run.words:
        return f"!! crashes ({run.code})"
    if whole:
        return "right" if run.reached else "not reached"
    if not run.reached:
        return "!! fails without a failing call"
    names_it = CALLS[call] in run.words or re.search(r"memory|cannot|could not|fail|lost|paus", run.words)
    return "says so" if names_it else "!! loses something silently"


def try_call(build, program, call, n, reference, thread=""):
    with tempfile.TemporaryDirectory(prefix="cas-failing-") as name:
        folder = pathlib.Path(name)
        if program == "casd":
            run, whole = run_casd(build, folder, call, n, thread)
        else:
            run, whole = PROGRAMS[program](build, folder, call, n)
            whole = whole and is_same_flight(folder / "out", reference)
        found = outcome(call, run, whole)
        if found.startswith("!!"):
            print(f"{found}: {program}, {call} number {n}: {run.words[-400:]}", file=sys.stderr, flush=True)
        return found, run.made


def numbers(made, sample):
    if sample:
        return [n for n in SAMPLE if n <= made]
    tried = list(range(1, min(made, ALL_UP_TO) + 1))
    n = ALL_UP_TO * 5 // 4
    while n <= made:
        tried.append(n)
        n = n * 5 // 4
    return tried


def reference_of(build, program, folder):
    """Results of a run without a failing call. Exits if that run fails."""
    if program == "casd":
        run, whole = run_casd(build, folder, "none", 0)
    else:
        run, whole = PROGRAMS[program](build, folder, "none", 0)
    if not whole:
        sys.exit(f"{program} fails without a failing call: {run.words[-400:]}")
    return folder / "out"


def count_outcomes(build, program, call, sample, reference):
    """Fails one call after the other. @return the outcomes, and the number of these calls in a run"""
    found, made = try_call(build, program, call, 0, reference)
    if call == "malloc" and made == 0:
        sys.exit(f"{program}: no allocation was counted; is failing_calls.so preloaded?")
    counts = collections.Counter(try_call(build, program, call, n, reference)[0] for n in numbers(made, sample))
    counts[found] += 1
    return counts, made


def in_words(counts):
    return ", ".join(f"{count} {what}" for what, count in sorted(counts.items())) or "none made"


def lacks_memory_for_a_while(build, sample):
    """From its n-th allocation on a thread of casd gets no memory for a stretch: the reserve is not enough."""
    counts = collections.Counter()
    for n in SAMPLE if sample else numbers(20_000, False):
        for thread in (":casd:links", ":casd"):
            counts[try_call(build, "casd", "malloc", f"{n}+{STRETCH}", None, thread)[0]] += 1
    counts.pop("not reached", 0)
    return counts


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--sample", action="store_true")
    wish = parser.parse_args()
    build, bad = wish.build.resolve(), collections.Counter()
    if not wish.sample:
        PROGRAMS[LOCKSTEP] = run_lockstep  # seconds for each run: a few of them
    print("| call that fails | program | calls made | failed in runs | outcome |\n|---|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="cas-failing-") as name:
        for program in PROGRAMS:
            folder = pathlib.Path(name) / program
            folder.mkdir()
            reference = reference_of(build, program, folder)
            for call in CALLS:
                few = wish.sample or program == LOCKSTEP
                counts, made = count_outcomes(build, program, call, few, reference)
                bad += counts
                failed = sum(counts.values()) - counts.pop("not reached", 0)
                print(f"| `{call}` | {program} | {made} | {failed} | {in_words(counts)} |", flush=True)
    counts = lacks_memory_for_a_while(build, wish.sample)
    bad += counts
    print(f"| `malloc`, {STRETCH} in a row | casd, by thread | | {sum(counts.values())} | {in_words(counts)} |")
    sys.exit(1 if any(what.startswith("!!") for what in bad) else 0)


if __name__ == "__main__":
    main()
