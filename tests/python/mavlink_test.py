# SPDX-License-Identifier: BSD-3-Clause
"""The codec against facts of MAVLink and against itself."""

import math
import unittest

from helpers import FolderTest

import cas
from cas import mavlink

# Of the public dialects: pymavlink and the firmware have these, too.
CRC_EXTRAS = {"HEARTBEAT": 50, "SYS_STATUS": 124, "ATTITUDE": 39, "LOCAL_POSITION_NED": 185, "HIL_SENSOR": 108,
              "HIL_GPS": 124, "HIL_CONTROLS": 63, "HIL_ACTUATOR_CONTROLS": 47, "COMMAND_LONG": 152, "PARAM_SET": 168,
              "STATUSTEXT": 83, "MISSION_ITEM_INT": 38}


class DialectTest(unittest.TestCase):
    def test_checksums_of_definitions_are_those_of_the_public_dialects(self):
        for name, extra in CRC_EXTRAS.items():
            self.assertEqual(mavlink.common().message(name).crc_extra, extra, name)

    def test_enumerations_have_their_values(self):
        enums = mavlink.common().enums
        self.assertEqual(enums["MAV_TYPE_QUADROTOR"], 2)
        self.assertEqual(enums["MAV_CMD_COMPONENT_ARM_DISARM"], 400)
        self.assertEqual(enums["MAV_MODE_FLAG_SAFETY_ARMED"], 128)

    def test_the_golden_packet_of_a_heartbeat(self):
        packet = mavlink.common().encode("HEARTBEAT", system=1, component=1, sequence=0, type=2, autopilot=12,
                                         base_mode=81, custom_mode=0, system_status=4, mavlink_version=3)
        self.assertEqual(packet[:10], bytes([0xFD, 9, 0, 0, 0, 1, 1, 0, 0, 0]))
        self.assertEqual(packet[10:19], bytes([0, 0, 0, 0, 2, 12, 81, 4, 3]))
        self.assertEqual(mavlink.crc16(bytes([50]), mavlink.crc16(packet[1:19])),
                         int.from_bytes(packet[19:], "little"))

    def test_the_checksum_is_the_one_of_the_catalogue(self):
        self.assertEqual(mavlink.crc16(b"123456789"), 0x6F91)  # CRC-16/MCRF4XX

    def test_unknown_fields_and_messages_are_refused(self):
        with self.assertRaisesRegex(ValueError, "ATTITUDE has no field rol; it has"):
            mavlink.common().encode("ATTITUDE", system=1, component=1, rol=1.0)
        with self.assertRaisesRegex(KeyError, "no message ATTITUD"):
            mavlink.common().encode("ATTITUD", system=1, component=1)


class ParserTest(unittest.TestCase):
    def setUp(self):
        self.dialect = mavlink.common()

    def test_what_is_packed_is_read_back(self):
        fields = {"time_usec": 123456789, "controls": [i / 16 for i in range(16)], "mode": 160, "flags": 2 ** 40}
        packet = self.dialect.encode("HIL_ACTUATOR_CONTROLS", system=3, component=4, sequence=9, **fields)
        (message,) = mavlink.Parser().feed(packet)
        self.assertEqual((message.name, message.system, message.component, message.sequence),
                         ("HIL_ACTUATOR_CONTROLS", 3, 4, 9))
        self.assertEqual({key: message.fields[key] for key in fields}, fields)
        self.assertEqual(message.mode, 160)
        with self.assertRaises(AttributeError):
            message.nothing

    def test_texts_end_at_their_zero(self):
        packet = self.dialect.encode("STATUSTEXT", system=1, component=1, severity=6, text="Landed")
        (message,) = mavlink.Parser().feed(packet)
        self.assertEqual(message.text, "Landed")

    def test_every_message_survives_the_wire(self):
        for definition in self.dialect.by_id.values():
            packet = self.dialect.encode_fields(definition.name, {}, 1, 1)
            (message,) = mavlink.Parser().feed(packet)
            self.assertEqual(message.name, definition.name)
            for field in definition.fields:
                value = message.fields[field.name]
                self.assertTrue(value in (0, "") or not any(value), definition.name)

    def test_packets_are_found_in_pieces_and_behind_noise(self):
        packet = self.dialect.encode("ATTITUDE", system=1, component=1, roll=0.5)
        parser = mavlink.Parser()
        got = []
        for byte in b"noise" + packet + packet:
            got += parser.feed(bytes([byte]))
        self.assertEqual([message.roll for message in got], [0.5, 0.5])
        self.assertEqual(parser.skipped_bytes, 5)

    def test_a_damaged_packet_is_counted_and_left(self):
        packet = bytearray(self.dialect.encode("ATTITUDE", system=1, component=1, roll=0.5))
        packet[12] ^= 1
        parser = mavlink.Parser()
        good = self.dialect.encode("ATTITUDE", system=1, component=1, yaw=1.5)
        self.assertEqual([message.yaw for message in parser.feed(bytes(packet) + good * 3)][-1], 1.5)
        self.assertGreaterEqual(parser.crc_errors, 1)

    def test_mavlink_1_is_read(self):
        definition = self.dialect.message("HEARTBEAT")
        payload = definition.pack({"type": 2})[:definition.size_v1]
        head = bytes([0xFE, len(payload), 5, 1, 1, 0])
        crc = mavlink.crc16(bytes([definition.crc_extra]), mavlink.crc16(head[1:] + payload))
        (message,) = mavlink.Parser().feed(head + payload + crc.to_bytes(2, "little"))
        self.assertEqual((message.type, message.sequence), (2, 5))

    def test_not_a_number_goes_over_the_wire(self):
        packet = self.dialect.encode("COMMAND_LONG", system=1, component=1, command=400, param4=math.nan)
        (message,) = mavlink.Parser().feed(packet)
        self.assertTrue(math.isnan(message.param4))


class UdpLinkTest(unittest.TestCase):
    def test_two_ends_hear_each_other(self):
        with mavlink.UdpLink("127.0.0.1:9", system=1, component=1) as one:
            address = "127.0.0.1:%d" % one._socket.getsockname()[1]
            with mavlink.UdpLink(address, system=255, component=190) as other:
                other.send("HEARTBEAT", type=6)
                message = one.receive(20.0)
        self.assertEqual((message.type, message.system, message.component), (6, 255, 190))

    def test_a_closed_link_ends_its_loop(self):
        link = mavlink.UdpLink("127.0.0.1:9", system=1, component=1)
        link.close()
        self.assertEqual(list(link), [])


class OwnDialectTest(FolderTest):
    def test_an_include_is_read_and_what_is_no_dialect_refused(self):
        (self.folder / "base.xml").write_text(
            "<mavlink><messages><message id='1000' name='A'><field type='uint8_t' name='x'>x</field></message>"
            "</messages></mavlink>")
        (self.folder / "own.xml").write_text(
            "<mavlink><include>base.xml</include><messages><message id='70000' name='B'>"
            "<field type='float[3]' name='y' units='m'>y</field></message></messages></mavlink>")
        dialect = mavlink.Dialect(self.folder / "own.xml")
        packet = dialect.encode("B", system=1, component=1, y=[1, 2, 3])
        (message,) = mavlink.Parser(dialect).feed(packet)
        self.assertEqual(message.y, [1, 2, 3])
        self.assertIn("A", dialect.by_name)
        (self.folder / "bad.xml").write_text("no xml")
        with self.assertRaises(cas.FormatError):
            mavlink.Dialect(self.folder / "bad.xml")


if __name__ == "__main__":
    unittest.main()
