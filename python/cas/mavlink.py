# SPDX-License-Identifier: BSD-3-Clause
"""A small MAVLink codec: reads a dialect's XML while it runs, packs and unpacks its messages.

    dialect = cas.mavlink.common()
    packet = dialect.encode("HEARTBEAT", system=1, component=1, sequence=0, type=2, autopilot=12)
    for message in cas.mavlink.Parser(dialect).feed(packet):
        print(message.name, message.autopilot)

Values are those of the wire, in the units of the dialect (mavlink.io/en/messages/common.html). Not
here: checking and making of signatures; a signed packet is read, its signature kept in `signed`.
"""

from __future__ import annotations

import binascii
import functools
import socket
import struct
import xml.etree.ElementTree as ElementTree
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator, Optional, Union

from .errors import FormatError
from .rpc import host_and_port

START_V1 = 0xFE
START_V2 = 0xFD
SIGNED_FLAG = 0x01
SIGNATURE_BYTES = 13
MOST_PAYLOAD = 255

_TYPES = {"uint8_t": ("B", 1), "int8_t": ("b", 1), "char": ("c", 1), "uint16_t": ("H", 2), "int16_t": ("h", 2),
          "uint32_t": ("I", 4), "int32_t": ("i", 4), "float": ("f", 4), "uint64_t": ("Q", 8), "int64_t": ("q", 8),
          "double": ("d", 8), "uint8_t_mavlink_version": ("B", 1)}


#: Each byte with its bits in the opposite order.
_MIRRORED = bytes(int(f"{byte:08b}"[::-1], 2) for byte in range(256))


def _mirrored16(value: int) -> int:
    return _MIRRORED[value & 0xFF] << 8 | _MIRRORED[value >> 8]


def crc16(data: bytes, crc: int = 0xFFFF) -> int:
    """CRC-16/MCRF4XX, the checksum of MAVLink: the mirror image of the one that the library has in C."""
    return _mirrored16(binascii.crc_hqx(bytes(data).translate(_MIRRORED), _mirrored16(crc)))


@dataclass(frozen=True)
class Field:
    """One field of a message."""

    name: str
    type: str
    code: str
    size: int
    #: Elements of an array, 0 for a single value.
    length: int
    units: str
    extension: bool


class Definition:
    """One message of a dialect."""

    def __init__(self, number: int, name: str, fields: list[Field]) -> None:
        self.id = number
        self.name = name
        self.fields = fields
        own = [field for field in fields if not field.extension]
        #: In the order of the wire: large types first, extensions behind.
        self.wire = sorted(own, key=lambda field: -field.size) + [field for field in fields if field.extension]
        self.crc_extra = self._crc_extra()
        self._struct = struct.Struct("<" + "".join(self._code(field) for field in self.wire))
        self.size = self._struct.size
        self.size_v1 = struct.calcsize("<" + "".join(self._code(f) for f in self.wire if not f.extension))

    @staticmethod
    def _code(field: Field) -> str:
        if field.code == "c":
            return f"{max(field.length, 1)}s"
        return f"{field.length}{field.code}" if field.length else field.code

    def _crc_extra(self) -> int:
        crc = crc16(f"{self.name} ".encode())
        for field in self.wire:
            if field.extension:
                continue
            word = "uint8_t" if field.type == "uint8_t_mavlink_version" else field.type
            crc = crc16(f"{word} {field.name} ".encode(), crc)
            if field.length:
                crc = crc16(bytes([field.length]), crc)
        return (crc & 0xFF) ^ (crc >> 8)

    def pack(self, values: dict[str, Any]) -> bytes:
        """The payload, of full length; fields that are left out are 0."""
        flat: list[Any] = []
        for field in self.wire:
            value = values.pop(field.name, None)
            if field.code == "c":
                flat.append(b"" if value is None else value.encode() if isinstance(value, str) else value)
            elif field.length:
                numbers = list(value or [])
                if len(numbers) > field.length:
                    raise ValueError(f"{self.name}.{field.name} takes {field.length} values, not {len(numbers)}")
                flat += numbers + [0] * (field.length - len(numbers))
            else:
                flat.append(0 if value is None else value)
        if values:
            known = ", ".join(field.name for field in self.fields)
            raise ValueError(f"{self.name} has no field {', '.join(values)}; it has {known}")
        return self._struct.pack(*flat)

    def unpack(self, payload: bytes) -> dict[str, Any]:
        """The fields of a payload, whose zeros at the end may have been cut."""
        flat = self._struct.unpack(payload[:self.size].ljust(self.size, b"\0"))
        values: dict[str, Any] = {}
        place = 0
        for field in self.wire:
            if field.code == "c":
                values[field.name] = flat[place].split(b"\0", 1)[0].decode("utf-8", "replace")
                place += 1
            elif field.length:
                values[field.name] = list(flat[place:place + field.length])
                place += field.length
            else:
                values[field.name] = flat[place]
                place += 1
        return values


