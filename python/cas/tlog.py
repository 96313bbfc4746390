# SPDX-License-Identifier: BSD-3-Clause
"""Telemetry logs (.tlog): for each packet the time as 8 bytes, big-endian, microseconds since 1970, then the packet."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Iterator, Optional, Union

from .errors import FormatError
from .log_bytes import read_log
from .mavlink import (SIGNATURE_BYTES, SIGNED_FLAG, START_V1, START_V2, Definition, Dialect, Message,
                      common, crc16)
from .table import Table

_STAMP_BYTES = 8
_JITTER_US = 1_000_000
_GAP_US = 10_000_000
_PAUSE_MS = 86_400_000
#: Checksums that may be wrong, and further ones for each packet: it bounds the time that foreign bytes cost.
_MOST_WRONG = 1_000_000
_WRONG_PER_PACKET = 4


class _Record:
    """What may be a record at a place of a log, by its packet's header."""

    def __init__(self, data: bytes, place: int) -> None:
        self.begin = place
        packet = place + _STAMP_BYTES
        self.is_v2 = data[packet] == START_V2
        self.payload = packet + (10 if self.is_v2 else 6)
        self.payload_end = self.payload + data[packet + 1]
        self.signed = self.is_v2 and bool(data[packet + 2] & SIGNED_FLAG)
        self.end = self.payload_end + 2 + (SIGNATURE_BYTES if self.signed else 0)

    def number(self, data: bytes) -> int:
        packet = self.begin + _STAMP_BYTES
        return int.from_bytes(data[packet + 7:packet + 10], "little") if self.is_v2 else data[packet + 5]


def _record_at(data: bytes, place: int) -> Optional[_Record]:
    """The record at this place, whole; None: no packet follows the stamp."""
    start = place + _STAMP_BYTES
    if start + 3 > len(data) or data[start] not in (START_V1, START_V2):
        return None
    record = _Record(data, place)
    return record if record.end <= len(data) else None


def _fits(crc: int, received: int) -> bool:
    """Whether some CRC_EXTRA would make the checksum right: of 256 arbitrary ones about 255 have none."""
    wanted = received ^ crc >> 8  # an entry of the checksum's table: e << 8 ^ e << 3 ^ e >> 4 of a byte e
    byte = wanted >> 8 ^ wanted >> 13
    return (byte << 8 ^ byte << 3 ^ byte >> 4) & 0xFFFF == wanted


class _Clock:
    """The time of a log's records, though the recorder's clock may have been set meanwhile; the same as TlogClock of
    the C++ readers: at a step time stands still until the sender's own clock (time_boot_ms) tells how much has passed."""

    def __init__(self) -> None:
        self.previous: Optional[int] = None
        self.from_us = self.base_us = self.now_us = self.steps = 0
        self.advances = False
        self.heard: dict[tuple[int, int], tuple[Message, int, int]] = {}
        self.is_timed: dict[int, bool] = {}

    def at(self, stamp: int, message: Message) -> int:
        step = 0 if self.previous is None else stamp - self.previous
        is_step = step > _GAP_US or step < -_JITTER_US
        if self.previous is None or is_step:
            self.from_us, self.base_us = stamp, self.now_us
            self.steps += is_step
        elif step:
            self.advances = True
        self.previous = stamp
        self.now_us = max(self.now_us, self.base_us + stamp - self.from_us)
        if message.id not in self.is_timed:
            self.is_timed[message.id] = any(field.name == "time_boot_ms" for field in message.definition.fields)
        if self.is_timed[message.id]:
            self._follow(message)
        return self.now_us

    def _follow(self, message: Message) -> None:
        sender = (message.system, message.component)
        known = self.heard.get(sender)
        if known is not None and (known[2] != self.steps or not self.advances):
            passed_ms = message.time_boot_ms - known[0].time_boot_ms
            late_us = known[1] + 1000 * passed_ms - self.now_us
            if passed_ms <= _PAUSE_MS and late_us > 0:
                self.base_us += late_us
                self.now_us += late_us
        self.heard[sender] = (message, self.now_us, self.steps)


