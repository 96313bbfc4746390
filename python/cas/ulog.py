# SPDX-License-Identifier: BSD-3-Clause
"""ULog, the log format of PX4 (docs.px4.io, ULog File Format): topics as tables."""

from __future__ import annotations

import re
import struct
from pathlib import Path
from typing import Any, Optional, Union

from .errors import FormatError
from .table import Table

MAGIC = b"ULog\x01\x12\x35"
_SYNC = b"\x2f\x73\x13\x20\x25\x0c\xbb\x12"
_CODES = {"int8_t": "b", "uint8_t": "B", "int16_t": "h", "uint16_t": "H", "int32_t": "i", "uint32_t": "I",
          "int64_t": "q", "uint64_t": "Q", "float": "f", "double": "d", "bool": "?", "char": "c"}


#: Kinds of messages, and the least bytes of each; some have exactly these.
_LEAST_BYTES = {"S": 8, "O": 2, "R": 2, "D": 10, "A": 4, "L": 10, "C": 12, "I": 4, "M": 5, "P": 4, "Q": 5, "F": 3, "B": 40}
_KINDS = re.compile(b"[SORDALCIMPQFB]")
_EXACT_KINDS = "SOR"
#: Messages in a row, of right kinds and sizes, that are believed behind damage.
_CHAIN = 3
_MOST_IN_CHAIN = 32
_HEADER_BYTES = 16
_MOST_DEPTH = 16
_GAP_US = 10_000_000
_WHILE_US = 2_000_000
_MOST_BYTES = 65535


class _Format:
    """Columns and packing of one message. KeyError, ValueError: the log does not define it, or nonsense."""

    def __init__(self, formats: dict[str, str], name: str) -> None:
        self.columns: list[str] = []
        code = self._expand(formats, name, "", 0)
        #: Bytes with the padding at its end, which may be missing in a message.
        self.most_bytes = struct.calcsize("<" + code)
        while self.columns and "_padding" in self.columns[-1]:
            self.columns.pop()
            code = code[:-1]
        self.struct = struct.Struct("<" + code)
        self.stamp_column = self.columns.index("timestamp")

    def _expand(self, formats: dict[str, str], name: str, prefix: str, depth: int) -> str:
        if depth > _MOST_DEPTH:
            raise ValueError(f"type {name} is nested too deep")
        code = ""
        for entry in filter(None, formats[name].split(";")):
            kind, _, field = entry.partition(" ")
            kind, _, length = kind.partition("[")
            count = int(length.rstrip("]")) if length else 0
            if not field or not 0 <= count <= _MOST_BYTES or len(self.columns) > _MOST_BYTES:
                raise ValueError(f"type {name} has {entry}, which is no field")
            for index in range(count or 1):
                path = prefix + field + (f"[{index}]" if count else "")
                if kind in _CODES:
                    self.columns.append(path)
                    code += _CODES[kind]
                else:
                    code += self._expand(formats, kind, path + ".", depth + 1)
        return code


class _Leaps:
    """Which stamps are right: a leap of more than 10 s, as a damaged stamp or a topic with a clock of its own makes one,
    is believed where most topics make it; the same as UlogTime of `hils replay`."""

    def __init__(self, start_us: int) -> None:
        self.newest = start_us
        self.heard: dict[str, int] = {}
        #: Stamps of a leap that is not believed yet, by topic, and the topics that stayed since.
        self.leapt: dict[str, int] = {}
        self.stayed: set[str] = set()
        self.began = 0

    def takes(self, topic: str, stamp: int) -> bool:
        if stamp > self.newest + _GAP_US:
            if not self._is_confirmed(topic, stamp):
                return False
            self.leapt = {}
        elif self.leapt:
            self.stayed.add(topic)
            self.leapt.pop(topic, None)
        self.newest = max(self.newest, stamp)
        self.heard[topic] = stamp
        return True

    def _is_confirmed(self, topic: str, stamp: int) -> bool:
        self.leapt = {other: at for other, at in self.leapt.items() if other == topic or abs(at - stamp) <= _GAP_US}
        if not self.leapt:
            self.stayed, self.began = set(), stamp
        goes_on = topic in self.leapt and stamp > self.leapt[topic]
        self.leapt[topic] = stamp
        if (len(self.leapt) < 2 and not goes_on) or len(self.leapt) <= len(self.stayed):
            return False
        of_late = sum(at + _GAP_US >= self.newest for at in self.heard.values())
        return 2 * len(self.leapt) > of_late or (not self.stayed and stamp >= self.began + _WHILE_US)


