# SPDX-License-Identifier: BSD-3-Clause
"""Helpers shared by the tests of package cas."""

import json
import os
import socket
import sys
import tempfile
import threading
import unittest
from pathlib import Path

SOURCE = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(SOURCE / "python"))

PATIENCE_S = 20.0

# Children find the package, too, and leave nothing in the tree.
os.environ["PYTHONPATH"] = str(SOURCE / "python")
os.environ["PYTHONDONTWRITEBYTECODE"] = "1"


class FolderTest(unittest.TestCase):
    """With a fresh temporary folder, which is the working folder meanwhile."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="cas-test-")
        self.addCleanup(folder.cleanup)
        self.addCleanup(os.chdir, os.getcwd())
        os.chdir(folder.name)
        self.folder = Path(folder.name)


class FakeServer:
    """Answers lines on a Unix socket: `answer(request)` returns lines, as objects, and None to hang up."""

    def __init__(self, path, answer):
        self.path = path
        self.answer = answer
        self.listener = socket.socket(socket.AF_UNIX)
        self.listener.bind(str(path))
        self.listener.listen()
        threading.Thread(target=self._serve, daemon=True).start()

    def _serve(self):
        while True:
            try:
                connection, _ = self.listener.accept()
            except OSError:
                return
            threading.Thread(target=self._talk, args=(connection,), daemon=True).start()

    def _talk(self, connection):
        with connection, connection.makefile("rb") as lines:
            for line in lines:
                for each in self.answer(json.loads(line)):
                    if each is None:
                        return
                    connection.sendall(json.dumps(each).encode() + b"\n")

    def close(self):
        self.listener.close()