class Message:
    """A decoded packet: `name`, `id`, `system`, `component`, `sequence`, its fields as attributes and in
    `fields`."""

    def __init__(self, definition: Definition, system: int, component: int, sequence: int, payload: bytes,
                 signed: bool) -> None:
        self.definition = definition
        self.name = definition.name
        self.id = definition.id
        self.system = system
        self.component = component
        self.sequence = sequence
        self.payload = payload
        self.signed = signed

    @functools.cached_property
    def fields(self) -> dict[str, Any]:
        """Values by the names of the dialect, in wire order."""
        return self.definition.unpack(self.payload)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        try:
            return self.fields[name]
        except KeyError:
            raise AttributeError(f"{self.definition.name} has no field {name}") from None

    def __repr__(self) -> str:
        values = ", ".join(f"{key}={value!r}" for key, value in self.fields.items())
        return f"{self.name}({values})"


class Dialect:
    """The messages and enumerations of a MAVLink XML and of all that it includes."""

    def __init__(self, path: Union[str, Path]) -> None:
        self.by_id: dict[int, Definition] = {}
        self.by_name: dict[str, Definition] = {}
        #: Values of all enumerations: enums["MAV_TYPE_QUADROTOR"] is 2.
        self.enums: dict[str, int] = {}
        self._load(Path(path), set())

    def _load(self, path: Path, seen: set[Path]) -> None:
        if path in seen:
            return
        seen.add(path)
        try:
            root = ElementTree.parse(path).getroot()
        except (OSError, ElementTree.ParseError) as error:
            raise FormatError(f"{path} is no MAVLink dialect: {error}") from None
        for include in root.findall("include"):
            self._load(path.parent / (include.text or "").strip(), seen)
        for enum in root.iterfind("enums/enum"):
            highest = -1
            for entry in enum.findall("entry"):
                text = entry.get("value")
                value = highest + 1 if text is None else _number(text)
                highest = max(highest, value)
                self.enums[entry.get("name", "")] = value
        for message in root.iterfind("messages/message"):
            self._add(message)

    def _add(self, node: ElementTree.Element) -> None:
        fields: list[Field] = []
        extension = False
        for child in node:
            if child.tag == "extensions":
                extension = True
            elif child.tag == "field":
                word, _, rest = child.get("type", "").partition("[")
                code, size = _TYPES[word]
                fields.append(Field(child.get("name", ""), word, code, size, int(rest.rstrip("]") or 0),
                                    child.get("units", ""), extension))
        definition = Definition(int(node.get("id", "0")), node.get("name", ""), fields)
        self.by_id[definition.id] = definition
        self.by_name[definition.name] = definition

    def message(self, name: Union[str, int]) -> Definition:
        """A message by its name or id. Raises KeyError with a sentence."""
        found = self.by_id.get(name) if isinstance(name, int) else self.by_name.get(name)
        if found is None:
            raise KeyError(f"the dialect has no message {name}")
        return found

    def encode(self, name: Union[str, int], /, *, system: int, component: int, sequence: int = 0,
               **fields: Any) -> bytes:
        """A MAVLink 2 packet. Fields that are left out are 0; one whose name is `system`, `component` or
        `sequence` goes in `fields` of encode_fields()."""
        return self.encode_fields(name, fields, system, component, sequence)

    def encode_fields(self, name: Union[str, int], fields: dict[str, Any], system: int, component: int,
                      sequence: int = 0) -> bytes:
        """As encode(), with the fields in a dict."""
        definition = self.message(name)
        payload = definition.pack(dict(fields)).rstrip(b"\0") or b"\0"
        head = struct.pack("<BBBBBBBHB", START_V2, len(payload), 0, 0, sequence & 0xFF, system, component,
                           definition.id & 0xFFFF, definition.id >> 16)
        crc = crc16(bytes([definition.crc_extra]), crc16(head[1:] + payload))
        return head + payload + struct.pack("<H", crc)