class Tlog:
    """A telemetry log, read into memory; messages are decoded when their fields are asked for.

    Stamps are microseconds since 1970 by the clock of who recorded; `begin_s` is that of the first packet, in seconds.
    A packet whose checksum is wrong is none, and costs no other one. A log of over 512 MiB is refused, and one with a
    million bytes that look like packets and are none.
    """

    def __init__(self, path: Union[str, Path], dialect: Optional[Dialect] = None) -> None:
        self.path = Path(path)
        self.dialect = dialect or common()
        self._data = read_log(self.path)
        self._wrong_left = _MOST_WRONG
        #: Packets of messages that the dialect does not have.
        self.unknown = 0
        #: Bytes that are no intact packet with its stamp: damage. 0: the log is whole.
        self.damaged = 0
        #: (time in us, message), in the order of the file.
        self.packets: list[tuple[int, Message]] = list(self._read())
        if self._data and not self.packets and not self.unknown:
            raise FormatError(f"{self.path} is no .tlog file")
        self._data = b""  # packets have their own bytes
        self.begin_s = self.packets[0][0] * 1e-6 if self.packets else 0.0

    def _read(self) -> Iterator[tuple[int, Message]]:
        data, place = self._data, 0
        in_step = True  # the last record ends here
        while place < len(data):
            record = _record_at(data, place)
            definition = None if record is None else self.dialect.by_id.get(record.number(data))
            is_sound = record is not None and self._is_sound(record, definition)
            if record is None or not self._is_record(record, is_sound, definition is not None, in_step):
                in_step = False
                following = self._next_start(place + 1, len(data))
                self.damaged += following - place
                place = following
                continue
            in_step = True
            place = record.end
            self._wrong_left += _WRONG_PER_PACKET
            if not is_sound:
                self.damaged += record.end - record.begin
            elif definition is None:
                self.unknown += 1
            else:
                yield int.from_bytes(data[record.begin:record.begin + 8], "big"), self._message(record, definition)

    def _next_start(self, place: int, end: int) -> int:
        """From this place on the next one before the end behind whose stamp a packet may begin, or the end."""
        begin, last, width = place + _STAMP_BYTES, end + _STAMP_BYTES, 256
        while begin < last:
            until = min(begin + width, last)
            first = self._data.find(START_V1, begin, until)
            second = self._data.find(START_V2, begin, until if first < 0 else first)
            if first >= 0 or second >= 0:
                return (first if second < 0 else second) - _STAMP_BYTES
            begin, width = until, 2 * width
        return end

    def _message(self, record: _Record, definition: Definition) -> Message:
        header = self._data[record.begin + _STAMP_BYTES:record.payload]
        sequence, system, component = header[4:7] if record.is_v2 else header[2:5]
        return Message(definition, system, component, sequence, self._data[record.payload:record.payload_end],
                       record.signed)

    def _is_sound(self, record: _Record, definition: Optional[Definition]) -> bool:
        """Whether the checksum is right; of an unknown message, whether it may be."""
        data, end = self._data, record.payload_end
        received = data[end] | data[end + 1] << 8
        crc = crc16(data[record.begin + _STAMP_BYTES + 1:end])
        if definition is None:
            is_sound = _fits(crc, received)
        else:
            is_sound = crc16(bytes([definition.crc_extra]), crc) == received
        if not is_sound:
            self._wrong_left -= 1
            if self._wrong_left < 0:
                raise FormatError(f"{self.path} has too many bytes that look like packets and are none; it is not read")
        return is_sound

    def _is_record(self, record: _Record, is_sound: bool, is_known: bool, in_step: bool) -> bool:
        """Whether this is a record, be it damaged. Behind another one also a damaged one that ends where the next one
        begins, or the log does; behind other bytes only the checksum tells."""
        if is_sound:
            return in_step or is_known or self._has_none_inside(record)
        is_followed = record.end == len(self._data) or _record_at(self._data, record.end) is not None
        return in_step and is_followed and self._has_none_inside(record)

    def _has_none_inside(self, record: _Record) -> bool:
        """A stamp that holds a start byte, or a wrong length, reaches over intact records."""
        place = record.begin
        while (place := self._next_start(place + 1, record.end)) < record.end:
            inside = _record_at(self._data, place)
            if inside is not None and self._is_sound(inside, self.dialect.by_id.get(inside.number(self._data))):
                return False
        return True

    def __iter__(self) -> Iterator[tuple[float, Message]]:
        """(time since the first packet in s, message); a step of the recorder's clock is taken out of the time."""
        clock = _Clock()
        return ((clock.at(stamp, message) * 1e-6, message) for stamp, message in self.packets)

    def counts(self) -> dict[str, int]:
        """How often each message is in the log."""
        counts: dict[str, int] = {}
        for _, message in self.packets:
            counts[message.name] = counts.get(message.name, 0) + 1
        return counts

    def table(self, name: str, system: Optional[int] = None, component: Optional[int] = None) -> Table:
        """One message as columns: `time_s` since the first packet, then its fields; of an array NAME[0], NAME[1],
        ... Of one sender, where it is named."""
        definition = self.dialect.message(name)
        columns: dict[str, list[Any]] = {"time_s": []}
        for field in definition.fields:
            is_array = field.length and field.code != "c"
            for index in range(field.length if is_array else 1):
                columns[f"{field.name}[{index}]" if is_array else field.name] = []
        for time_s, message in self:
            if message.name != name or system not in (None, message.system):
                continue
            if component not in (None, message.component):
                continue
            columns["time_s"].append(time_s)
            for key, value in message.fields.items():
                if isinstance(value, list):
                    for index, element in enumerate(value):
                        columns[f"{key}[{index}]"].append(element)
                else:
                    columns[key].append(value)
        return Table(columns)


