#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Tests of the exit codes of scripts: each is run in a tree of its own, among programs that do as the test says."""

import contextlib
import hashlib
import importlib.machinery
import importlib.util
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))  # modules that scripts share
NAMES = ("x_m", "y_m", "z_m", "yaw_rad")


def module(name):
    spec = importlib.util.spec_from_loader(
        name, importlib.machinery.SourceFileLoader(name, str(ROOT / "scripts" / name)))
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


class Script(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="cas-scripts-")
        self.addCleanup(folder.cleanup)
        self.tree = pathlib.Path(folder.name)
        shutil.copytree(ROOT / "scripts", self.tree / "scripts")
        (self.tree / "bin").mkdir()

    def write(self, file, text):
        """A program of the tree."""
        path = self.tree / file
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
        path.chmod(0o755)

    def run_script(self, *words, **environment):
        path = f"{self.tree / 'bin'}:{os.environ['PATH']}"
        return subprocess.run([str(self.tree / "scripts" / words[0]), *words[1:]], capture_output=True, text=True,
                              timeout=100, env=dict(os.environ, PATH=path, **environment))


class TestScript(Script):
    """scripts/test: it reports the result of ctest."""

    def setUp(self):
        super().setUp()
        for name in ("setup", "build"):
            self.write(f"scripts/{name}", "#!/bin/sh\ntest \"$FAILS\" != \"$1\"\n")
        self.write("bin/ctest", "#!/bin/sh\necho \"ctest $*\"\ntest \"$FAILS\" != \"tests of $2\" || exit 8\n")

    def code(self, *words, fails=""):
        return self.run_script("test", *words, FAILS=fails).returncode

    def test_all_is_well(self):
        self.assertEqual(self.code(), 0)
        self.assertEqual(self.code("--sanitize"), 0)

    def test_a_test_fails(self):
        self.assertNotEqual(self.code(fails="tests of release"), 0)
        self.assertNotEqual(self.code("--sanitize", fails="tests of asan"), 0)

    def test_a_build_fails(self):
        self.assertNotEqual(self.code(fails="release"), 0)
        self.assertNotEqual(self.code("--sanitize", fails="asan"), 0)

    def test_threads_are_a_part_of_full(self):
        for fails in ("", "tsan", "tests of tsan"):
            done = self.run_script("test_release_extras", "tsan", FAILS=fails)
            self.assertEqual(done.returncode == 0, fails == "", done.stdout)
            self.assertIn("passed" if fails == "" else "FAILED", done.stdout)

    def test_nothing_was_tested(self):
        """ctest without a test ends with 0 by default."""
        self.assertIn("--no-tests=error", self.run_script("test", FAILS="").stdout)


class BuildScript(Script):
    """scripts/build: the build's note on the page is on the terminal, too."""

    def test_a_page_that_was_left_out_is_told(self):
        self.write("bin/cmake", "#!/bin/sh\ntest \"$1\" = --preset && exit\n"
                                "echo '[1/2] page'; echo 'page: left out, no registry'; echo '[2/2] hils'\n")
        done = self.run_script("build", "release")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("\npage: left out, no registry\n", done.stdout)


