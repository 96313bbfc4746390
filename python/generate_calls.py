#!/usr/bin/env python3
# SPDX-License-Identifier: BSD-3-Clause
"""Writes cas/casd_calls.py and cas/sim_calls.py: the typed calls, from the descriptions of casd and hilsim.

Usage: generate_calls.py BIN [--check]     BIN is the folder with the programs
    --check  writes nothing; exit 1 where a file is not what the programs say
"""

from __future__ import annotations

import json
import keyword
import os
import subprocess
import sys
import tempfile
import textwrap
import time
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
SIMPLE = {"integer": "int", "number": "float", "string": "str", "boolean": "bool", "null": "None"}

HEAD = '''# SPDX-License-Identifier: BSD-3-Clause
"""The calls of {title}, made by generate_calls.py from its `rpc.discover`. Not written by hand."""

from __future__ import annotations

from typing import Any, Awaitable, Dict, List, NotRequired, Optional, Protocol, TypedDict, Union, cast

from .rpc import AsyncSubscription, Subscription


class _Call(Protocol):
    def __call__(self, method: str, params: Dict[str, Any]) -> Any: ...


class _AsyncCall(Protocol):
    def __call__(self, method: str, params: Dict[str, Any]) -> Awaitable[Any]: ...


class _Subscribe(Protocol):
    def __call__(self, topic: str) -> Subscription[Any]: ...


class _AsyncSubscribe(Protocol):
    def __call__(self, topic: str) -> Awaitable[AsyncSubscription[Any]]: ...


def _given(**params: Any) -> Dict[str, Any]:
    """Without what was left out."""
    return {{key: value for key, value in params.items() if value is not None}}
'''


class Writer:
    """One file of calls, from an OpenRPC document."""

    def __init__(self, document: dict[str, Any], own_group: str) -> None:
        self.document = document
        self.own_group = own_group
        self.schemas: dict[str, Any] = document.get("components", {}).get("schemas", {})
        self.types: list[str] = []
        self.known: set[str] = set()

    def text(self) -> str:
        """The whole file."""
        classes = [self.group_class(group, methods, is_async)
                   for is_async in (False, True) for group, methods in self.groups().items()]
        if self.document["x-topics"]:
            classes += [self.topics_class(is_async) for is_async in (False, True)]
        head = HEAD.format(title=self.document["info"]["title"])
        if not self.document["x-topics"]:
            head = head.replace("from .rpc import AsyncSubscription, Subscription\n\n\n", "\n")
            begin = head.index("class _Subscribe")
            head = head[:begin] + head[head.index("def _given"):]
        head = head.replace("TypedDict, Union, cast\n\n\n\n", "TypedDict, Union, cast\n\n\n")
        return head + "\n\n" + "\n".join(self.types) + "\n\n" + "\n\n\n".join(classes) + "\n"

    def groups(self) -> dict[str, list[dict[str, Any]]]:
        """The methods by the part before their dot."""
        groups: dict[str, list[dict[str, Any]]] = {}
        for method in self.document["methods"]:
            group, dot, _ = method["name"].partition(".")
            if dot and group != "rpc":
                groups.setdefault(group, []).append(method)
        return groups

    def type_of(self, schema: dict[str, Any], name: str) -> str:
        """The Python type of a schema; an object without a name of its own gets `name`."""
        if "$ref" in schema:
            return self.shape(schema["$ref"].rpartition("/")[2])
        if "anyOf" in schema:
            parts = [self.type_of(each, name) for each in schema["anyOf"]]
            if len(parts) == 2 and parts[1] == "None":
                return f"Optional[{parts[0]}]"
            return f"Union[{', '.join(parts)}]"
        kind = schema.get("type")
        if kind == "array":
            return f"List[{self.type_of(schema['items'], name)}]"
        if kind == "object":
            if "properties" not in schema:
                return f"Dict[str, {self.type_of(schema['additionalProperties'], name)}]"
            self.typed_dict(name, schema)
            return name
        return SIMPLE[kind] if kind else "Any"

    def shape(self, name: str) -> str:
        """A shape that the document names."""
        if name not in self.known:
            schema = self.schemas[name]
            if schema.get("type") == "object" and "properties" in schema:
                self.typed_dict(name, schema)
            else:
                self.known.add(name)
                self.types.append(f"{name} = {self.type_of(schema, name + 'Item')}")
        return name

    def typed_dict(self, name: str, schema: dict[str, Any]) -> None:
        """Writes the TypedDict of an object, after those that it needs."""
        if name in self.known:
            return
        self.known.add(name)
        lines = [f'{name} = TypedDict("{name}", {{']
        for key, value in schema["properties"].items():
            kind = self.type_of(value, name + "".join(part.capitalize() for part in key.split("_")))
            if key not in schema.get("required", []):
                kind = f"NotRequired[{kind}]"
            sentence = value.get("description") or value.get("items", {}).get("description", "")
            lines.append(f'    "{key}": {kind},' + (f"  # {sentence}" if sentence else ""))
        self.types.append("\n".join([*lines, "})"]))

    def group_class(self, group: str, methods: list[dict[str, Any]], is_async: bool) -> str:
        """The class with the calls of one group."""
        name = ("Async" if is_async else "") + group.capitalize() + "Calls"
        lines = [f"class {name}:", f'    """{group}.*"""', "",
                 f"    def __init__(self, call: {'_AsyncCall' if is_async else '_Call'}) -> None:",
                 "        self._call = call"]
        for method in methods:
            lines += ["", *self.function(method, is_async)]
        return "\n".join(lines)

    def function(self, method: dict[str, Any], is_async: bool) -> list[str]:
        """One call."""
        word = method["name"].partition(".")[2]
        camel = "".join(part.capitalize() for part in method["name"].replace(".", "_").split("_"))
        params = sorted(method["params"], key=lambda each: not each["required"])
        arguments, notes, star = ["self"], [], False
        for param in params:
            kind = self.type_of(param["schema"], camel + "Params")
            if param["required"]:
                arguments.append(f"{param['name']}: {kind}")
            else:
                arguments += [] if star else ["*"]
                star = True
                arguments.append(f"{param['name']}: Optional[{kind.removeprefix('Optional[').removesuffix(']')}] = None"
                                 if kind.startswith("Optional[") else f"{param['name']}: Optional[{kind}] = None")
            if param.get("summary"):
                notes.append(f"{param['name']}: {param['summary']}")
        result = self.type_of(method["result"]["schema"], camel + "Result") if "result" in method else "Any"
        given = ", ".join(f"{each['name']}={each['name']}" for each in params)
        define = "async def" if is_async else "def"
        keyword_safe = word + "_" if keyword.iskeyword(word) else word
        head = f"    {define} {keyword_safe}({', '.join(arguments)}) -> {result}:"
        if len(head) > 118:
            head = (f"    {define} {keyword_safe}(\n        "
                    + ",\n        ".join(arguments) + f",\n    ) -> {result}:")
        wait = "await " if is_async else ""
        return [head, *docstring(method.get("summary", ""), notes),
                f"        return cast({result}, {wait}self._call(\"{method['name']}\", _given({given})))"]

    def topics_class(self, is_async: bool) -> str:
        """The class with the subscriptions."""
        kind = "AsyncSubscription" if is_async else "Subscription"
        lines = [f"class {'Async' if is_async else ''}Topics:", '    """What may be subscribed to."""', "",
                 f"    def __init__(self, subscribe: {'_AsyncSubscribe' if is_async else '_Subscribe'}) -> None:",
                 "        self._subscribe = subscribe"]
        for name, topic in self.document["x-topics"].items():
            notice = self.type_of(topic["params"], name.capitalize() + "Notice")
            lines += ["", f"    {'async def' if is_async else 'def'} {name}(self) -> {kind}[{notice}]:",
                      *docstring(topic["summary"], []),
                      f"        return {'await ' if is_async else ''}self._subscribe(\"{name}\")"]
        return "\n".join(lines)


