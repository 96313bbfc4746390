# SPDX-License-Identifier: BSD-3-Clause
"""The source package is whole: it works outside of the tree."""

import importlib.util
import os
import subprocess
import sys
import tarfile
import unittest

from helpers import SOURCE, FolderTest

# setuptools belongs to the system's Python where another one runs the tests.
PYTHON = sys.executable if importlib.util.find_spec("setuptools") else "/usr/bin/python3"


class SdistTest(FolderTest):
    def test_it_has_the_package_its_types_and_its_dialect(self):
        made = subprocess.run([PYTHON, str(SOURCE / "python/make_sdist.py"), "out"], capture_output=True, text=True, check=False)
        self.assertEqual(made.returncode, 0, made.stdout + made.stderr)
        (name,) = os.listdir("out")
        with tarfile.open(f"out/{name}") as archive:
            archive.extractall(".")
        top = name.removesuffix(".tar.gz")
        for file in ("LICENSE", "README.md", "pyproject.toml", "cas/py.typed", "cas/casd_calls.py"):
            self.assertTrue(os.path.isfile(f"{top}/{file}"), file)
        script = "import cas; print(cas.__file__, cas.mavlink.common().message('HIL_SENSOR').crc_extra)"
        done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True,
                              env={**os.environ, "PYTHONPATH": str(self.folder / top)})
        self.assertEqual(done.stdout.split(), [str(self.folder / top / "cas/__init__.py"), "108"])


if __name__ == "__main__":
    unittest.main()
