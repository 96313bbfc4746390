#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""A sweep under Debian's Slurm, on loopback and without systemd.

munged, slurmctld and slurmd are started in a temporary folder, as root or as another user. The job array of `hils sweep
run --slurm` loses its node in the middle of a chunk; chunks that lack rows are submitted again, and the table must be
that of a sweep on this machine, to the byte. Result files are judged, never what squeue says.

Usage: slurm_test.py BUILD_TREE    (exit 77: Slurm is not installed)
"""

import ctypes
import os
import pathlib
import pwd
import re
import shutil
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import time

BUILD = pathlib.Path(sys.argv[1]).resolve()
CONFIG = pathlib.Path(__file__).resolve().parents[3] / "config"
PATIENCE_S = 600  # for whatever a busy machine does
ROWS, CHUNKS = 40, 4
PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "squeue", "scancel", "sinfo")
PR_SET_PDEATHSIG, PR_SET_CHILD_SUBREAPER = 1, 36  # of prctl
LIBC = ctypes.CDLL(None)

SCENARIO = f"""
schema: 1
name: hop
description: A short flight
vehicle: {CONFIG}/vehicles/iris_paper.yaml
home: {{lat_deg: 47.397742, lon_deg: 8.545594, alt_m: 488.0}}
decimal_year: 2026.5
seed: 1
rates: {{sensor_hz: 500, gps_hz: 5, controls_hz: 400}}
line: {{preset: baud_921600}}
steps:
  - arm
  - takeoff: {{altitude_m: 1}}
  - hold: {{duration_s: 5, measure: true}}
  - land
  - disarm
