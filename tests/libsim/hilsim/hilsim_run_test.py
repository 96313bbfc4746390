#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""hilsim_run serves a scripted PX4 by TCP and a scripted ArduPilot by UDP, and leaves no program behind.

Usage: hilsim_run_test.py HILSIM_RUN
"""

import json
import os
import signal
import socket
import struct
import subprocess
import sys
import time

RUN = sys.argv[1]
HIL_SENSOR = 107
PATIENCE_S = 20


def free_port(kind):
    with socket.socket(socket.AF_INET, kind) as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def children_of(pid):
    with open(f"/proc/{pid}/task/{pid}/children", encoding="ascii") as children:
        return [int(word) for word in children.read().split()]


def end(run):
    """Ctrl-C ends it and all that it started."""
    started = children_of(run.pid)
    assert started
    run.send_signal(signal.SIGINT)
    assert run.wait(PATIENCE_S) == 130, run.returncode
    assert not any(os.path.exists(f"/proc/{pid}") for pid in started), started


def connect(port, run):
    until = time.monotonic() + PATIENCE_S
    while True:
        try:
            return socket.create_connection(("127.0.0.1", port), PATIENCE_S)
        except ConnectionRefusedError:
            assert time.monotonic() < until and run.poll() is None
            time.sleep(0.02)


def px4_gets_sensors():
    port = free_port(socket.SOCK_STREAM)
    run = subprocess.Popen([RUN, "-q", "-s", "-r", "200", "-p", str(port)])
    with connect(port, run) as px4:
        data = b""
        while data.count(struct.pack("<I", HIL_SENSOR)[:3]) < 20:
            received = px4.recv(4096)
            assert received, "hilsim closed the connection"
            data += received
        assert data[0] == 0xFD, "MAVLink 2"
    end(run)


def ardupilot_gets_its_state():
    port = free_port(socket.SOCK_DGRAM)
    run = subprocess.Popen([RUN, "--ardupilot", "-p", str(port)])
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as ardupilot:
        ardupilot.settimeout(0.2)
        until = time.monotonic() + PATIENCE_S
        count = 0
        while True:  # servo packet: magic 18458, frame rate, frame count, 16 pulses in us
            count += 1
            ardupilot.sendto(struct.pack("<HHI16H", 18458, 1200, count, *[1000] * 16), ("127.0.0.1", port))
            try:
                state = json.loads(ardupilot.recv(4096))
                break
            except (TimeoutError, ConnectionRefusedError):
                assert time.monotonic() < until and run.poll() is None
        assert "imu" in state and "timestamp" in state, state
    end(run)


def refusals_are_one_sentence():
    for arguments, sentence in [
        (["-d", "/dev/cas_none"], "hilsim_run: -d /dev/cas_none: no such device\n"),
        (["-b", "921600"], "hilsim_run: -b is of a board: give its serial port with -d\n"),
        (["-r", "fast"], "hilsim_run: -r fast: is not a whole number\n"),
        (["-x"], "hilsim_run: unknown option -x (hilsim_run --help)\n"),
    ]:
        refused = subprocess.run([RUN, *arguments], capture_output=True, text=True, check=False)
        assert (refused.returncode, refused.stderr) == (2, sentence), refused


px4_gets_sensors()
ardupilot_gets_its_state()
refusals_are_one_sentence()
