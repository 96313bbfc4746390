# SPDX-License-Identifier: BSD-3-Clause
"""Telemetry logs (.tlog): for each packet the time as 8 bytes, big-endian, microseconds since 1970, then the packet."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Iterator, Optional, Union

from .errors import FormatError
from .mavlink import SIGNATURE_BYTES, SIGNED_FLAG, START_V1, START_V2, Dialect, Message, common
from .table import Table


class Tlog:
    """A telemetry log, read into memory; messages are decoded when their fields are asked for.

    Times are seconds since 1970 by the clock of who recorded; `begin_s` is that of the first packet.
    """

    def __init__(self, path: Union[str, Path], dialect: Optional[Dialect] = None) -> None:
        self.path = Path(path)
        self.dialect = dialect or common()
        self._data = self.path.read_bytes()
        #: Packets of which no dialect is known, or that are no packets.
        self.unknown = 0
        #: (time in us, message), in the order of the file.
        self.packets: list[tuple[int, Message]] = list(self._read())
        self.begin_s = self.packets[0][0] * 1e-6 if self.packets else 0.0

    def _read(self) -> Iterator[tuple[int, Message]]:
        data, place = self._data, 0
        while place + 8 + 6 <= len(data):
            stamp = int.from_bytes(data[place:place + 8], "big")
            begin = place + 8
            is_v2 = data[begin] == START_V2
            if not is_v2 and data[begin] != START_V1:
                if place == 0:
                    raise FormatError(f"{self.path} is no .tlog file")
                place += 1  # a damaged place: the next stamp is looked for
                continue
            head = 10 if is_v2 else 6
            payload_end = begin + head + data[begin + 1]
            signed = is_v2 and bool(data[begin + 2] & SIGNED_FLAG)
            end = payload_end + 2 + (SIGNATURE_BYTES if signed else 0)
            if end > len(data):
                return  # cut off
            if is_v2:
                sequence, system, component = data[begin + 4:begin + 7]
                number = data[begin + 7] | data[begin + 8] << 8 | data[begin + 9] << 16
            else:
                sequence, system, component, number = data[begin + 2:begin + 6]
            definition = self.dialect.by_id.get(number)
            if definition is None:
                self.unknown += 1
            else:
                yield stamp, Message(definition, system, component, sequence, data[begin + head:payload_end], signed)
            place = end

    def __iter__(self) -> Iterator[tuple[float, Message]]:
        """(time since the first packet in s, message)."""
        first = self.packets[0][0] if self.packets else 0
        return (((stamp - first) * 1e-6, message) for stamp, message in self.packets)

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
