# SPDX-License-Identifier: BSD-3-Clause
"""Tables, logs and folders of runs, from files that are made here."""

import json
import os
import random
import struct
import time
import unittest
from unittest import mock

from helpers import FolderTest

import cas
from cas import mavlink, tlog, ulog

#: A reader that looks at each byte takes ten times as long.
READ_S = 5.0


class TableTest(FolderTest):
    def test_a_csv_file_becomes_columns(self):
        (self.folder / "t.csv").write_text("\ufefftime_s,x_m,name\n0,1,a\n1,3,b\n2,5")  # cut off in the last line
        table = cas.read("t.csv")
        self.assertEqual((table.rows, list(table)), (2, ["time_s", "x_m", "name"]))
        self.assertEqual(list(table["x_m"]), [1, 3])
        self.assertEqual(table["name"], ["a", "b"])
        self.assertEqual(table.row(1), {"time_s": 1, "x_m": 3, "name": "b"})
        with self.assertRaisesRegex(KeyError, "no column y_m; there are time_s, x_m, name"):
            table["y_m"]

    def test_values_between_rows_are_linear(self):
        table = cas.Table({"time_s": [0, 1, 2], "x_m": [0, 10, 0]})
        self.assertEqual([table.at("x_m", t) for t in (-1, 0.25, 1, 1.5, 9)], [0, 2.5, 10, 5, 0])
        self.assertEqual(list(table.between(0.5, 2)["x_m"]), [10, 0])

    def test_quantiles_and_rms(self):
        self.assertEqual(cas.rms([3, -4, 0, 0]), 2.5)
        values = list(range(1, 101))
        self.assertEqual([cas.quantile(values, share) for share in (0, 0.5, 0.99, 1)], [1, 50, 99, 100])
        self.assertEqual(cas.text_table(("a", "bb"), [(1, 2.0)]), "a  bb\n1   2")

    def test_columns_of_two_lengths_are_refused(self):
        with self.assertRaises(ValueError):
            cas.Table({"a": [1], "b": []})


