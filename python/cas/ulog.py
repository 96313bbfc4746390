# SPDX-License-Identifier: BSD-3-Clause
"""ULog, the log format of PX4 (docs.px4.io, ULog File Format): topics as tables."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any, Union

from .errors import FormatError
from .table import Table

MAGIC = b"ULog\x01\x12\x35"
_CODES = {"int8_t": "b", "uint8_t": "B", "int16_t": "h", "uint16_t": "H", "int32_t": "i", "uint32_t": "I",
          "int64_t": "q", "uint64_t": "Q", "float": "f", "double": "d", "bool": "?", "char": "c"}


class _Format:
    """Columns and packing of one message."""

    def __init__(self, formats: dict[str, str], name: str) -> None:
        self.columns: list[str] = []
        code = self._expand(formats, name, "")
        while self.columns and "_padding" in self.columns[-1]:
            self.columns.pop()  # may be missing at the end of a message
            code = code[:-1]
        self.struct = struct.Struct("<" + code)

    def _expand(self, formats: dict[str, str], name: str, prefix: str) -> str:
        code = ""
        for entry in filter(None, formats[name].split(";")):
            kind, _, field = entry.partition(" ")
            kind, _, length = kind.partition("[")
            count = int(length.rstrip("]")) if length else 0
            for index in range(count or 1):
                path = prefix + field + (f"[{index}]" if count else "")
                if kind in _CODES:
                    self.columns.append(path)
                    code += _CODES[kind]
                else:
                    code += self._expand(formats, kind, path + ".")
        return code


class Ulog:
    """A ULog file, read into memory.

    `topics["vehicle_attitude"]` is a Table with `time_s` and the fields in PX4's units, of an array `q[0]`, ...;
    a further instance of a topic is `NAME.1`. `info` and `parameters` are the facts and the first values;
    `changed` lists (time_s, name, value) of parameters that changed; `texts` (time_s, level, text).
    """

    def __init__(self, path: Union[str, Path]) -> None:
        self.path = Path(path)
        self.info: dict[str, Any] = {}
        self.parameters: dict[str, Any] = {}
        self.changed: list[tuple[float, str, Any]] = []
        self.texts: list[tuple[float, str, str]] = []
        data = self.path.read_bytes()
        if data[:7] != MAGIC:
            raise FormatError(f"{path} is no ULog file")
        self._formats: dict[str, str] = {}
        self._layouts: dict[str, _Format] = {}
        self._names: dict[int, tuple[str, str]] = {}
        self._rows: dict[str, list[tuple[Any, ...]]] = {}
        self._of_format: dict[str, str] = {}
        self._now_s = 0.0
        self._in_data = False
        self._read(data)
        self.topics = {name: self._table(name, rows) for name, rows in self._rows.items()}

    def _read(self, data: bytes) -> None:
        place = 16
        while place + 3 <= len(data):
            size, kind = struct.unpack_from("<HB", data, place)
            body = data[place + 3:place + 3 + size]
            if len(body) < size:
                return  # cut off
            self._on_message(chr(kind), body)
            place += 3 + size

    def _on_message(self, kind: str, body: bytes) -> None:
        if kind == "F":
            name, _, fields = body.decode("utf-8", "replace").partition(":")
            self._formats[name] = fields
        elif kind in "IM":
            key, value = _key_value(body[1:] if kind == "M" else body)
            self.info[key] = self.info.get(key, []) + [value] if kind == "M" else value
        elif kind == "P":
            key, value = _key_value(body)
            if self._in_data:
                self.changed.append((self._now_s, key, value))
            else:
                self.parameters[key] = value
        elif kind == "A":
            self._in_data = True
            instance, number = struct.unpack_from("<BH", body)
            form = body[3:].decode("utf-8", "replace")
            name = form if instance == 0 else f"{form}.{instance}"
            self._names[number] = (name, form)
            self._rows.setdefault(name, [])
            self._of_format[name] = form
        elif kind == "D":
            self._on_data(body)
        elif kind == "L":
            level, stamp = struct.unpack_from("<BQ", body)
            self._now_s = stamp * 1e-6
            words = "emergency alert critical error warning notice info debug".split()
            at = level - ord("0")
            self.texts.append((self._now_s, words[at] if 0 <= at < len(words) else str(level),
                               body[9:].decode("utf-8", "replace")))

    def _on_data(self, body: bytes) -> None:
        (number,) = struct.unpack_from("<H", body)
        if number not in self._names:
            return
        name, form = self._names[number]
        layout = self._layout(form)
        row = layout.struct.unpack_from(body.ljust(2 + layout.struct.size, b"\0"), 2)
        self._now_s = row[layout.columns.index("timestamp")] * 1e-6
        self._rows[name].append(row)

    def _layout(self, form: str) -> _Format:
        if form not in self._layouts:
            self._layouts[form] = _Format(self._formats, form)
        return self._layouts[form]

    def _table(self, name: str, rows: list[tuple[Any, ...]]) -> Table:
        names = self._layout(self._of_format[name]).columns
        columns = dict(zip(names, zip(*rows))) if rows else {key: () for key in names}
        times = [stamp * 1e-6 for stamp in columns.get("timestamp", ())]
        return Table({"time_s": times, **{key: values for key, values in columns.items()
                                          if key != "timestamp" and "_padding" not in key}})


def _key_value(body: bytes) -> tuple[str, Any]:
    length = body[0]
    kind, _, key = body[1:1 + length].decode("utf-8", "replace").partition(" ")
    raw = body[1 + length:]
    base = kind.partition("[")[0]
    if base == "char":
        return key, raw.decode("utf-8", "replace")
    code = _CODES.get(base)
    if code is None or struct.calcsize(code) > len(raw):
        return key, raw
    return key, struct.unpack_from("<" + code, raw)[0]


def read_ulog(path: Union[str, Path]) -> Ulog:
    """Reads a .ulg file."""
    return Ulog(path)