class PageBuild(Script):
    """web/page/build with an npm that ends as the test says, and a node that writes a page."""

    NPM_9 = ("npm WARN old\nnpm ERR! code SELF_SIGNED_CERT_IN_CHAIN\nnpm ERR! errno SELF_SIGNED_CERT_IN_CHAIN\n"
             "npm ERR! request to https://registry/lit failed, reason: self-signed certificate\n\n"
             "npm ERR! A complete log of this run can be found in:\n")
    NPM_11 = ("npm error code ENOTFOUND\nnpm error syscall getaddrinfo\nnpm error errno ENOTFOUND\n"
              "npm error network request to https://registry/lit failed, reason: getaddrinfo ENOTFOUND registry\n"
              "npm error network This is a problem related to network connectivity.\n")

    def setUp(self):
        super().setUp()
        self.work, self.page = self.tree / "work", self.tree / "page"
        self.write("bin/node", "#!/bin/sh\nmkdir -p \"$2\" && echo whole >\"$2/index.html\"\n")

    def build(self, *words, says="", code=1):
        self.write("says", says)
        self.write("bin/npm", f"#!/bin/sh\ncat {self.tree / 'says'}\ntest {code} = 0 || exit {code}\n"
                              "mkdir -p node_modules/.bin && ln -sf /bin/true node_modules/.bin/tsc\n")
        path = f"{self.tree / 'bin'}:{os.environ['PATH']}"
        return subprocess.run([str(ROOT / "web" / "page" / "build"), self.work, self.page, *words], text=True,
                              capture_output=True, timeout=100, env=dict(os.environ, PATH=path))

    def left_out(self):
        return (self.page / "left_out.txt").read_text()

    def test_the_cause_is_named(self):
        for says, code, cause in ((self.NPM_9, 1, "request to https://registry/lit failed, reason: self-signed certificate ("),
                                  (self.NPM_11, 1, "network request to https://registry/lit failed, reason: getaddrinfo"),
                                  ("", 137, "exit code 137"), (self.NPM_9, 124, "did not end within four minutes")):
            with self.subTest(cause):
                done = self.build(says=says, code=code)
                self.assertEqual(done.returncode, 0, done.stderr)
                self.assertIn("page: left out, npm cannot install its packages: ", done.stdout)
                self.assertIn(cause, done.stdout)
                self.assertIn(cause, self.left_out())
                (self.work / "npm.failed").unlink()

    def test_within_the_hour_npm_is_not_asked_and_the_cause_is_said_again(self):
        self.build(says=self.NPM_9)
        self.assertIn("self-signed certificate", self.build(code=0).stdout)
        self.assertFalse((self.page / "index.html").exists())

    def test_packages_are_not_made_without_it(self):
        done = self.build("must", says=self.NPM_11)
        self.assertEqual(done.returncode, 1)
        self.assertIn("getaddrinfo ENOTFOUND", done.stdout)

    def test_a_page_that_was_built_has_no_cause(self):
        self.build(says=self.NPM_9)
        (self.work / "npm.failed").unlink()
        done = self.build(code=0)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue((self.page / "index.html").exists())
        self.assertFalse((self.page / "left_out.txt").exists())


class BenchMavlink(Script):
    def code(self, **figures):
        names = {"encode_hil_sensor": 1.0, "receive_hil_sensor": 1.0, "receive_mixed": 1.0,
                 "encode_signed<Sha256>": 1.0, **{name: value for name, value in figures.items() if name != "allocations"}}
        runs = [{"aggregate_name": "median", "run_name": name, "per_message": value * 1e-9,
                 "allocations": figures.get("allocations", 0)} for name, value in names.items()]
        (self.tree / "figures.json").write_text(json.dumps({"benchmarks": runs}))
        self.write("bin/cmake", "#!/bin/sh\n")
        self.write("bin/compiler", "#!/bin/sh\n")
        self.write("build/bench/bench/bench_mavlink", f"#!/bin/sh\ncat {self.tree}/figures.json\n")
        self.write("build/bench/bin/mavlink_gen", "#!/bin/sh\n")
        done = self.run_script("bench_mavlink", CXX=str(self.tree / "bin" / "compiler"))
        self.output = done.stdout
        return done.returncode

    def test_within_its_limits(self):
        self.assertEqual(self.code(), 0)

    def test_a_limit_is_missed(self):
        self.assertEqual(self.code(encode_hil_sensor=81.0), 1)
        self.assertEqual(self.code(receive_mixed=float("nan")), 1)

    def test_it_allocates(self):
        self.assertEqual(self.code(allocations=1), 1)

    def test_hostile_bytes_and_the_dearest_of_the_corpus_have_a_limit(self):
        self.assertEqual(self.code(**{"refuse_FE/1": 14.9, "corpus/a/0": 3.0, "corpus/b/1": 14.9}), 0)
        self.assertEqual(self.code(**{"refuse_FE/1": 15.1}), 1)
        self.assertEqual(self.code(**{"corpus/a/0": 3.0, "corpus/b/1": 15.1}), 1)

    def test_the_race_with_the_c_codec_is_judged_byte_by_byte(self):
        ours = "receive_mixed_in_pieces/1"
        self.assertEqual(self.code(**{ours: 69.0, f"c_{ours}": 100.0}), 0)
        self.assertEqual(self.code(**{ours: 71.0, f"c_{ours}": 100.0}), 1)
        hostile = {"refuse_FE/1": 9.0, "c_refuse_FE/1": 1.0}
        self.assertEqual(self.code(**hostile), 0)

    def test_a_race_that_did_not_take_place_is_said(self):
        self.code()
        self.assertIn("C codec: LEFT OUT", self.output)


