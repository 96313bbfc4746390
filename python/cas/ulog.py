# SPDX-License-Identifier: BSD-3-Clause
"""ULog, the log format of PX4 (docs.px4.io, ULog File Format): topics as tables."""

from __future__ import annotations

import array
import itertools
import re
import struct
from pathlib import Path
from typing import Any, Optional, Union

from .errors import FormatError
from .log_bytes import read_log
from .table import Table
from .ulog_time import GAP_US, UlogTime

MAGIC = b"ULog\x01\x12\x35"
_SYNC = b"\x2f\x73\x13\x20\x25\x0c\xbb\x12"
_CODES = {"int8_t": "b", "uint8_t": "B", "int16_t": "h", "uint16_t": "H", "int32_t": "i", "uint32_t": "I",
          "int64_t": "q", "uint64_t": "Q", "float": "f", "double": "d", "bool": "?", "char": "c"}


#: Kinds of messages, and the least bytes of each; some have exactly these.
_LEAST_BYTES = {"S": 8, "O": 2, "R": 2, "D": 10, "A": 4, "L": 10, "C": 12, "I": 4, "M": 5, "P": 4, "Q": 5, "F": 3, "B": 40}
_EXACT_KINDS = "SOR"
_TEXT = re.compile(rb"[\t\n\r\x1b\0\x20-\xff]*")
_TYPE = rb"(?:u?int(?:8|16|32|64)_t|float|double|bool|char)"
#: Kind and first bytes of what may be a message; the search skips other bytes by the kind alone.
_BEGINS = re.compile(b"S" + re.escape(_SYNC) + rb"|O(?<=\x02\0O)|R(?<=\x02\0R)|D|A(?<=\0A)[\s\S]{3}\w|F"
                     rb"|L[\s\S]{9}[\t\n\r\x1b\0\x20-\xff]|C[\s\S]{11}[\t\n\r\x1b\0\x20-\xff]"
                     rb"|I[\s\S]" + _TYPE + rb"|P[\s\S]" + _TYPE + rb"|M[\s\S]{2}" + _TYPE + rb"|Q[\s\S]{2}" + _TYPE)
_MOST_BEGIN = 16
_SYNC_MESSAGE = b"\x08\0S" + _SYNC
_MANY_SYNCS = 4096 * _SYNC_MESSAGE
#: Places that may look like a message and be none, and further ones for each message: it bounds the time that foreign
#: bytes cost.
_MOST_WRONG = 1_000_000
_WRONG_PER_MESSAGE = 4
_BLANKS = (bytes(65536), 65536 * b"\xff")  # of files and of cards
_ROWS_AT_ONCE = 256
#: Messages in a row, of right kinds and sizes, that are believed behind damage.
_CHAIN = 3
_MOST_IN_CHAIN = 32
_HEADER_BYTES = 16
_MOST_DEPTH = 16
_MOST_BYTES = 65535


class _Format:
    """Columns and packing of one message, once it is defined."""

    def __init__(self) -> None:
        self.columns: list[str] = []
        #: What the definition has cost.
        self.steps = 0

    def define(self, formats: dict[str, str], name: str) -> "_Format":
        """KeyError, ValueError: the log does not define it, or nonsense."""
        code = self._expand(formats, name, "", 0)
        #: Bytes with the padding at its end, which may be missing in a message.
        self.most_bytes = struct.calcsize("<" + code)
        while self.columns and "_padding" in self.columns[-1]:
            self.columns.pop()
            code = code[:-1]
        self.code = code
        self.struct = struct.Struct("<" + code)
        stamp = self.columns.index("timestamp")
        if code[stamp] != "Q":
            raise ValueError(f"type {name} has no timestamp")
        self.stamp_place = struct.calcsize("<" + code[:stamp])
        return self

    def _expand(self, formats: dict[str, str], name: str, prefix: str, depth: int) -> str:
        if depth > _MOST_DEPTH:
            raise ValueError(f"type {name} is nested too deep")
        codes = []
        self.steps += len(formats[name]) // 16
        for entry in filter(None, formats[name].split(";")):
            kind, _, field = entry.partition(" ")
            kind, _, length = kind.partition("[")
            count = int(length.rstrip("]")) if length else 0
            if not field or not 0 <= count <= _MOST_BYTES:
                raise ValueError(f"type {name} has {entry}, which is no field")
            for index in range(count or 1):
                path = prefix + field + (f"[{index}]" if count else "")
                self.steps += 1 + len(path) // 64
                if self.steps > _MOST_BYTES:
                    raise ValueError(f"type {name} has too many fields")
                if kind in _CODES:
                    self.columns.append(path)
                    codes.append(_CODES[kind])
                else:
                    codes.append(self._expand(formats, kind, path + ".", depth + 1))
        return "".join(codes)


