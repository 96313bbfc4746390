# SPDX-License-Identifier: BSD-3-Clause
"""docs/use/python.md: it names each example, and each of its own programs is pasted into a file and run."""

import re
import subprocess
import sys
import unittest

from helpers import SOURCE, FolderTest

PAGE = SOURCE / "docs/use/python.md"
EXAMPLES = SOURCE / "python" / "examples"
LONGEST_S = 120  # for one program, on a machine that may be busy


def blocks():
    return re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.S)


class PageTest(FolderTest):
    def test_every_example_is_named_on_the_page(self):
        names = [file.name for file in EXAMPLES.glob("*.py")]
        self.assertTrue(names)
        for name in names:
            self.assertIn(f"| `{name}` |", PAGE.read_text(encoding="utf-8"), f"docs/use/python.md does not name {name}")

    def test_its_programs_run(self):
        self.assertGreaterEqual(len(blocks()), 3)
        for number, block in enumerate(blocks()):
            script = self.folder / f"block_{number}.py"
            script.write_text(block, encoding="utf-8")
            done = subprocess.run([sys.executable, str(script)], capture_output=True, text=True, check=False,
                                  timeout=LONGEST_S)
            self.assertEqual(done.returncode, 0, f"{block}\n{done.stdout}{done.stderr}")


if __name__ == "__main__":
    unittest.main()