"""

STUDY = f"""
schema: 1
name: hops
scenario: hop.yaml
sampling: latin_hypercube
points: {ROWS // 2}
vary:
  - {{name: loss, key: line.packet_loss, uniform: [0, 0.05]}}
  - {{name: sensors, key: sensors, values: [table1, rtk]}}
"""

# The node has two processors, whatever the machine has. Slurm does not start a task again whose node was lost: the test
# would not see whether hils does.
SLURM_CONF = """
ClusterName=loopback
SlurmctldHost={host}(127.0.0.1)
SlurmUser={user}
SlurmdUser={user}
SlurmctldPort={controller_port}
SlurmdPort={node_port}
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SlurmdParameters=config_overrides
JobRequeue=0
ReturnToService=2
MpiDefault=none
MailProg=/bin/true
NodeName=node NodeHostname={host} NodeAddr=127.0.0.1 CPUs=2
PartitionName=lab Nodes=node Default=YES MaxTime=INFINITE State=UP
"""


def say(text):
    print(f"{time.strftime('%H:%M:%S')} {text}", flush=True)


def check(condition, sentence):
    if not condition:
        raise AssertionError(sentence)


def wait_for(what, condition):
    deadline = time.monotonic() + PATIENCE_S
    while not condition():
        check(time.monotonic() < deadline, f"waited in vain for {what}")
        time.sleep(0.1)


def free_port():
    with socket.socket() as listener:
        listener.bind(("127.0.0.1", 0))
        return listener.getsockname()[1]


def listens(port):
    try:
        socket.create_connection(("127.0.0.1", port)).close()
        return True
    except OSError:
        return False


def children(parent):
    """Processes with this parent."""
    found = []
    for entry in pathlib.Path("/proc").iterdir():
        if not entry.name.isdigit():
            continue
        try:
            # The name, in parentheses, may hold anything.
            if int((entry / "stat").read_text().rpartition(")")[2].split()[1]) == parent:
                found.append(int(entry.name))
        except OSError:
            pass  # it has ended meanwhile
    return found


def words_of(process):
    try:
        return pathlib.Path(f"/proc/{process}/cmdline").read_text().split("\0")
    except OSError:
        return []


class Cluster:
    """One controller and one node, which end with this process."""

    def __init__(self, folder):
        self.folder = folder
        self.environment = dict(os.environ, SLURM_CONF=str(folder / "slurm.conf"), TMPDIR=str(folder / "tmp"))
        self.daemons = {}
        for name in ("state", "spool", "tmp"):
            (folder / name).mkdir()
        self.key = folder / "munge.key"
        self.key.write_bytes(os.urandom(128))
        self.key.chmod(0o400)
        self.node_port = free_port()
        (folder / "slurm.conf").write_text(SLURM_CONF.format(
            host=socket.gethostname().split(".")[0], user=pwd.getpwuid(os.geteuid()).pw_name, folder=folder,
            controller_port=free_port(), node_port=self.node_port))

    def run(self):
        self.start("munged", "--foreground", f"--key-file={self.key}", f"--socket={self.folder}/munge.socket",
                   f"--pid-file={self.folder}/munged.pid", f"--seed-file={self.folder}/munged.seed", "--num-threads=2")
        wait_for("munged's socket", (self.folder / "munge.socket").exists)
        self.start("slurmctld", "-D")
        self.start_node()

    def start(self, name, *words):
        with open(self.folder / f"{name}.out", "a", encoding="utf-8") as out:
            self.daemons[name] = subprocess.Popen([name, *words], env=self.environment, stdin=subprocess.DEVNULL,
                                                  stdout=out, stderr=out, start_new_session=True,
                                                  preexec_fn=lambda: LIBC.prctl(PR_SET_PDEATHSIG, signal.SIGTERM))

    def start_node(self):
        self.start("slurmd", "-D")
        wait_for("slurmd", lambda: listens(self.node_port))  # of a node that came back Slurm knows nothing new yet
        wait_for("the node", lambda: self.ask("sinfo", "--noheader", "--format=%T") in ("idle", "mixed", "allocated"))

    def ask(self, *words):
        """Output of a program of Slurm; empty if the controller does not answer yet."""
        for name, daemon in self.daemons.items():
            check(daemon.poll() is None, f"{name} has ended with {daemon.returncode}")
        done = subprocess.run(words, env=self.environment, capture_output=True, text=True, timeout=PATIENCE_S)
        return done.stdout.strip()

    def queue(self):
        return self.ask("squeue", "--noheader", "--format=%i %T %r").replace("\n", ", ") or "empty"

    def cancel(self, job, tasks):
        """Tasks that died with their node hold its processors until Slurm has found out, which takes minutes."""
        for task in tasks:
            self.ask("scancel", f"{job}_{task}")

    def lose_node(self):
        """Kills slurmd and all that it has started, as a power failure does. @return chunks that were under way"""
        self.daemons["slurmd"].kill()
        self.daemons.pop("slurmd").wait()
        return self.kill_orphans()

    def kill_orphans(self):
        """Kills orphans of the daemons: this process is the parent of all orphans below it."""
        known = {daemon.pid for daemon in self.daemons.values()}
        chunks = set()
        while orphans := set(children(os.getpid())) - known:
            for orphan in orphans:
                for process in [orphan, *children(orphan)]:
                    chunks |= {int(k) for k in re.findall(r"--chunk (\d+)/", " ".join(words_of(process)))}
                os.kill(orphan, signal.SIGKILL)
                os.waitpid(orphan, 0)
        return chunks

    def stop(self):
        for name in ("slurmd", "slurmctld", "munged"):
            if name in self.daemons:
                self.daemons[name].terminate()
                try:
                    self.daemons[name].wait(60)
                except subprocess.TimeoutExpired:
                    self.daemons[name].kill()
                    self.daemons[name].wait()
                del self.daemons[name]
        self.kill_orphans()


class Sweep:
    def __init__(self, folder, environment):
        self.folder = folder
        self.environment = environment
        self.hils("plan", folder.parent / "hops.yaml", "--out", folder)

    def hils(self, *words):
        done = subprocess.run([BUILD / "bin/hils", "sweep", *words], env=self.environment, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, timeout=PATIENCE_S)
        check(done.returncode == 0, f"hils sweep {words[0]}: exit {done.returncode}: {done.stdout}")
        return done.stdout

    def submit(self):
        """Submits a job array of the missing rows. @return how many chunks it has, its number"""
        said = self.hils("run", self.folder, "--slurm", "--partition", "lab", "--jobs", "1", "--chunks", str(CHUNKS))
        numbers = re.search(rf"(\d+) of {CHUNKS} chunks\nSubmitted batch job (\d+)", said)
        check(numbers, f"nothing was submitted: {said}")
        return int(numbers[1]), int(numbers[2])

    def flown_of(self, chunk):
        """Rows of a chunk that are on the disk."""
        journal = self.folder / "journal" / f"chunk_{chunk}_of_{CHUNKS}.jsonl"
        return journal.read_bytes().count(b"\n") if journal.exists() else 0

    def flown(self):
        return sum(self.flown_of(chunk) for chunk in range(1, CHUNKS + 1))

    def missing(self):
        return [chunk for chunk in range(1, CHUNKS + 1) if self.flown_of(chunk) < ROWS // CHUNKS]

    def table(self):
        """Results of `collect` that must be the same: results.csv, and the rows of the database."""
        said = self.hils("collect", self.folder, "--again", "0")
        check(f"{ROWS} of {ROWS} runs flown, {ROWS} with a verdict" in said, said)
        with sqlite3.connect(self.folder / "sweep.sqlite") as database:
            rows = database.execute("SELECT * FROM runs ORDER BY row").fetchall()
        return (self.folder / "results.csv").read_bytes(), rows


def fly_array(cluster, array):
    chunks, first_job = array.submit()
    check(chunks == CHUNKS, f"{chunks} chunks of a sweep that nobody has flown")
    say(f"job {first_job}: {chunks} chunks of {ROWS // CHUNKS} runs")

    # The node is lost with a chunk under way; had that one just ended, the node comes back and is lost again.
    while True:
        before = array.flown()
        wait_for("a run's result", lambda: array.flown() > before)
        killed = cluster.lose_node()
        cut = sorted(killed.intersection(array.missing()))
        say(f"the node is lost: {array.flown()} of {ROWS} runs flown, chunks {cut} cut; squeue says: {cluster.queue()}")
        check(array.flown() < ROWS, "all runs were flown before the node was lost with one under way")
        if cut:
            break
        cluster.start_node()
        cluster.cancel(first_job, killed)
    cluster.start_node()
    say(f"the node is back: {array.flown()} of {ROWS} runs flown; squeue says: {cluster.queue()}")

    # Chunks that still wait in the first array are submitted once more: one process flies them, whichever is first.
    chunks, job = array.submit()
    check(chunks >= len(cut), f"{chunks} chunks were submitted again, and {cut} lack rows")
    say(f"job {job}: {chunks} chunks lack rows; squeue says: {cluster.queue()}")
    cluster.cancel(first_job, killed)
    wait_for("all results", lambda: not array.missing())
    say(f"{array.flown()} of {ROWS} runs flown; squeue says: {cluster.queue()}")


def main():
    os.environ["PATH"] += ":/usr/sbin:/sbin"
    missing = [name for name in PROGRAMS if not shutil.which(name)]
    if missing:
        print(f"\n*** LEFT OUT: no job array was flown: {', '.join(missing)} not found (scripts/setup full installs "
              "slurmctld, slurmd, munge and slurm-client) ***\n", file=sys.stderr)
        sys.exit(77)
    check(LIBC.prctl(PR_SET_CHILD_SUBREAPER, 1, 0, 0, 0) == 0, "orphans cannot be adopted")

    with tempfile.TemporaryDirectory(prefix="cas-slurm-") as name:
        folder = pathlib.Path(name)
        folder.chmod(0o711)  # munged wants its socket within reach of all users
        (folder / "hop.yaml").write_text(SCENARIO)
        (folder / "hops.yaml").write_text(STUDY)
        here = Sweep(folder / "here", os.environ)
        here.hils("run", here.folder, "--jobs", "2")
        expected = here.table()
        say(f"{ROWS} runs flown on this machine")

        cluster = Cluster(folder)
        try:
            cluster.run()
            array = Sweep(folder / "array", cluster.environment)
            fly_array(cluster, array)
            table, rows = array.table()
            check(table == expected[0], "results.csv differs from that of a sweep on this machine")
            check(rows == expected[1], "sweep.sqlite differs from that of a sweep on this machine")
            say(f"results.csv is the same to the byte: {len(table)} bytes")
            check("All runs have been flown" in array.hils("run", array.folder, "--slurm"), "something is missing")
        except BaseException:
            for log in [*sorted(folder.glob("*.out")), *sorted(folder.glob("slurm*.log")),
                        *sorted(folder.glob("array/slurm/*"))]:
                print(f"== {log}\n" + "\n".join(log.read_text(errors="replace").splitlines()[-40:]), file=sys.stderr)
            raise
        finally:
            cluster.stop()


if __name__ == "__main__":
    main()