class Ulog:
    """A ULog file, read into memory.

    `topics["vehicle_attitude"]` is a Table with `time_s` and the fields in PX4's units, of an array `q[0]`, ...;
    a further instance of a topic is `NAME.1`. `info` and `parameters` are the facts and the first values;
    `changed` lists (time_s, name, value) of parameters that changed; `texts` (time_s, level, text). Bytes that are no
    message are left out and counted in `damaged`; a definition that was lost costs its topic (`lost`) alone. A log of over
    512 MiB is refused, and one with a million places that look like a message and are none.
    """

    def __init__(self, path: Union[str, Path]) -> None:
        self.path = Path(path)
        self.info: dict[str, Any] = {}
        self.parameters: dict[str, Any] = {}
        self.changed: list[tuple[float, str, Any]] = []
        self.texts: list[tuple[float, str, str]] = []
        data = read_log(self.path)
        if data[:7] != MAGIC:
            raise FormatError(f"{path} is no ULog file")
        #: Bytes that are left out: damage, messages of lost topics, a message that the log ends within. 0: it is whole.
        self.damaged = 0
        #: Messages that are left out because their time is wrong by that of most topics.
        self.wrong_stamps = 0
        #: Topics whose definition is lost.
        self.lost: list[str] = []
        self._lost_names: set[str] = set()
        self._data = data
        self._formats: dict[str, str] = {}
        self._layouts: dict[str, _Format] = {}
        self._names: dict[int, tuple[str, str]] = {}
        self._rows: dict[str, list[bytes]] = {}
        self._of_format: dict[str, str] = {}
        self._now_s = 0.0
        self._in_data = False
        self._leaps = UlogTime(int.from_bytes(data[8:16], "little"))
        self._waiting: list[tuple[str, int, bytes]] = []
        self._wrong_left = _MOST_WRONG
        #: Places from which right messages follow, as the last search for them has shown.
        self._chained: set[int] = set()
        self._read()
        self._decide_waiting(not self._leaps.heard)
        self._data = b""
        self.topics = {name: self._table(name, self._rows.pop(name)) for name in list(self._rows)}

    def _read(self) -> None:
        data, place = self._data, _HEADER_BYTES
        while place < len(data):
            if data.startswith(_SYNC_MESSAGE, place):
                place += len(_MANY_SYNCS if data.startswith(_MANY_SYNCS, place) else _SYNC_MESSAGE)
                continue
            end = self._end_of(place)
            if end is not None and self._is_message(place, end) and self._on_message(chr(data[place + 2]),
                                                                                     data[place + 3:end]):
                self._wrong_left += _WRONG_PER_MESSAGE
                place = end
                continue
            is_skipped = end is not None and self._is_skipped(place, end)
            following = end if end is not None and is_skipped else self._next_place(place + 1, len(data))
            if not is_skipped or chr(data[place + 2]) in _LEAST_BYTES:  # else it is of a later logger
                self.damaged += following - place
            place = following

    def _spend(self, cost: int) -> None:
        self._wrong_left -= cost
        if self._wrong_left < 0:
            raise FormatError(f"{self.path} has too many places that look like a message and are none; it is not read")

    def _end_of(self, place: int) -> Optional[int]:
        """Where the message at this place ends; None: behind the log."""
        if place + 3 > len(self._data):
            return None
        end: int = place + 3 + self._data[place] + (self._data[place + 1] << 8)
        return end if end <= len(self._data) else None

    def _number_at(self, place: int) -> int:
        """Number of the topic of a data message of at least two bytes."""
        return self._data[place + 3] | self._data[place + 4] << 8

    def _is_message(self, place: int, end: int) -> bool:
        """Whether kind and size are right: by the message's contents, or because others follow and none begin inside."""
        return self._is_plausible(place, end) and (self._is_sure(place, end) or self._is_followed(place, end))

    def _is_skipped(self, place: int, end: int) -> bool:
        """Whether a message of no use is left out by its size: of a kind, or a topic, that is not known here. A known
        one of a wrong size is damage."""
        kind = chr(self._data[place + 2])
        is_unknown = kind not in _LEAST_BYTES or (
            kind == "D" and end >= place + 5 and self._number_at(place) not in self._names)
        return (is_unknown or self._is_plausible(place, end)) and self._is_followed(place, end)

    def _is_followed(self, place: int, end: int) -> bool:
        """Whether right messages follow, and none begin inside: a damaged size reaches over them."""
        return end - place > 3 and self._is_chain(end) and self._next_place(place + 1, end) == end

    def _is_plausible(self, place: int, end: int) -> bool:
        kind, size = chr(self._data[place + 2]), end - place - 3
        least = _LEAST_BYTES.get(kind)
        if least is None or size < least or (kind in _EXACT_KINDS and size != least):
            return False
        if kind == "S":
            return self._data.startswith(_SYNC, place + 3)
        if kind == "B":
            return place == _HEADER_BYTES
        if kind == "D":
            known = self._names.get(self._number_at(place))
            if known is None:
                return False
            layout = self._layouts.get(known[1])
            return layout is None or layout.struct.size <= size - 2 <= layout.most_bytes
        return True

    def _is_sure(self, place: int, end: int) -> bool:
        """Whether contents of a plausible message show that its size is right, whatever follows."""
        data, kind, first = self._data, chr(self._data[place + 2]), place + 3
        if kind == "D":
            return self._names[self._number_at(place)][1] in self._layouts
        if kind == "F":
            return data[end - 1] == ord(";") and data.find(b":", first, end) >= 0
        if kind in "IMPQ":
            pair = first + (kind in "MQ")
            declared = data[pair + 1:pair + 1 + data[pair]].decode("utf-8", "replace").partition(" ")[0]
            base, _, length = declared.partition("[")
            count = int(length[:-1]) if length[:-1].isdecimal() else 1
            return base in _CODES and end - pair == 1 + data[pair] + count * struct.calcsize("<" + _CODES[base])
        if kind == "A":
            return end - first < 256 and data[first + 3:end].replace(b"_", b"").isalnum()
        if kind in "LC":
            return _TEXT.fullmatch(data, first + (11 if kind == "C" else 9), end) is not None
        return True

    def _is_chain(self, place: int) -> bool:
        """Whether some sure messages follow one another here, or the log ends behind them, or a sync message is among
        them. Between them may be messages of topics that are lost, and of kinds that are not known."""
        data, sure, known = self._data, 0, 0
        path: list[int] = []
        while len(path) < _MOST_IN_CHAIN:
            if place == len(data) or place in self._chained:
                if path:
                    self._chained = {place, *path}
                return True
            end = self._end_of(place)
            if end is None:
                break
            path.append(place)
            if sure == 0:
                known = len(path)  # from these places, too, all sure ones follow
            if self._is_plausible(place, end):
                sure += self._is_sure(place, end)
            elif chr(data[place + 2]) in _LEAST_BYTES:
                break
            if sure == _CHAIN or data[place + 2] == ord("S"):
                self._chained = set(path if sure < _CHAIN else path[:known])
                return True
            place = end
        self._spend(len(path))
        return False

    def _begins(self, place: int) -> bool:
        end = self._end_of(place)
        return (end is not None and self._is_plausible(place, end) and self._is_sure(place, end)
                and self._is_chain(place))

    def _next_place(self, place: int, end: int) -> int:
        """Where right messages begin again, or the end."""
        while place < end:
            while any(self._data.startswith(blank, place + 2) for blank in _BLANKS):
                place += len(_BLANKS[0])
            begin = _BEGINS.search(self._data, place + 2, end + 2 + _MOST_BEGIN)
            if begin is None or begin.start() - 2 >= end:
                return end
            place = begin.start() - 2
            if self._begins(place):
                return place
            self._spend(1)
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
            self._keep_fact(key, value, kind == "M")
        return True

    def _keep_fact(self, key: str, value: Any, is_part: bool) -> None:
        if not is_part:
            self.info[key] = value
            return
        parts = self.info.get(key)
        if not isinstance(parts, list):
            parts = self.info[key] = []
        parts.append(value)

    def _on_subscription(self, body: bytes) -> bool:
        self._in_data = True
        instance, number = struct.unpack_from("<BH", body)
        form = body[3:].decode("utf-8", "replace")
        name = form if instance == 0 else f"{form}.{instance}"
        self._names[number] = (name, form)
        if form not in self._layouts:
            layout = _Format()
            try:
                self._layouts[form] = layout.define(self._formats, form)
            except (KeyError, ValueError, struct.error):  # its definition, or one of a type in it, is lost
                self._spend(layout.steps)
                if name not in self._lost_names:
                    self._lost_names.add(name)
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
        row = body[2:2 + layout.struct.size]
        stamp = int.from_bytes(row[layout.stamp_place:layout.stamp_place + 8], "little")
        is_leap = stamp > self._leaps.newest + GAP_US
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
            if is_leap and abs(stamp - self._leaps.began) <= 2 * GAP_US:
                self._rows[name].append(row)
            else:
                self.wrong_stamps += 1
        self._waiting = []

    def _table(self, name: str, rows: list[bytes]) -> Table:
        """Some rows at a time: as numbers of Python they take five times their size."""
        layout = self._layouts[self._of_format[name]]
        columns: list[Any] = [[] if code == "c" else array.array("d") for code in layout.code]
        unpacked = layout.struct.iter_unpack(b"".join(rows))
        while block := list(itertools.islice(unpacked, _ROWS_AT_ONCE)):
            for column, values in zip(columns, zip(*block)):
                column.extend(values)
        stamps = columns[layout.columns.index("timestamp")]
        return Table({"time_s": array.array("d", (stamp * 1e-6 for stamp in stamps)),
                      **{key: values for key, values in zip(layout.columns, columns)
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