def docstring(summary: str, notes: list[str]) -> list[str]:
    """The lines of a docstring."""
    if not notes:
        return [f'        """{summary}"""']
    return [f'        """{summary}', "",
            *(line for note in notes for line in textwrap.wrap(note, 100, initial_indent=" " * 8,
                                                               subsequent_indent=" " * 12)), '        """']


def ask(socket_path: Path, process: subprocess.Popen[bytes]) -> dict[str, Any]:
    """The description of the program that listens there once it is ready."""
    from cas.errors import NotRunning
    from cas.rpc import Client

    deadline = time.monotonic() + 60
    while True:
        try:
            with Client(socket_path) as client:
                return client.describe()
        except NotRunning:
            if process.poll() is not None or time.monotonic() > deadline:
                raise
            time.sleep(0.02)


def describe(programs: Path) -> dict[str, dict[str, Any]]:
    """Starts casd and hilsim, asks both, and ends them."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "casd.yaml").write_text(json.dumps({
            "schema": 1, "command_port": {"address": "127.0.0.1", "port": 0, "unix": str(folder / "casd.sock")},
            "links": [{"name": "sim", "type": "udp", "local": "127.0.0.1:0"}]}))
        (folder / "world.yaml").write_text(json.dumps({
            "schema": 1, "world": {"gravity_m_s2": 9.80665, "ground": True},
            "home": {"lat_deg": 47, "lon_deg": 8, "alt_m": 0}, "decimal_year": 2026.5, "step_us": 1000, "pace": "free_run",
            "vehicles": [{"name": "iris0", "vehicle": "vehicles/iris_paper.yaml", "plugins": [{"plugin": "motor"}]}]}))
        environment = {**os.environ, "CAS_RUNTIME_DIR": str(folder)}
        commands = {"casd": ["casd", "casd.yaml"],
                    "sim": ["hilsim", "world.yaml", "--paused", "--control", str(folder / "sim.sock")]}
        documents = {}
        for which, command in commands.items():
            process = subprocess.Popen([str(programs / command[0]), *command[1:]], cwd=folder, env=environment,
                                       stderr=subprocess.DEVNULL)
            try:
                documents[which] = ask(folder / f"{which}.sock", process)
            finally:
                process.terminate()
                process.wait(20)
        return documents


def main() -> int:
    """By the command line."""
    arguments = [each for each in sys.argv[1:] if each != "--check"]
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    sys.path.insert(0, str(HERE))
    wrong = 0
    for which, document in describe(Path(arguments[0]).resolve()).items():
        file = HERE / "cas" / f"{which}_calls.py"
        for method in document["methods"]:
            if method.get("x-undescribed"):
                print(f"{document['info']['title']} has a method {method['name']} that it does not describe")
                wrong = 1
        text = Writer(document, which).text()
        if "--check" not in sys.argv:
            file.write_text(text)
        elif file.read_text() != text:
            print(f"{file} is not what the program says: python3 python/generate_calls.py {arguments[0]}")
            wrong = 1
    return wrong


if __name__ == "__main__":
    sys.exit(main())