class BenchCommandPort(unittest.TestCase):
    def test_limits(self):
        missed = module("bench_command_port").missed_limits
        self.assertEqual(missed(5.0, 5.0), [])
        self.assertEqual(len(missed(5.1, 0)), 1)
        self.assertEqual(len(missed(0, 5.1)), 1)
        self.assertEqual(len(missed(float("nan"), float("nan"))), 2)


class BenchEnv(Script):
    """A cas.env that makes $PACE steps a second by the clock that the script reads."""

    def code(self, pace):
        self.write("bin/cmake", "#!/bin/sh\n")
        self.write("build/bench/bench/bench_env", "#!/bin/sh\necho step_env/motors 1 ns\n")
        self.write("python/cas/__init__.py", "")
        self.write("python/cas/env.py", """
import array, os, time
now = 0.0
time.process_time = lambda: now
class Env:
    def __init__(self, **options): pass
    def new_action(self): return array.array("d", [0] * 4)
    new_observation = new_action
    def reset(self, observation, seed): pass
    def close(self): pass
    def step(self, action, observation):
        global now
        now += 1 / float(os.environ["PACE"])
""")
        return self.run_script("bench_env", PACE=str(pace)).returncode

    def test_within_its_limit(self):
        self.assertEqual(self.code(21_000), 0)

    def test_a_limit_is_missed(self):
        self.assertEqual(self.code(19_000), 1)


class RealtimeAgreement(Script):
    """A hils whose virtual flights have errors of 1 and 2, and whose flights in real time have $REAL."""

    def code(self, real, hils=0):
        self.write("build/release/bin/hils", f"""#!{sys.executable}
import json, os, pathlib, sys
words = sys.argv
out = pathlib.Path(words[words.index("--out") + 1])
out.mkdir(parents=True, exist_ok=True)
virtual = "--virtual" in words
rms = 1 + int(words[words.index("--seed") + 1]) % 2 if virtual else float(os.environ["REAL"])
(out / "summary.json").write_text(json.dumps({{"vehicles": [{{"rms": {{name: rms for name in {NAMES!r}}}}}]}}))
sys.exit(0 if virtual else int(os.environ["HILS"]))
""")
        return self.run_script("realtime_agreement", "--flights", "2", "--virtual", "2", "--scenario", "hover.yaml",
                               REAL=str(real), HILS=str(hils)).returncode

    def test_within_the_spread(self):
        self.assertEqual(self.code(1.5), 0)

    def test_outside_of_it(self):
        self.assertEqual(self.code(2.1), 1)
        self.assertEqual(self.code(0.9), 1)
        self.assertEqual(self.code("nan"), 1)

    def test_a_busy_machine_is_no_agreement(self):
        self.assertEqual(self.code(1.5, hils=3), 77)

    def test_a_flight_that_failed_is_none(self):
        self.assertNotIn(self.code(1.5, hils=2), (0, 77))