class TlogTest(FolderTest):
    def record(self, *packets):
        (self.folder / "f.tlog").write_bytes(b"".join(t.to_bytes(8, "big") + packet for t, packet in packets))
        return cas.read("f.tlog")

    def test_messages_become_tables_by_sender(self):
        encode = mavlink.common().encode
        log = self.record((1_000_000, encode("ATTITUDE", system=1, component=1, roll=0.5)),
                          (1_500_000, encode("ATTITUDE", system=2, component=1, roll=-0.5)),
                          (2_000_000, encode("HIL_ACTUATOR_CONTROLS", system=1, component=1, controls=[1, 2])))
        self.assertEqual(log.counts(), {"ATTITUDE": 2, "HIL_ACTUATOR_CONTROLS": 1})
        table = log.table("ATTITUDE", system=2)
        self.assertEqual((list(table["time_s"]), list(table["roll"])), ([0.5], [-0.5]))
        self.assertEqual(list(log.table("HIL_ACTUATOR_CONTROLS")["controls[1]"]), [2])

    def test_delays_are_from_a_sensor_to_its_echo(self):
        encode = mavlink.common().encode
        log = self.record((1_000_000, encode("HIL_SENSOR", system=1, component=200, time_usec=4000)),
                          (1_001_500, encode("HIL_CONTROLS", system=1, component=1, time_usec=4000)),
                          (1_002_000, encode("HIL_CONTROLS", system=1, component=1, time_usec=77)))
        self.assertEqual(list(cas.echo_delays(log)["delay_us"]), [1500])

    def test_a_log_that_was_cut_off_is_read_to_there(self):
        packet = mavlink.common().encode("ATTITUDE", system=1, component=1)
        log = self.record((1, packet), (2, packet[:-3]))
        self.assertEqual(log.counts(), {"ATTITUDE": 1})

    def damaged(self, start_us, change):
        """The numbers of the packets of a log of 60 records, of which `change` bends number 30."""
        encode = mavlink.common().encode
        records = [(start_us + 20_000 * i).to_bytes(8, "big")
                   + encode("ATTITUDE", system=1, component=1, sequence=i, time_boot_ms=i, roll=0.25) for i in range(60)]
        records[30] = change(records[30])
        (self.folder / "f.tlog").write_bytes(b"".join(records))
        log = cas.read("f.tlog")
        for stamp, message in log.packets:
            self.assertEqual((stamp, message.roll), (start_us + 20_000 * message.time_boot_ms, 0.25))
        return [message.time_boot_ms for _, message in log.packets], log.damaged

    def test_a_damaged_record_costs_no_other_one_and_no_wrong_number(self):
        others = [i for i in range(60) if i != 30]
        # Stamps of 2026-09-21 hold 0xFE, a start byte of a packet.
        for start_us in (1_794_000_000_000_000, 1_790_000_000_000_000):
            self.assertEqual(self.damaged(start_us, lambda record: record), (list(range(60)), 0))
            zeros = self.damaged(start_us, lambda record: bytes(4096) + record)
            self.assertEqual(zeros, (list(range(60)), 4096))
            for at in (8, 9, 10, 15, 20, 25):
                for bit in (1, 0x40):
                    bent, lost = self.damaged(start_us, lambda record: record[:at] + bytes([record[at] ^ bit])
                                              + record[at + 1:])
                    self.assertEqual((bent, lost), (others, 28), (start_us, at, bit))
            for size in (3, 11, 25):
                self.assertEqual(self.damaged(start_us, lambda record: record[:size]), (others, size))

    def test_a_clock_that_was_set_costs_no_time(self):
        encode = mavlink.common().encode
        now, hour = 1_794_000_000_000_000, 3_600_000_000
        for stamp in (lambda i: now, lambda i: now - (hour if i >= 20 else 0), lambda i: now if i >= 20 else 86_400,
                      lambda i: now + (hour if i == 30 else 0)):
            log = self.record(*((stamp(i) + 100_000 * i, encode("ATTITUDE", system=1, component=1, time_boot_ms=100 * i))
                                for i in range(60)))
            times = log.table("ATTITUDE")["time_s"]
            for i, time_s in enumerate(times):
                self.assertAlmostEqual(time_s, 0.1 * i, 3)

    def test_foreign_bytes_are_jumped_over(self):
        packet = mavlink.common().encode("ATTITUDE", system=1, component=1)
        record = (1_794_000_000_000_000).to_bytes(8, "big") + packet
        for foreign in (bytes(200 << 20), random.Random(1).randbytes(3 << 20)):
            (self.folder / "f.tlog").write_bytes(record + foreign + record)
            begin = time.process_time()
            log = cas.read("f.tlog")
            self.assertLess(time.process_time() - begin, READ_S)
            self.assertEqual([at for at, _ in log.packets if at == 1_794_000_000_000_000], 2 * [1_794_000_000_000_000])

    def test_too_many_bytes_that_look_like_packets_are_refused(self):
        packet = mavlink.common().encode("ATTITUDE", system=1, component=1)
        with mock.patch.object(tlog, "_MOST_WRONG", 1000):
            self.assertEqual(self.record((1, packet), (2, 900 * b"\xfe"), (3, packet)).counts(), {"ATTITUDE": 2})
            for foreign in (2000 * b"\xfe", 2000 * b"\xfd"):
                with self.assertRaisesRegex(cas.FormatError, "too many bytes that look like packets"):
                    self.record((1, packet), (2, foreign + bytes(300)))

    def test_what_does_not_fit_into_memory_is_refused(self):
        for name in ("f.tlog", "f.ulg"):
            (self.folder / name).touch()
            os.truncate(self.folder / name, (512 << 20) + 1)
            with self.assertRaisesRegex(cas.FormatError, "over 512 MiB"):
                cas.read(name)

    def test_what_is_no_regular_file_is_refused_at_once(self):
        os.mkfifo(self.folder / "f.tlog")
        os.symlink("/dev/zero", self.folder / "g.tlog")
        for name in ("f.tlog", "g.tlog"):
            with self.assertRaisesRegex(cas.FormatError, "no regular file"):
                tlog.Tlog(self.folder / name)
        os.mkfifo(self.folder / "f.csv")
        with self.assertRaisesRegex(cas.FormatError, "no regular file"):
            cas.table.read_csv(self.folder / "f.csv")

    def test_something_else_is_refused(self):
        (self.folder / "f.tlog").write_bytes(b"this is no log at all")
        with self.assertRaisesRegex(cas.FormatError, "no .tlog file"):
            cas.read("f.tlog")