class Ulog:
    """A ULog file, read into memory.

    `topics["vehicle_attitude"]` is a Table with `time_s` and the fields in PX4's units, of an array `q[0]`, ...;
    a further instance of a topic is `NAME.1`. `info` and `parameters` are the facts and the first values;
    `changed` lists (time_s, name, value) of parameters that changed; `texts` (time_s, level, text). Bytes that are no
    message are left out and counted in `damaged`; a definition that was lost costs its topic (`lost`) alone.
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
        #: Bytes that are left out: damage, messages of lost topics, a message that the log ends within. 0: it is whole.
        self.damaged = 0
        #: Messages that are left out because their time is wrong by that of most topics.
        self.wrong_stamps = 0
        #: Topics whose definition is lost.
        self.lost: list[str] = []
        self._data = data
        self._formats: dict[str, str] = {}
        self._layouts: dict[str, _Format] = {}
        self._names: dict[int, tuple[str, str]] = {}
        self._rows: dict[str, list[tuple[Any, ...]]] = {}
        self._of_format: dict[str, str] = {}
        self._now_s = 0.0
        self._in_data = False
        self._leaps = _Leaps(int.from_bytes(data[8:16], "little"))
        self._waiting: list[tuple[str, int, tuple[Any, ...]]] = []
        self._read()
        self._decide_waiting(not self._leaps.heard)
        self.topics = {name: self._table(name, rows) for name, rows in self._rows.items()}

    def _read(self) -> None:
        data, place = self._data, _HEADER_BYTES
        while place < len(data):
            end = self._end_of(place)
            if end is None or not self._is_message(place, end) or not self._on_message(chr(data[place + 2]),
                                                                                      data[place + 3:end]):
                is_skipped = end is not None and self._is_skipped(place, end)
                following = end if end is not None and is_skipped else self._next_place(place + 1, len(data))
                if not is_skipped or chr(data[place + 2]) in _LEAST_BYTES:  # else it is of a later logger
                    self.damaged += following - place
                place = following
            else:
                place = end

    def _end_of(self, place: int) -> Optional[int]:
        """Where the message at this place ends; None: behind the log."""
        if place + 3 > len(self._data):
            return None
        end: int = place + 3 + self._data[place] + (self._data[place + 1] << 8)
        return end if end <= len(self._data) else None

    def _is_message(self, place: int, end: int) -> bool:
        """Whether kind and size are right: by the message's contents, or because others follow and none begin inside."""
        return self._is_plausible(place) and (self._is_sure(place, end) or self._is_followed(place, end))

    def _is_skipped(self, place: int, end: int) -> bool:
        """Whether a message of no use is left out by its size: of a kind, or a topic, that is not known here. A known
        one of a wrong size is damage."""
        kind = chr(self._data[place + 2])
        is_unknown = kind not in _LEAST_BYTES or (
            kind == "D" and self._data[place + 3] | self._data[place + 4] << 8 not in self._names)
        return (is_unknown or self._is_plausible(place)) and self._is_followed(place, end)

    def _is_followed(self, place: int, end: int) -> bool:
        """Whether right messages follow, and none begin inside: a damaged size reaches over them."""
        return end - place > 3 and self._is_chain(end) and self._next_place(place + 1, end) == end

    def _is_plausible(self, place: int) -> bool:
        end = self._end_of(place)
        if end is None:
            return False
        kind, size = chr(self._data[place + 2]), end - place - 3
        least = _LEAST_BYTES.get(kind)
        if least is None or size < least or (kind in _EXACT_KINDS and size != least):
            return False
        if kind == "S":
            return self._data[place + 3:end] == _SYNC
        if kind == "B":
            return place == _HEADER_BYTES
        if kind == "D":
            number = self._data[place + 3] | self._data[place + 4] << 8
            if number not in self._names:
                return False
            layout = self._layouts.get(self._names[number][1])
            return layout is None or layout.struct.size <= size - 2 <= layout.most_bytes
        return True

    def _is_sure(self, place: int, end: int) -> bool:
        """Whether contents of a plausible message show that its size is right, whatever follows."""
        kind, body = chr(self._data[place + 2]), self._data[place + 3:end]
        if kind == "D":
            return self._names[body[0] | body[1] << 8][1] in self._layouts
        if kind == "F":
            return b":" in body and body.endswith(b";")
        if kind in "IMPQ":
            pair = body[1:] if kind in "MQ" else body
            declared = pair[1:1 + pair[0]].decode("utf-8", "replace").partition(" ")[0]
            base, _, length = declared.partition("[")
            count = int(length[:-1]) if length[:-1].isdigit() else 1
            return base in _CODES and len(pair) == 1 + pair[0] + count * struct.calcsize("<" + _CODES[base])
        if kind == "A":
            return len(body) < 256 and body[3:].replace(b"_", b"").isalnum()
        if kind in "LC":
            return all(byte >= 0x20 or byte in b"\t\n\r\x1b\0" for byte in body[11 if kind == "C" else 9:])
        return True

    def _is_chain(self, place: int) -> bool:
        """Whether some sure messages follow one another here, or the log ends behind them, or a sync message is among
        them. Between them may be messages of topics that are lost, and of kinds that are not known."""
        sure = 0
        for _ in range(_MOST_IN_CHAIN):
            if place == len(self._data):
                return True
            end = self._end_of(place)
            if end is None:
                return False
            if self._is_plausible(place):
                sure += self._is_sure(place, end)
            elif chr(self._data[place + 2]) in _LEAST_BYTES:
                return False
            if sure == _CHAIN or self._data[place + 2] == ord("S"):
                return True
            place = end
        return False

    def _begins(self, place: int) -> bool:
        end = self._end_of(place)
        return end is not None and self._is_plausible(place) and self._is_sure(place, end) and self._is_chain(place)

    def _next_place(self, place: int, end: int) -> int:
        """Where right messages begin again, or the end."""
        while place < end:
            kind = _KINDS.search(self._data, place + 2, end + 2)
            if kind is None:
                return end
            place = kind.start() - 2
            if place < end and self._begins(place):
                return place
            place += 1
        return end

    def _on_message(self, kind: str, body: bytes) -> bool:
        """Takes a message. Returns whether it is of use."""
        if kind == "F":
            return self._on_format(body)
        if kind in "IMP":
            return self._on_pair(kind, body)
        if kind == "A":
            return self._on_subscription(body)
        if kind == "D":
            return self._on_data(body)
        if kind == "L":
            level, stamp = struct.unpack_from("<BQ", body)
            self._now_s = stamp * 1e-6
            words = "emergency alert critical error warning notice info debug".split()
            at = level - ord("0")
            self.texts.append((self._now_s, words[at] if 0 <= at < len(words) else str(level),
                               body[9:].decode("utf-8", "replace")))
        return True

    def _on_format(self, body: bytes) -> bool:
        name, colon, fields = body.decode("utf-8", "replace").partition(":")
        self._formats[name] = fields
        return bool(colon)

    def _on_pair(self, kind: str, body: bytes) -> bool:
        pair = _key_value(body[1:] if kind == "M" else body)
        if pair is None:
            return False
        key, value = pair
        if kind == "P":
            if self._in_data:
                self.changed.append((self._now_s, key, value))
            else:
                self.parameters[key] = value
        else:
            self.info[key] = self.info.get(key, []) + [value] if kind == "M" else value
        return True

    def _on_subscription(self, body: bytes) -> bool:
        self._in_data = True
        instance, number = struct.unpack_from("<BH", body)
        form = body[3:].decode("utf-8", "replace")
        name = form if instance == 0 else f"{form}.{instance}"
        self._names[number] = (name, form)
        try:
            self._layouts[form] = self._layouts.get(form) or _Format(self._formats, form)
        except (KeyError, ValueError, struct.error):  # its definition, or one of a type in it, is lost
            if name not in self.lost:
                self.lost.append(name)
            return False
        self._rows.setdefault(name, [])
        self._of_format[name] = form
        return True

    def _on_data(self, body: bytes) -> bool:
        (number,) = struct.unpack_from("<H", body)
        name, form = self._names[number]
        layout = self._layouts.get(form)
        if layout is None:
            return False
        row = layout.struct.unpack_from(body, 2)
        stamp = row[layout.stamp_column]
        is_leap = stamp > self._leaps.newest + _GAP_US
        if not self._leaps.takes(name, stamp):
            self._waiting.append((name, stamp, row))
            return True
        if is_leap:
            self._decide_waiting(True)
        self._now_s = stamp * 1e-6
        self._rows[name].append(row)
        return True

    def _decide_waiting(self, is_leap: bool) -> None:
        """Takes the rows that made the leap before it was believed; leaves out those that stood alone."""
        for name, stamp, row in self._waiting:
            if is_leap and abs(stamp - self._leaps.began) <= 2 * _GAP_US:
                self._rows[name].append(row)
            else:
                self.wrong_stamps += 1
        self._waiting = []

    def _table(self, name: str, rows: list[tuple[Any, ...]]) -> Table:
        names = self._layouts[self._of_format[name]].columns
        columns = dict(zip(names, zip(*rows))) if rows else {key: () for key in names}
        times = [stamp * 1e-6 for stamp in columns.get("timestamp", ())]
        return Table({"time_s": times, **{key: values for key, values in columns.items()
                                          if key != "timestamp" and "_padding" not in key}})


def _key_value(body: bytes) -> Optional[tuple[str, Any]]:
    """A fact or a parameter; None: it is none."""
    length = body[0]
    kind, blank, key = body[1:1 + length].decode("utf-8", "replace").partition(" ")
    raw = body[1 + length:]
    if not blank or not key or len(body) < 1 + length:
        return None
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