class HashFlights(Script):
    """A hils whose truth is the name of the mode and $TRUTH, and which ends with $HILS."""

    def fly(self, truth, hils=0):
        self.write("build/release/bin/hils", f"""#!{sys.executable}
import os, pathlib, sys
out = pathlib.Path(sys.argv[sys.argv.index("--out") + 1])
out.mkdir(parents=True)
(out / "truth.csv").write_text(sys.argv[3] + os.environ["TRUTH"])
(out / "flight.tlog").write_text("")
sys.exit(int(os.environ["HILS"]))
""")
        self.write("bin/ldd", "#!/bin/sh\necho ldd 1\n")
        self.write("build/release/CMakeCache.txt", f"CMAKE_CXX_COMPILER:FILEPATH={self.tree / 'bin/ldd'}\n")
        self.write("config/scenarios/hover.yaml", "name: hover\n")
        self.write("config/scenarios/px4.yaml", "name: px4\nfirmware:\n  command: [px4]\n")
        return self.run_script("hash_flights", TRUTH=truth, HILS=str(hils))

    def test_prints_what_each_flight_left(self):
        done = self.fly("a")
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = done.stdout.splitlines()
        self.assertEqual(lines[0], "# ldd 1; libm of ldd 1")
        self.assertEqual([line.split("  ")[1] for line in lines[1:]],
                         ["hover virtual truth.csv", "hover virtual flight.tlog", "hover lockstep truth.csv",
                          "hover lockstep flight.tlog"])
        self.assertEqual(lines[1].split()[0], hashlib.sha256(b"--virtuala").hexdigest())

    def test_a_flight_that_failed_has_no_lines(self):
        done = self.fly("a", hils=3)
        self.assertEqual(done.returncode, 1)
        self.assertEqual(len(done.stdout.splitlines()), 1)


class Results(Script):
    """scripts/results: what it runs, and what comes onto the page."""

    PAGE = """# Speed

Made by `bin/measure` on 1 May 2026 at commit 00000000.

| part | us | |
|---|---|---|
| step | 3 | fast |
| start | 7 | |

Steps are fast.
"""
    OUTPUT = "measured:\n| part | us | |\n|---|---|---|\n| step | 4 | fast |\n| end | 1 | |\n"

    def setUp(self):
        super().setUp()
        self.write("bin/git", "#!/bin/sh\ncase \"$*\" in *log*) echo 12345678;; esac\n")
        self.page = self.tree / "docs/develop/results/speed.md"
        self.write("docs/develop/results/speed.md", self.PAGE)

    def measures(self, text, code=0):
        self.write("bin/measure", f"#!/bin/sh\ncat <<END\n{text}END\nexit {code}\n")

    def test_a_table_takes_the_place_of_the_one_before(self):
        self.measures(self.OUTPUT)
        run = self.run_script("results")
        self.assertEqual(run.returncode, 0, run.stderr)
        page = self.page.read_text()
        self.assertIn("| step | 4 | fast |\n| end | 1 | |\n\nSteps are fast.", page)
        self.assertNotIn("start", page)
        self.assertIn("at commit 12345678.", page)
        self.assertNotIn("1 May 2026", page)
        for sentence in ("3 figures moved", "step: us 3 -> 4", "end: new", "start: gone"):
            self.assertIn(sentence, run.stdout)

    def test_a_whole_page(self):
        self.measures("# Speed\n\nAnother page.\n")
        self.assertEqual(self.run_script("results", "speed.md").returncode, 0)
        self.assertEqual(self.page.read_text(), "# Speed\n\nAnother page.\n")

    def test_what_fails_or_prints_no_table_leaves_the_page(self):
        for text, code in ((self.OUTPUT, 3), ("no table\n", 0)):
            self.measures(text, code)
            self.assertEqual(self.run_script("results").returncode, 1)
            self.assertEqual(self.page.read_text(), self.PAGE)

    def test_a_command_without_its_folder_is_left_out(self):
        page = self.PAGE.replace("bin/measure", "bin/measure $CAS_NO_SUCH_FOLDER")
        self.write("docs/develop/results/speed.md", page)
        self.measures(self.OUTPUT)
        run = self.run_script("results")
        self.assertEqual(run.returncode, 0)
        self.assertIn("LEFT OUT, CAS_NO_SUCH_FOLDER is not set", run.stdout)
        self.assertEqual(self.page.read_text(), page)

    def test_a_page_that_is_not_there(self):
        self.assertEqual(self.run_script("results", "none.md").returncode, 2)