def read_tlog(path: Union[str, Path]) -> Tlog:
    """Reads a .tlog file."""
    return Tlog(path)


def echo_delays(log: Tlog) -> Table:
    """How long the controller took, as casd saw it: `time_s` since the first packet, `delay_us` from a HIL_SENSOR
    to the first controls that carry its `time_usec`. Empty where the log has no such pairs."""
    sent: dict[int, int] = {}
    times, delays = [], []
    for stamp, message in log.packets:
        if message.name == "HIL_SENSOR":
            sent.setdefault(message.time_usec, stamp)
        elif message.name in ("HIL_CONTROLS", "HIL_ACTUATOR_CONTROLS") and message.time_usec in sent:
            times.append(stamp * 1e-6 - log.begin_s)
            delays.append(float(stamp - sent.pop(message.time_usec)))
    return Table({"time_s": times, "delay_us": delays})


#: Stamp of simulated time zero in logs that are made in lockstep and on the virtual clock, us: 2026-01-01.
STREAM_EPOCH_US = 1_767_225_600_000_000
_DAY_US = 86_400_000_000


def control_delays(log: Tlog) -> Table:
    """How old the sample was, that a control was computed from, when the control came to casd: `time_s` since the first
    packet, `delay_us`. Controls carry the stamp of their sample by the simulator's clock. In lockstep and on the virtual
    clock the log has the same one; in real time it is set by the least delayed HIL_SENSOR of the log, and where there
    is none the delays are those beyond the least delayed control."""
    controls = [(stamp, message.time_usec) for stamp, message in log.packets
                if message.name in ("HIL_CONTROLS", "HIL_ACTUATOR_CONTROLS")]
    sensors = [(stamp, message.time_usec) for stamp, message in log.packets if message.name == "HIL_SENSOR"]
    on_stream = bool(log.packets) and 0 <= log.packets[0][0] - STREAM_EPOCH_US < _DAY_US
    offset = STREAM_EPOCH_US if on_stream else min((stamp - time for stamp, time in sensors or controls), default=0)
    return Table({"time_s": [stamp * 1e-6 - log.begin_s for stamp, _ in controls],
                  "delay_us": [float(stamp - time - offset) for stamp, time in controls]})
