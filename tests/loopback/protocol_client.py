#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Sends every example request of docs/develop/protocol.md to a running casd and compares the answers.

Usage: protocol_client.py PAGE HOST:PORT     exit 0: casd answers as the page says

An example answer stands for its shape: each of its keys must be there with a value of the same kind, error
codes must be the same. Lists are compared by their first elements.
"""

import json
import socket
import sys


def examples(page):
    """Pairs (request, answer) of the page's json blocks."""
    request = None
    for line in open(page, encoding="utf-8"):
        if line.startswith("-> "):
            request = json.loads(line[3:])
        elif line.startswith("<- "):
            yield request, json.loads(line[3:])


def kind(value):
    if isinstance(value, bool):
        return "boolean"
    if isinstance(value, (int, float)):
        return "number"
    return type(value).__name__


def differences(expected, actual, path):
    """Where an answer has another shape than the page's."""
    if expected is None or (path.endswith("/statustexts") and not actual):
        return
    if kind(expected) != kind(actual):
        yield f"{path}: the page has {kind(expected)}, casd {kind(actual)} ({actual!r})"
    elif isinstance(expected, dict):
        for key, value in expected.items():
            if key not in actual:
                yield f"{path}/{key}: missing"
            else:
                yield from differences(value, actual[key], f"{path}/{key}")
    elif isinstance(expected, list) and expected and actual:
        yield from differences(expected[0], actual[0], f"{path}[0]")
    elif path.endswith("/error/code") and expected != actual:
        yield f"{path}: the page has {expected}, casd {actual}"


class Client:
    """One connection: a line a request, a line an answer."""

    def __init__(self, address):
        host, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((host, int(port)), timeout=30)
        self.lines = self.socket.makefile("r", encoding="utf-8", newline="\n")

    def send(self, text):
        self.socket.sendall((text + "\n").encode())

    def answer(self):
        """The next line that is no notification."""
        while True:
            message = json.loads(self.lines.readline())
            if isinstance(message, list) or "id" in message:
                return message


def check_examples(client, page):
    faults = []
    count = 0
    for request, expected in examples(page):
        client.send(json.dumps(request))
        actual = client.answer()
        count += 1
        if actual.get("id") != request["id"]:
            faults.append(f"{request['method']}: answered with id {actual.get('id')}")
        faults += [f"{request['method']}: {text}" for text in differences(expected, actual, "")]
    if count < 30:
        faults.append(f"only {count} examples were found on the page")
    return faults


def check_completeness(client, page):
    """Every method that casd has is shown on the page, and its parameters are named there."""
    client.send('{"jsonrpc":"2.0","id":1,"method":"methods"}')
    has = set(client.answer()["result"])
    shown = {request["method"] for request, _ in examples(page)}
    text = open(page, encoding="utf-8").read()
    faults = [f"{method}: not shown on the page" for method in sorted(has - shown)]
    return faults + [f"{method}: not described on the page" for method in sorted(has)
                     if "." in method and f"**{method}**" not in text]


def check_end(address):
    """The page on a line that is no JSON: casd ends the connection."""
    client = Client(address)
    client.send('this is no JSON\n{"jsonrpc":"2.0","id":1,"method":"link.list"}')
    faults = []
    if client.answer()["error"]["code"] != -32700:
        faults.append("a line that is no JSON is not answered with -32700")
    if client.lines.readline():
        faults.append("a line after one that is no JSON was answered")
    return faults


def check_rules(client):
    """The page on batches, notifications and blank lines."""
    faults = []
    client.send("")
    client.send('[{"jsonrpc":"2.0","id":1,"method":"link.list"},{"jsonrpc":"2.0","method":"link.list"},'
                '{"jsonrpc":"2.0","id":2,"method":"nothing"}]')
    if [each["id"] for each in client.answer()] != [1, 2]:
        faults.append("a batch is not answered by an array in the order of its requests")
    client.send('{"jsonrpc":"2.0","method":"link.list"}')
    client.send('{"jsonrpc":"2.0","id":9,"method":"link.list"}')
    if client.answer()["id"] != 9:
        faults.append("a notification was answered")
    return faults


def main():
    page, address = sys.argv[1:]
    client = Client(address)
    faults = check_completeness(client, page) + check_examples(client, page)
    faults += check_rules(client) + check_end(address)
    for fault in faults:
        print(fault)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