class UlogTest(FolderTest):
    def message(self, kind, body):
        return struct.pack("<HB", len(body), ord(kind)) + body

    def test_topics_parameters_and_texts_are_read(self):
        key = b"float MC_ROLL_P"
        data = b"ULog\x01\x12\x35\x01" + bytes(8)
        data += self.message("F", b"pair:uint8_t one;uint8_t two;")
        data += self.message("F", b"attitude:uint64_t timestamp;float[2] q;pair p;uint8_t[3] _padding0;")
        data += self.message("I", bytes([12]) + b"char[3] name" + b"cas")
        data += self.message("P", bytes([len(key)]) + key + struct.pack("<f", 6.5))
        data += self.message("A", struct.pack("<BH", 0, 5) + b"attitude")
        data += self.message("A", struct.pack("<BH", 1, 6) + b"attitude")
        data += self.message("D", struct.pack("<HQ2fBB", 5, 2_000_000, 0.5, 0.25, 7, 8))  # without its padding
        data += self.message("P", bytes([len(key)]) + key + struct.pack("<f", 7.5))
        data += self.message("L", b"6" + struct.pack("<Q", 3_000_000) + b"Landed")
        (self.folder / "f.ulg").write_bytes(data + b"\x10")
        log = cas.read("f.ulg")
        self.assertEqual(log.info, {"name": "cas"})
        self.assertEqual(log.parameters, {"MC_ROLL_P": 6.5})
        self.assertEqual(log.changed, [(2.0, "MC_ROLL_P", 7.5)])
        self.assertEqual(log.texts, [(3.0, "info", "Landed")])
        self.assertEqual(log.topics["attitude"].row(0),
                         {"time_s": 2.0, "q[0]": 0.5, "q[1]": 0.25, "p.one": 7, "p.two": 8})
        self.assertEqual(log.topics["attitude.1"].rows, 0)

    def test_something_else_is_refused(self):
        (self.folder / "f.ulg").write_bytes(b"no log")
        with self.assertRaisesRegex(cas.FormatError, "no ULog file"):
            cas.read("f.ulg")


