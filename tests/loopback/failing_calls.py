#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Fails the n-th read, write, open, accept, fsync or allocation of casd and of hils.

Each run ends right (the recording, or the results, have everything), or it says in one sentence what
failed, with another exit code or a recording that lacks no more than it says. A crash, a hang or a
silent loss makes this test fail. Prints a table for docs/results/casd_torture.md.

  failing_calls.py BUILD_FOLDER           many n (long)
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
         "accept": "Too many open files", "fsync": "Input/output error", "malloc": "bad_alloc"}
SOURCE = pathlib.Path(__file__).resolve().parents[2]
PACKETS = 300
STRETCH = 40  # allocations in a row that fail
PATIENCE_S = 20.0
Run = collections.namedtuple("Run", "code output reached")  # code None: it hung


def environment(build, call, n, program, mark):
    """@param program  with ":THREAD" only that thread of it"""
    return {**os.environ, "LD_PRELOAD": str(build / "tests/failing_calls.so"),
            "CAS_TEST_FAIL": f"{call}:{n}:{program}", "CAS_TEST_FAILED": str(mark)}


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
    with contextlib.suppress(OSError):
        with socket.create_connection(("127.0.0.1", port), 5) as client:
            client.settimeout(5)
            client.sendall(b'{"jsonrpc":"2.0","id":1,"method":"casd.status"}\n')
            return client.recv(1) != b""
    return False


def recorded(folder):
    numbers = set()
    for file in folder.rglob("*.tlog*"):
        for found in re.finditer(rb"\xfe\x09.\x01\x01\x00(....)\x02\x0c\x20", file.read_bytes(), re.S):
            numbers.add(struct.unpack("<I", found[1])[0])
    return numbers


def run_casd(build, folder, call, n, program="casd"):
    port, command = free_port(socket.SOCK_DGRAM), free_port(socket.SOCK_STREAM)
    (folder / "rec").mkdir()
    (folder / "casd.yaml").write_text(
        f"schema: 1\ncommand_port: {{port: {command}, unix: none, loopback_without_token: true}}\n"
        f"log: {{folder: {folder}/rec, tlog: flight}}\n"
        f"links:\n  - {{name: v, type: udp_server, local: '127.0.0.1:{port}'}}\n")
    log, mark = folder / "out", folder / "failed"
    with log.open("wb") as out:
        casd = subprocess.Popen([build / "bin/casd", folder / "casd.yaml"], stdout=out, stderr=out,
                                env=environment(build, call, n, program, mark))
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
    return Run(code, log.read_text(errors="replace"), mark.exists()), whole


def run_hils(build, folder, call, n):
    mark = folder / "failed"
    try:
        ended = subprocess.run([build / "bin/hils", "run", SOURCE / "config/scenarios/hover.yaml", "--architecture",
                                "direct", "--out", folder / "out"], capture_output=True, text=True,
                               errors="replace", timeout=6 * PATIENCE_S, check=False,
                               env=environment(build, call, n, "hils", mark))
    except subprocess.TimeoutExpired:
        return Run(None, "", mark.exists()), False
    return Run(ended.returncode, ended.stdout + ended.stderr, mark.exists()), ended.returncode == 0


def is_same_flight(ours, reference):
    try:
        json.loads((ours / "summary.json").read_text())
        return all(filecmp.cmp(ours / name, reference / name, shallow=False) for name in ("truth.csv", "flight.tlog"))
    except (OSError, ValueError):
        return False


def outcome(call, run, whole):
    """One word, or what must not be."""
    if run.code is None:
        return "!! hangs"
    if run.code < 0 or run.code >= 128 or "terminate called" in run.output:
        return f"!! crashes ({run.code})"
    if whole:
        return "right" if run.reached else "not reached"
    if not run.reached:
        return "!! fails without a failing call"
    names_it = CALLS[call] in run.output or re.search(r"memory|cannot|could not|fail|lost|paus", run.output)
    return "says so" if names_it else "!! loses something silently"


def try_call(build, program, call, n, reference):
    with tempfile.TemporaryDirectory(prefix="cas-failing-") as name:
        folder = pathlib.Path(name)
        if program.startswith("casd"):
            run, whole = run_casd(build, folder, call, n, program)
        else:
            run, whole = run_hils(build, folder, call, n)
            whole = whole and (reference is None or is_same_flight(folder / "out", reference))
        found = outcome(call, run, whole)
        if found.startswith("!!"):
            print(f"{found}: {program}, {call} number {n}: {run.output[-400:]}", file=sys.stderr)
        return found


def numbers(sample):
    if sample:
        return [1, 4, 20]
    tried, n = list(range(1, 41)), 41
    while n < 1_000_000:
        tried.append(n)
        n = n * 5 // 4
    return tried


def count_outcomes(build, program, call, sample, reference):
    counts = collections.Counter()
    missed = 0
    for n in numbers(sample):
        found = try_call(build, program, call, n, reference)
        counts[found] += 1
        missed = missed + 1 if found == "not reached" else 0
        if missed == 3:
            break  # it makes no more of them
    return counts


def in_words(counts):
    return ", ".join(f"{count} {what}" for what, count in sorted(counts.items())) or "makes none"


def lacks_memory_for_a_while(build, sample):
    """From its n-th allocation on a thread of casd gets no memory for a stretch: the reserve is not enough."""
    counts = collections.Counter()
    for n in numbers(sample):
        for thread in ("casd:links", "casd"):
            counts[try_call(build, f"casd:{thread}", "malloc", f"{n}+{STRETCH}", None)] += 1
    counts.pop("not reached", 0)
    return counts


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--sample", action="store_true")
    wish = parser.parse_args()
    build, bad = wish.build.resolve(), 0
    print("| call that fails | program | failed in runs | outcome |\n|---|---|---|---|")
    with tempfile.TemporaryDirectory(prefix="cas-failing-") as name:
        first, _ = run_hils(build, pathlib.Path(name), "none", 0)
        if first.code != 0:
            sys.exit("hils does not fly without a failing call: " + first.output[-400:])
        for call in CALLS:
            for program in ("casd", "hils"):
                counts = count_outcomes(build, program, call, wish.sample, pathlib.Path(name) / "out")
                bad += sum(count for what, count in counts.items() if what.startswith("!!"))
                reached = sum(counts.values()) - counts.pop("not reached", 0)
                print(f"| `{call}` | {program} | {reached} | {in_words(counts)} |", flush=True)
    counts = lacks_memory_for_a_while(build, wish.sample)
    bad += sum(count for what, count in counts.items() if what.startswith("!!"))
    print(f"| `malloc`, {STRETCH} in a row | casd, by thread | {sum(counts.values())} | {in_words(counts)} |")
    sys.exit(1 if bad else 0)


if __name__ == "__main__":
    main()
