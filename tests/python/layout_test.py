# SPDX-License-Identifier: BSD-3-Clause
"""The package needs only the standard library, and its files list their own names."""

import ast
import sys
import unittest

from helpers import SOURCE

PACKAGE = SOURCE / "python" / "cas"
OPTIONAL = {"numpy", "matplotlib", "gymnasium"}


class LayoutTest(unittest.TestCase):
    def test_only_the_standard_library_is_imported(self):
        for file in PACKAGE.glob("*.py"):
            for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
                names = []
                if isinstance(node, ast.Import):
                    names = [alias.name for alias in node.names]
                elif isinstance(node, ast.ImportFrom) and node.level == 0:
                    names = [node.module or ""]
                for name in names:
                    top = name.partition(".")[0]
                    self.assertIn(top, sys.stdlib_module_names | OPTIONAL | {"__future__"}, file.name)

    def test_public_symbols_have_docstrings(self):
        for file in PACKAGE.glob("*.py"):
            tree = ast.parse(file.read_text(encoding="utf-8"))
            self.assertTrue(ast.get_docstring(tree), file.name)
            parents = [(tree, "")] + [(node, node.name + ".") for node in tree.body
                                      if isinstance(node, ast.ClassDef) and not node.name.startswith("_")]
            for parent, prefix in parents:
                for node in parent.body:
                    if isinstance(node, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)):
                        if not node.name.startswith("_"):
                            self.assertTrue(ast.get_docstring(node), f"{file.name}: {prefix}{node.name}")

    def test_its_version_is_the_projects(self):
        import cas
        self.assertIn(f"project(cas VERSION {cas.__version__} ", (SOURCE / "CMakeLists.txt").read_text())
        self.assertIn(f'version = "{cas.__version__}"', (SOURCE / "python/pyproject.toml").read_text())


if __name__ == "__main__":
    unittest.main()