class DamagedUlogTest(FolderTest):
    """A log of 500 messages of each of two topics, with texts and messages of a later logger between them."""

    def message(self, kind, body):
        return struct.pack("<HB", len(body), ord(kind)) + body

    def setUp(self):
        super().setUp()
        self.start = b"ULog\x01\x12\x35\x01" + struct.pack("<Q", 1_000_000) + self.message("B", bytes(40))
        self.definitions = [self.message("F", b"alpha:uint64_t timestamp;float x;"),
                            self.message("F", b"beta:uint64_t timestamp;float[3] y;uint8_t z;uint8_t[3] _padding0;")]
        self.topics = [self.message("A", struct.pack("<BH", 0, 1) + b"alpha"),
                       self.message("A", struct.pack("<BH", 0, 2) + b"beta")]
        self.messages = []
        for i in range(500):
            self.messages.append(self.message("D", struct.pack("<HQf", 1, 1_000_000 + 4000 * i, i / 2)))
            self.messages.append(self.message("D", struct.pack("<HQfffB", 2, 1_000_002 + 4000 * i, i, i, i, 3)))
            if i % 50 == 9:
                self.messages.append(self.message("L", b"6" + struct.pack("<Q", 1_000_000 + 4000 * i) + b"hello there"))
                self.messages.append(self.message("#", b"of a later logger"))

    def read(self, definitions=None, messages=None):
        parts = [self.start, *(definitions or self.definitions), *self.topics, *(messages or self.messages)]
        (self.folder / "f.ulg").write_bytes(b"".join(parts))
        log = cas.read("f.ulg")
        return {name: table.rows for name, table in log.topics.items()}, log

    def test_a_whole_log_has_no_damage(self):
        rows, log = self.read()
        self.assertEqual((rows, len(log.texts), log.damaged, log.lost), ({"alpha": 500, "beta": 500}, 10, 0, []))

    def test_a_wrong_byte_costs_the_messages_that_it_hits(self):
        for at in (0, 1, 2, 3):  # size, kind, topic
            for bit in (1, 2, 4, 0x10, 0x40, 0x80):
                bent = list(self.messages)
                bent[501] = bent[501][:at] + bytes([bent[501][at] ^ bit]) + bent[501][at + 1:]
                rows, log = self.read(messages=bent)
                self.assertGreaterEqual(sum(rows.values()), 998, (at, bit))
                self.assertLessEqual(log.damaged, 60, (at, bit))

    def test_what_lies_behind_garbage_is_read_without_sync_messages(self):
        for garbage in (bytes(3000), b"\xff" * 77, b"D\x00A\x10L" * 40):
            rows, log = self.read(messages=self.messages[:500] + [garbage] + self.messages[500:])
            self.assertEqual((rows, log.damaged), ({"alpha": 500, "beta": 500}, len(garbage)))

    def test_foreign_bytes_are_jumped_over(self):
        sync = self.message("S", b"\x2f\x73\x13\x20\x25\x0c\xbb\x12")
        for foreign, lost in ((bytes(100 << 20), 100 << 20), (random.Random(1).randbytes(3 << 20), None),
                              (1_000_000 * sync, 0), (1_000 * (30 * self.message("Z", b"1") + sync), 0)):
            begin = time.process_time()
            rows, log = self.read(messages=[*self.messages[:500], foreign, *self.messages[500:]])
            self.assertLess(time.process_time() - begin, READ_S)
            self.assertEqual(rows, {"alpha": 500, "beta": 500})
            self.assertIn(lost, (log.damaged, None))  # of random bytes a few look like messages of a later logger

    def test_too_many_places_that_look_like_messages_are_refused(self):
        with mock.patch.object(ulog, "_MOST_WRONG", 10_000):
            for foreign in (60_000 * b"F", 20_000 * b"I\x08uint8_t "):
                with self.assertRaisesRegex(cas.FormatError, "too many places that look like a message"):
                    self.read(messages=[foreign])

    def test_a_definition_that_unfolds_without_end_costs_its_topic(self):
        formats = [self.message("F", b"c:uint8_t x;"),
                   self.message("F", b"b:" + b"".join(b"c f%d;" % i for i in range(5000))),
                   self.message("F", b"a:" + b"".join(b"b f%d;" % i for i in range(5000))),
                   self.message("F", b"wide:uint64_t timestamp;a x;"), self.message("F", b"odd:char timestamp;float x;")]
        topics = [self.message("A", struct.pack("<BH", 0, 7) + b"wide"), self.message("A", struct.pack("<BH", 0, 8) + b"odd")]
        rows, log = self.read(definitions=self.definitions + formats,
                              messages=[*topics, self.message("D", struct.pack("<HQ", 7, 1)), *self.messages])
        self.assertEqual((rows, log.lost), ({"alpha": 500, "beta": 500}, ["wide", "odd"]))

    def test_short_and_odd_messages_cost_nothing_else(self):
        odd = [self.message("D", b""), self.message("D", b"\0"), self.message("D", b"\1\0"),
               self.message("P", b"\x0dfloat[\xc2\xb2] abc"), self.message("I", b"\x09char[1] xa"),
               self.message("M", b"\0\x09char[1] xb"), self.message("M", b"\1\x09char[1] xc")]
        rows, log = self.read(messages=odd + self.messages)
        self.assertEqual((rows, log.info), ({"alpha": 500, "beta": 500}, {"x": ["b", "c"]}))

    def test_a_wrong_time_is_outvoted_and_a_gap_is_kept(self):
        hour = 3_600_000_000
        wrong = [self.message("D", struct.pack("<HQf", 1, hour + 4000 * i, 0)) for i in range(20)]
        rows, log = self.read(messages=self.messages[:500] + wrong[:1] + self.messages[500:])
        self.assertEqual((rows, log.wrong_stamps, log.damaged), ({"alpha": 500, "beta": 500}, 1, 0))
        self.assertLess(max(log.topics["alpha"]["time_s"]), 4)
        later = [self.message("D", struct.pack("<HQf", 1, hour + 4000 * i, 0))
                 + self.message("D", struct.pack("<HQfffB", 2, hour + 4000 * i, i, i, i, 3)) for i in range(20)]
        rows, log = self.read(messages=self.messages + later)
        self.assertEqual((rows, log.wrong_stamps), ({"alpha": 520, "beta": 520}, 0))
        rows, log = self.read(messages=[self.messages[0].replace(struct.pack("<Q", 1_000_000), struct.pack("<Q", hour))])
        self.assertEqual((rows, log.wrong_stamps), ({"alpha": 1, "beta": 0}, 0))

    def test_a_lost_definition_costs_its_topic_alone(self):
        for definitions in (self.definitions[:1], [self.definitions[0], self.message("F", b"beta:uint64_t timestamp;none n;")],
                            [self.definitions[0], self.message("F", b"beta:beta b;uint64_t timestamp;")]):
            rows, log = self.read(definitions)
            self.assertEqual((rows, log.lost), ({"alpha": 500}, ["beta"]))
            self.assertGreater(log.damaged, 500 * 26)


