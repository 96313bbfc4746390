# SPDX-License-Identifier: BSD-3-Clause
"""docs/use/python.md: each of its programs is an example, letter by letter, or is pasted into a file and run."""

import re
import subprocess
import sys
import unittest

from helpers import SOURCE, FolderTest

PAGE = SOURCE / "docs/use/python.md"
EXAMPLES = SOURCE / "python" / "examples"
LONGEST_S = 120  # for one program, on a machine that may be busy
LICENCE = "# SPDX-License-Identifier: BSD-3-Clause\n"


def blocks():
    return re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)


def examples():
    """The programs of python/examples without their first line, which their own tests run."""
    return {file.name: file.read_text(encoding="utf-8").removeprefix(LICENCE) for file in EXAMPLES.glob("*.py")}


class PageTest(FolderTest):
    def test_every_example_is_on_the_page(self):
        for name, text in examples().items():
            self.assertIn(text, blocks(), f"{name} is not on docs/use/python.md as it is")

    def test_what_else_is_on_the_page_runs(self):
        others = [block for block in blocks() if block not in examples().values()]
        self.assertGreaterEqual(len(others), 3)
        for number, block in enumerate(others):
            script = self.folder / f"block_{number}.py"
            script.write_text(block, encoding="utf-8")
            done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=False,
                                  timeout=LONGEST_S)
            self.assertEqual(done.returncode, 0, f"{block}\n{done.stdout}{done.stderr}")


if __name__ == "__main__":
    unittest.main()