class TestPackages(Script):
    """A root folder in which nothing runs: chroot notes its arguments and fails at those in $FAILS."""

    def run_packages(self, fails="", code=1, leaves="", names=("casd", "python3-cas-env")):
        packages = self.tree / "build" / "packages"
        packages.mkdir(parents=True)
        for name in names:
            (packages / f"{name}_1_amd64.deb").write_text("")
        base = self.tree / "base"
        for folder in ("proc", "dev/pts", "etc/cas", "usr/share/cas", "usr/lib", "lib/systemd"):
            (base / folder).mkdir(parents=True)
        (base / "etc/cas/casd.yaml").write_text("schema: 1\n")
        self.write("bin/id", "#!/bin/sh\necho 0\n")
        for name in ("mount", "umount", "debootstrap", "sudo"):
            self.write(f"bin/{name}", "#!/bin/sh\n")
        purge = "rm -rf \"$root\"/etc/cas \"$root\"/usr/share/cas"
        leave = f"mkdir -p \"$root\"/{leaves}; " if leaves else ""
        self.write("bin/chroot", "#!/bin/sh\nroot=$1\n"
                   'case "$*" in *purge*) ' + purge + "; " + leave + ";; esac\n"
                   'test -z "$FAILS" || case "$*" in *"$FAILS"*) exit "$CODE" ;; esac\n')
        return self.run_script("test_packages", str(base), FAILS=fails, CODE=str(code))

    def test_in_order(self):
        done = self.run_packages()
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("packages are in order", done.stdout)

    def test_a_step_fails(self):
        for step in ("apt-get install", "hilsim --version", "casd.1.gz", "--check /etc/cas/casd.yaml", "getent group",
                     "--out /root/direct", "--out /root/hover", "import cas.env",
                     "--reinstall", "purge"):
            with self.subTest(step):
                done = self.run_packages(step)
                self.assertNotEqual(done.returncode, 0)
                self.assertNotIn("packages are in order", done.stdout)
            shutil.rmtree(self.tree / "build")
            shutil.rmtree(self.tree / "base")

    def test_a_flight_that_was_not_judged_is_told(self):
        done = self.run_packages("--out /root/hover", 3)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("was not judged", done.stdout)

    def test_a_package_that_was_not_built_is_told(self):
        done = self.run_packages("import cas.env", names=("casd",))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        self.assertIn("python3-cas-env was not built: not tested", done.stdout)

    def test_something_is_left_behind(self):
        done = self.run_packages(leaves="usr/lib/libcas")
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("left behind", done.stdout)


class ConfigReference(unittest.TestCase):
    """config_reference_test.py in a copy of its input."""

    @contextlib.contextmanager
    def tree(self):
        with tempfile.TemporaryDirectory() as name:
            copy = pathlib.Path(name)
            shutil.copytree(ROOT / "docs", copy / "docs")
            for folder in ("hils", "libsim", "base", "casd", "fcu", "plugins"):
                (copy / folder).symlink_to(ROOT / folder)
            yield copy

    def code(self, tree):
        script = ROOT / "tests" / "base" / "config" / "config_reference_test.py"
        return subprocess.run([sys.executable, script, tree], capture_output=True, text=True, timeout=100)

    def test_a_key_that_nobody_describes_or_reads(self):
        for before, after, complaint in (
                ("`body_drag_linear_n_s_m`", "`nothing`", "'body_drag_linear_n_s_m' is read by"),
                ("| `body_drag_linear_n_s_m` |", "| `body_drag_linear_n_s_m`, `no_such_key` |", "'no_such_key' is described")):
            with self.tree() as tree:
                page = tree / "docs/reference/config.md"
                text = page.read_text()
                self.assertIn(before, text)
                self.assertNotIn(complaint, self.code(tree).stdout)
                page.write_text(text.replace(before, after))
                done = self.code(tree)
                self.assertEqual(done.returncode, 1, done.stdout)
                self.assertIn(complaint, done.stdout)


if __name__ == "__main__":
    unittest.main()