class RunTest(FolderTest):
    def test_a_folder_of_several_vehicles_is_read_by_name(self):
        vehicles = [{"name": "left", "passed": True}, {"name": "right", "passed": False}]
        (self.folder / "summary.json").write_text(json.dumps({"schema": 2, "passed": False, "valid": True,
                                                              "vehicles": vehicles}))
        for name in ("left", "right"):
            (self.folder / f"truth_{name}.csv").write_text(f"time_s,x_m\n0,{len(name)}\n")
        run = cas.read(self.folder)
        self.assertEqual((run.passed, run.valid, run.vehicles), (False, True, ["left", "right"]))
        self.assertEqual(list(run.truth["x_m"]), [4])
        self.assertEqual(list(run.truth_of("right")["x_m"]), [5])
        self.assertFalse(run.vehicle("right")["passed"])
        self.assertEqual(run.vehicle(), run.vehicle("left"))
        with self.assertRaisesRegex(KeyError, "no vehicle middle; it has left, right"):
            run.vehicle("middle")

    def test_the_files_of_one_vehicle_bear_no_name(self):
        (self.folder / "summary.json").write_text(json.dumps({"schema": 2, "vehicles": [{"name": "iris0"}]}))
        (self.folder / "truth.csv").write_text("time_s,x_m\n0,7\n")
        run = cas.read(self.folder)
        self.assertEqual((run.vehicles, list(run.truth["x_m"])), (["iris0"], [7]))

    def test_a_summary_of_another_schema_is_refused_by_name(self):
        (self.folder / "summary.json").write_text(json.dumps({"schema": 1, "passed": True}))
        with self.assertRaisesRegex(cas.FormatError, "summary.json has schema 1, and this package reads 2"):
            _ = cas.read(self.folder).passed

    def test_what_is_no_run_says_what_makes_one(self):
        with self.assertRaisesRegex(cas.FormatError, "`hils run SCENARIO --out"):
            cas.read(self.folder)
        with self.assertRaisesRegex(cas.FormatError, "there is no"):
            cas.read(self.folder / "nothing")
        (self.folder / "x.txt").write_text("")
        with self.assertRaisesRegex(cas.FormatError, "nothing that cas reads"):
            cas.read("x.txt")


if __name__ == "__main__":
    unittest.main()
