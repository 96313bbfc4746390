# SPDX-License-Identifier: BSD-3-Clause
"""Connections: answers by id, notifications, errors, ends."""

import asyncio
import threading
import time
import unittest

from helpers import PATIENCE_S, FakeServer, FolderTest

import cas
from cas import rpc


def result(request, value):
    return {"jsonrpc": "2.0", "id": request["id"], "result": value}


def notice(topic, params):
    return {"jsonrpc": "2.0", "method": topic, "params": params}


class ClientTest(FolderTest):
    def server(self, answer):
        server = FakeServer(self.folder / "s.sock", answer)
        self.addCleanup(server.close)
        return server.path

    def test_answers_are_matched_by_their_ids(self):
        waiting = []

        def answer(request):
            waiting.append(request)
            if len(waiting) < 2:
                return []
            return [result(waiting[1], waiting[1]["method"]), result(waiting[0], waiting[0]["method"])]

        got = {}
        with rpc.Client(self.server(answer), timeout_s=PATIENCE_S) as client:
            other = threading.Thread(target=lambda: got.update(first=client.call("first")))
            other.start()
            deadline = time.monotonic() + PATIENCE_S
            while not waiting and time.monotonic() < deadline:
                time.sleep(0.01)
            got["second"] = client.call("second")
            other.join()
        self.assertEqual(got, {"first": "first", "second": "second"})

    def test_errors_become_exceptions_by_their_code(self):
        kinds = {-32601: cas.WrongCall, -32602: cas.WrongCall, -32000: cas.Refused, -32001: cas.NoAcknowledgement,
                 -32002: cas.NoSuchVehicle, -32003: cas.NotAuthorised, -32004: cas.Interlock, -32603: cas.CallError}

        def answer(request):
            error = {"code": request["params"]["code"], "message": "no", "data": {"result": "DENIED"}}
            return [{"jsonrpc": "2.0", "id": request["id"], "error": error}]

        with rpc.Client(self.server(answer), timeout_s=PATIENCE_S) as client:
            for code, kind in kinds.items():
                with self.assertRaises(kind) as caught:
                    client.call("vehicle.arm", {"code": code})
                self.assertEqual(type(caught.exception), kind)
                self.assertEqual(str(caught.exception), "vehicle.arm: no")
                self.assertEqual(caught.exception.code, code)
                self.assertEqual(caught.exception.data, {"result": "DENIED"})

    def test_a_subscription_yields_what_comes_between_request_and_answer(self):
        def answer(request):
            if request["method"] == "work":
                return [notice("texts", 1), notice("others", 0), notice("texts", 2), result(request, "done"), None]
            return [result(request, True)]

        client = rpc.Client(self.server(answer), timeout_s=PATIENCE_S)
        texts = client.subscribe("texts")
        self.assertEqual(client.call("work"), "done")
        self.assertEqual(list(texts), [1, 2])  # ends with the connection
        client.close()

    def test_leaving_the_block_ends_the_subscription(self):
        methods = []

        def answer(request):
            methods.append(request["method"])
            return [result(request, True)]

        with rpc.Client(self.server(answer), timeout_s=PATIENCE_S) as client:
            with client.subscribe("texts") as texts:
                with self.assertRaises(cas.CallTimeout):
                    texts.next(timeout_s=0.01)
        self.assertEqual(methods, ["subscribe", "unsubscribe"])

    def test_what_never_answers_times_out(self):
        with rpc.Client(self.server(lambda request: [])) as client:
            with self.assertRaisesRegex(cas.CallTimeout, "did not answer sim.step in 0.01 s"):
                client.call("sim.step", timeout_s=0.01)

    def test_a_connection_that_ends_fails_its_calls(self):
        with rpc.Client(self.server(lambda request: [None]), timeout_s=PATIENCE_S) as client:
            with self.assertRaises(cas.ConnectionLost):
                client.call("casd.status")
            with self.assertRaises(cas.ConnectionLost):
                client.call("casd.status")

    def test_who_does_not_listen_is_named_with_what_to_start(self):
        for connect in (cas.Casd, cas.Sim):
            with self.assertRaisesRegex(cas.NotRunning, r"nothing answers at .*; start .*cas\.Bench"):
                connect(self.folder / "nothing.sock")

    def test_an_address_is_a_path_or_a_host_with_a_port(self):
        self.assertEqual(rpc.host_and_port("[::1]:5790"), ("::1", 5790))
        self.assertTrue(rpc.is_unix("unix:a.sock"))
        self.assertFalse(rpc.is_unix("127.0.0.1:5790"))
        with self.assertRaises(ValueError):
            rpc.host_and_port("localhost")

    def test_the_async_client_does_the_same(self):
        def answer(request):
            if request["method"] == "work":
                return [notice("texts", 7), result(request, 8)]
            if "fail" in (request["method"], request["params"].get("topic")):
                return [{"jsonrpc": "2.0", "id": request["id"], "error": {"code": -32000, "message": "no"}}]
            return [result(request, True)]

        path = self.server(answer)

        async def talk():
            async with await rpc.AsyncClient.connect(path, timeout_s=PATIENCE_S) as client:
                async with await client.subscribe("texts") as texts:
                    first, second = await asyncio.gather(client.call("work"), client.call("work"))
                    self.assertEqual((first, second), (8, 8))
                    self.assertEqual([await texts.__anext__(), await texts.__anext__()], [7, 7])
                with self.assertRaises(cas.Refused):
                    await client.call("fail")
                with self.assertRaises(cas.Refused):
                    await client.subscribe("fail")
                self.assertEqual(client._subscriptions["fail"], [])
            with self.assertRaises(cas.NotRunning):
                await cas.AsyncCasd.connect(self.folder / "nothing.sock")

        asyncio.run(talk())


class TokenTest(unittest.TestCase):
    def test_the_proof_is_an_hmac_of_five_lines(self):
        # printf 'cas\nserver\n127.0.0.1:5790\naaaa\nbbbb\n' | openssl dgst -sha256 -hmac secret
        self.assertEqual(rpc.token_proof("secret", "server", "127.0.0.1:5790", "aaaa", "bbbb"), PROOF)

    def test_ipv4_is_written_as_ipv4(self):
        self.assertEqual(rpc.endpoint_text(("::ffff:127.0.0.1", 5790, 0, 0)), "127.0.0.1:5790")
        self.assertEqual(rpc.endpoint_text(("::1", 5790, 0, 0)), "[::1]:5790")


PROOF = "0227634fc8c1935fb49727efb5a015403b1e1274dcd0bd0573b0298cc2992759"

if __name__ == "__main__":
    unittest.main()