def _number(text: str) -> int:
    base, power, exponent = text.partition("**")
    return int(text, 0) if not power else int(pow(int(base), int(exponent)))


@functools.lru_cache(maxsize=None)
def common() -> Dialect:
    """The dialect `common` as CAS has it."""
    return Dialect(Path(__file__).resolve().parent / "dialects" / "common.xml")


class Parser:
    """Finds packets in a stream of bytes. Bytes that are no packet, fail their checksum or have no definition are skipped
    and counted."""

    def __init__(self, dialect: Optional[Dialect] = None) -> None:
        self.dialect = dialect or common()
        self.crc_errors = 0
        self.unknown = 0
        self.skipped_bytes = 0
        self._buffer = bytearray()

    def feed(self, data: bytes) -> Iterator[Message]:
        """The messages that `data` completes."""
        self._buffer += data
        while True:
            message, used = self._next()
            if not used:
                return
            del self._buffer[:used]
            if message is not None:
                yield message

    def _next(self) -> tuple[Optional[Message], int]:
        """A message, and the bytes that are through; 0: more must come."""
        buffer = self._buffer
        if not buffer:
            return None, 0
        if buffer[0] not in (START_V1, START_V2):
            self.skipped_bytes += 1
            return None, 1
        is_v2 = buffer[0] == START_V2
        head_bytes = 10 if is_v2 else 6
        if len(buffer) < head_bytes:
            return None, 0
        signed = is_v2 and bool(buffer[2] & SIGNED_FLAG)
        end = head_bytes + buffer[1]
        whole = end + 2 + (SIGNATURE_BYTES if signed else 0)
        if len(buffer) < whole:
            return None, 0
        if is_v2:
            sequence, system, component = buffer[4], buffer[5], buffer[6]
            number = buffer[7] | buffer[8] << 8 | buffer[9] << 16
        else:
            sequence, system, component, number = buffer[2], buffer[3], buffer[4], buffer[5]
        definition = self.dialect.by_id.get(number)
        if definition is None:
            self.unknown += 1
            return None, whole
        crc = crc16(bytes([definition.crc_extra]), crc16(bytes(buffer[1:end])))
        if crc != buffer[end] | buffer[end + 1] << 8:
            self.crc_errors += 1
            return None, 1
        payload = bytes(buffer[head_bytes:end])
        return Message(definition, system, component, sequence, payload, signed), whole


class UdpLink:
    """Sends and receives messages over UDP in the name of one system and component.

    `remote` is HOST:PORT; `local` the port to bind, any free one when it is left out.
    """

    def __init__(self, remote: str, *, system: int, component: int, local: str = "127.0.0.1:0",
                 dialect: Optional[Dialect] = None) -> None:
        self.dialect = dialect or common()
        self.system = system
        self.component = component
        self._remote = host_and_port(remote)
        self._parser = Parser(self.dialect)
        self._sequence = 0
        self._waiting: list[Message] = []
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._socket.bind(host_and_port(local))
        self._closed = False

    def send(self, name: str, /, **fields: Any) -> None:
        """Sends one message; fields that are left out are 0."""
        packet = self.dialect.encode_fields(name, fields, self.system, self.component, self._sequence)
        self._sequence = (self._sequence + 1) & 0xFF
        self._socket.sendto(packet, self._remote)

    def receive(self, timeout_s: Optional[float] = None) -> Optional[Message]:
        """The next message; None after `timeout_s`, or once the link is closed."""
        while not self._waiting and not self._closed:
            self._socket.settimeout(timeout_s)
            try:
                data = self._socket.recv(65536)
            except (TimeoutError, BlockingIOError):
                return None
            except OSError:
                if self._closed:
                    return None
                raise
            self._waiting += self._parser.feed(data)
        return self._waiting.pop(0) if self._waiting else None

    def __iter__(self) -> Iterator[Message]:
        while (message := self.receive(0.2)) is not None or not self._closed:
            if message is not None:
                yield message

    def close(self) -> None:
        """Ends the link: a loop over it ends within 0.2 s."""
        self._closed = True
        self._socket.close()

    def __enter__(self) -> "UdpLink":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()
