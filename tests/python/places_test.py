# SPDX-License-Identifier: BSD-3-Clause
"""Which token and which port the package takes: only those that another user cannot have laid out."""

import os
import socket
import unittest
from unittest import mock

from helpers import FolderTest

import cas
from cas import places, rpc

TOKEN = "0123456789abcdef0123456789abcdef"
SOMEBODY = 1234


class TokenTest(FolderTest):
    def setUp(self):
        super().setUp()
        os.chmod(self.folder, 0o700)
        self.token = self.folder / "casd.token"
        self.token.write_text(TOKEN + "\nmore\n")
        os.chmod(self.token, 0o600)

    def test_the_first_line_of_a_private_file(self):
        self.assertEqual(places.token_of(self.folder), TOKEN)

    def test_none_where_others_may_write_or_read(self):
        for path, mode in ((self.token, 0o644), (self.token, 0o660), (self.folder, 0o777), (self.folder, 0o1777)):
            before = path.stat().st_mode
            os.chmod(path, mode)
            self.assertIsNone(places.token_of(self.folder), (path, oct(mode)))
            os.chmod(path, before)

    def test_none_that_could_be_guessed(self):
        self.token.write_text("short\n")
        self.assertIsNone(places.token_of(self.folder))

    def test_none_behind_a_symlink(self):
        link = self.folder / "link"
        link.symlink_to(self.folder)
        self.assertIsNone(places.token_of(link))

    @unittest.skipIf(os.geteuid() != 0, "only root can make a file for another user")
    def test_none_of_another_user(self):
        os.chown(self.token, SOMEBODY, SOMEBODY)
        self.assertIsNone(places.token_of(self.folder))
        os.chown(self.token, 0, 0)
        os.chown(self.folder, SOMEBODY, SOMEBODY)
        self.assertIsNone(places.token_of(self.folder))


class PortTest(unittest.TestCase):
    def test_a_listener_of_this_user_is_its_own(self):
        with socket.create_server(("127.0.0.1", 0)) as server:
            port = server.getsockname()[1]
            self.assertTrue(places.is_own_port(port))
            rpc.refuse_stranger(f"127.0.0.1:{port}")
            with mock.patch("os.getuid", return_value=SOMEBODY):
                self.assertFalse(places.is_own_port(port))
                with self.assertRaises(cas.ConnectionLost):
                    rpc.refuse_stranger(f"127.0.0.1:{port}")
        self.assertFalse(places.is_own_port(port))

    def test_other_machines_are_not_asked(self):
        rpc.refuse_stranger("192.0.2.7:5790")


if __name__ == "__main__":
    unittest.main()
