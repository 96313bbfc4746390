// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/tx_port.hpp"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>

#include "casd/link/blocking_tx_port.hpp"
#include "casd/link/direct_tx_port.hpp"
#include "casd/signing/link_signing.hpp"
#include "casd/signing/packet_signer.hpp"
#include "tests/casd/packets.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::casd::test {
namespace {

/// Records the packets written to a line, and sets its behaviour.
struct FakeLine {
  std::vector<std::uint32_t> written;  ///< message ids
  std::size_t room = 1'000'000;        ///< bytes that it takes
  std::size_t unsent = 0;              ///< as the driver reports
  std::size_t bytes = 0;
  std::vector<std::uint8_t> last;  ///< bytes of the last call
  bool moves = true;               ///< the other side reads
  bool counts = false;             ///< its moves, byte by byte
  int nudges = 0;
  int flushes = 0;
  bool can_flush = true;
  base::Duration took{};  ///< a write
  /// Message ids that are finished without being sent, with the causes.
  std::map<std::uint32_t, std::optional<DropCause>> refuses{};
};

class FakeWriter final : public PacketWriter {
 public:
  explicit FakeWriter(FakeLine& line) : line_(line) {}
  WriteResult write(std::span<const PacketRef> packets) override {
    WriteResult result;
    unsent_.clear();
    for (const PacketRef& packet : packets) {
      if (const auto refused = line_.refuses.find(packet.info->message_id);
          refused != line_.refuses.end()) {
        unsent_.push_back({result.packets++, refused->second});
        continue;
      }
      const std::size_t taken = std::min(line_.room, packet.bytes.size());
      line_.room -= taken;
      line_.bytes += taken;
      if (taken > 0) line_.written.push_back(packet.info->message_id);
      if (taken < packet.bytes.size()) {
        result.part_of_next = taken;
        break;
      }
      ++result.packets;
    }
    if (line_.took > base::Duration{}) result.done = at(line_.took);
    result.unsent = unsent_;
    return result;
  }
  WriteResult write_rest(std::span<const std::uint8_t> rest) override {
    const std::size_t taken = std::min(line_.room, rest.size());
    line_.room -= taken;
    line_.bytes += taken;
    line_.last.assign(rest.begin(), rest.begin() + static_cast<std::ptrdiff_t>(taken));
    return {.part_of_next = taken};
  }
  std::size_t unsent() const override { return line_.unsent; }
  bool moved() override { return line_.moves; }
  bool counts_moves() const override { return line_.counts; }
  void nudge() override { ++line_.nudges; }
  bool flush() override {
    ++line_.flushes;
    return line_.can_flush;
  }
  int descriptor() const override { return -1; }

 private:
  FakeLine& line_;
  std::vector<Unsent> unsent_;
};

class TxPortTest : public testing::Test {
 protected:
  void open(const TxPortOptions& options) {
    port = std::make_unique<DirectTxPort>(options, counters, [this] { ++wakes; });
    port->attach(std::make_unique<FakeWriter>(line), at({}));
  }
  /// Packets of the same class, in one batch, read at `now`; their message ids count up.
  void deliver(TrafficClass traffic, int count, base::RunTime now, std::size_t size = 100) {
    std::vector<PacketInfo> infos;
    std::vector<PacketRef> packets;
    const auto content = bytes(size);
    for (int i = 0; i < count; ++i) infos.push_back(info(traffic, now, next_id++));
    for (const PacketInfo& each : infos) packets.push_back({&each, content});
    port->deliver(packets, now);
  }
  std::uint64_t dropped(DropCause cause) const {
    return counters->tx.dropped[static_cast<std::size_t>(cause)].get();
  }

  FakeLine line;
  std::shared_ptr<LinkCounters> counters =
      std::make_shared<LinkCounters>("line", LinkType::kSerial);
  std::unique_ptr<TxPort> port;
  std::uint32_t next_id = 1;
  int wakes = 0;
};

TEST_F(TxPortTest, WritesAtOnceWhileThereIsRoom) {
  open({});
  deliver(TrafficClass::kHil, 3, at({}));
  EXPECT_EQ(line.written, (std::vector<std::uint32_t>{1, 2, 3}));
  EXPECT_EQ(counters->tx.write_calls.get(), 1U);
  EXPECT_EQ(wakes, 0);
}

TEST_F(TxPortTest, WhatTheWriterDidNotSendDoesNotCount) {
  open({});
  line.refuses = {{2, std::nullopt}, {3, DropCause::kClosed}, {5, std::nullopt}};
  deliver(TrafficClass::kHil, 5, at({}));
  EXPECT_EQ(line.written, (std::vector<std::uint32_t>{1, 4}));
  EXPECT_EQ(counters->tx.packets.get(), 2U);
  EXPECT_EQ(counters->tx.bytes.get(), 200U);
  EXPECT_EQ(dropped(DropCause::kClosed), 1U);
}

TEST_F(TxPortTest, WhatCannotBeSignedIsDroppedAndNotSent) {
  const cas::test::TemporaryFolder folder;
  SigningConfig config;
  config.key_file = folder.write("radio.key", "a pass phrase of the laboratory\n");
  std::filesystem::permissions(
      config.key_file, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  open({.signing = std::make_shared<LinkSigning>(
            config, std::make_shared<PacketSigner>(config.key_file), counters)});
  const auto whole = packet(mavlink::common::Heartbeat{}, {1, 1});
  auto damaged = whole;
  while (fitting_crc_extra(view(damaged)) >= 0) ++damaged.bytes[damaged.size - 1];
  const auto deliver_both = [&](bool damaged_first) {
    const PacketInfo first = info(TrafficClass::kCommand, at({}), damaged_first ? 66 : 1);
    const PacketInfo second = info(TrafficClass::kCommand, at({}), damaged_first ? 1 : 66);
    const std::array packets{PacketRef{&first, (damaged_first ? damaged : whole).view()},
                             PacketRef{&second, (damaged_first ? whole : damaged).view()}};
    port->deliver(packets, at({}));
  };
  deliver_both(true);
  deliver_both(false);
  EXPECT_EQ(line.written, (std::vector<std::uint32_t>{1, 1}));
  EXPECT_EQ(counters->tx.packets.get(), 2U);
  EXPECT_EQ(dropped(DropCause::kUnsignable), 2U);

  line.refuses = {{1, DropCause::kClosed}};  // both unsent: one signed, one not
  deliver_both(true);
  deliver_both(false);
  line.refuses.clear();
  EXPECT_EQ(counters->tx.packets.get(), 2U);
  EXPECT_EQ(dropped(DropCause::kUnsignable), 4U);
  EXPECT_EQ(dropped(DropCause::kClosed), 2U);

  line.room = 0;  // they wait together, and are judged together
  deliver_both(false);
  EXPECT_EQ(dropped(DropCause::kUnsignable), 4U);
  line.room = 1'000'000;
  port->carry_on(at({}));
  EXPECT_EQ(counters->tx.packets.get(), 3U);
  EXPECT_EQ(dropped(DropCause::kUnsignable), 5U);
}

TEST_F(TxPortTest, WhatAgedInABatchThatFoundNoRoomIsDropped) {
  open({});
  line.room = 0;
  deliver(TrafficClass::kHil, 1, at({}));  // finds the line full
  deliver(TrafficClass::kHil, 10, at({}));
  line.room = 250;  // takes two and a half: the rest of the batch waits outside the queue
  port->carry_on(at(milliseconds(1)));
  ASSERT_EQ(line.written, (std::vector<std::uint32_t>{1, 2, 3}));
  deliver(TrafficClass::kCommand, 1, at(milliseconds(2)));

  line.room = 1'000'000;
  port->carry_on(at(milliseconds(100)));
  EXPECT_EQ(line.written, (std::vector<std::uint32_t>{1, 2, 3, 12}));
  EXPECT_EQ(line.bytes, 400U);  // the packet that was begun is finished
  EXPECT_EQ(line.last.back(), 0xFF) << "but with a wrong checksum: it is too old as well";
  EXPECT_EQ(dropped(DropCause::kAge), 9U);
  EXPECT_EQ(counters->tx.packets.get(), 3U) << "each packet counts once";
}

TEST_F(TxPortTest, SeesAReaderThatStopsInTheMiddleOfAPacket) {
  open({});
  line.room = 150;
  deliver(TrafficClass::kCommand, 2, at({}));
  line.room = 20;  // it reads a little once more, and then no more
  port->carry_on(at(milliseconds(5)));
  line.moves = false;
  line.room = 0;
  port->carry_on(at(milliseconds(40)));
  EXPECT_EQ(line.flushes, 0);
  port->carry_on(at(milliseconds(1100)));
  EXPECT_EQ(line.flushes, 1);
  EXPECT_EQ(dropped(DropCause::kStalled), 1U);
  EXPECT_EQ(counters->tx.packets.get(), 1U);
}

TEST_F(TxPortTest, FinishesAPacketThatIsStillWorthIt) {
  open({});
  line.room = 150;
  deliver(TrafficClass::kHil, 2, at({}));
  EXPECT_EQ(counters->tx.packets.get(), 1U) << "half a packet is none";
  line.room = 1'000'000;
  port->carry_on(at(milliseconds(5)));
  EXPECT_EQ(line.bytes, 200U);
  EXPECT_EQ(counters->tx.packets.get(), 2U);
  EXPECT_EQ(line.last.back(), 0);
  EXPECT_EQ(dropped(DropCause::kAge), 0U);
}

TEST_F(TxPortTest, GivesNothingToALineThatStandsStill) {
  open({});
  line.moves = false;
  deliver(TrafficClass::kHil, 1, at({}));
  deliver(TrafficClass::kHil, 1, at(milliseconds(25)));
  EXPECT_EQ(line.written.size(), 2U) << "a reader may be busy for so long";
  deliver(TrafficClass::kHil, 1, at(milliseconds(27)));
  deliver(TrafficClass::kCommand, 1, at(milliseconds(28)));
  EXPECT_EQ(line.written.size(), 2U);
  ASSERT_NE(port->due(), PollSet::kNever);
  EXPECT_LE(port->due() - at(milliseconds(28)), milliseconds(2));

  base::RunTime now = port->due();
  for (; now < at(milliseconds(500)); now = port->due()) port->carry_on(now);
  EXPECT_EQ(line.written.size(), 2U);
  EXPECT_GE(line.nudges, 2);
  EXPECT_LE(line.nudges, 5);
  EXPECT_EQ(line.flushes, 0);

  line.moves = true;
  port->carry_on(now);
  EXPECT_EQ(line.written, (std::vector<std::uint32_t>{1, 2, 4})) << "the sensors are too old";
  EXPECT_EQ(dropped(DropCause::kAge), 1U);
  deliver(TrafficClass::kHil, 1, now);
  EXPECT_EQ(line.written.back(), 5U) << "written at once again";
}

TEST_F(TxPortTest, IsPatientWithATerminalThatSpeaksButNotForEver) {
  open({});
  line.moves = false;
  for (int ms = 0; ms < 200; ms += 20) {
    port->heard(at(milliseconds(ms)));
    deliver(TrafficClass::kHil, 1, at(milliseconds(ms)));
  }
  EXPECT_EQ(line.written.size(), 6U) << "100 ms: its receiver hangs";
}

TEST_F(TxPortTest, BelievesADriverThatCountsMoreThanWhatComesIn) {
  open({});
  line.moves = false;
  line.counts = true;
  for (int ms = 0; ms < 200; ms += 20) {
    port->heard(at(milliseconds(ms)));
    deliver(TrafficClass::kHil, 1, at(milliseconds(ms)));
  }
  EXPECT_EQ(line.written.size(), 2U) << "25 ms";
}

TEST_F(TxPortTest, EmptiesTheDriverOfALineThatStandsStillForASecond) {
  open({});
  line.moves = false;
  line.room = 150;
  testing::internal::CaptureStderr();
  deliver(TrafficClass::kHil, 2, at({}));  // ends in the middle of a packet
  base::RunTime now = at(milliseconds(100));
  for (; now < at(std::chrono::seconds(5)); now = port->due()) port->carry_on(now);
  const std::string still = testing::internal::GetCapturedStderr();
  EXPECT_NE(still.find("stands still, gets nothing until it moves"), std::string::npos) << still;
  EXPECT_EQ(still.find("moves again"), std::string::npos) << still;
  EXPECT_EQ(line.flushes, 1);
  EXPECT_GT(line.nudges, 0) << "only at the end of a packet, and the begun one is gone";
  line.moves = true;
  line.room = 1'000'000;
  testing::internal::CaptureStderr();
  deliver(TrafficClass::kHil, 1, now);
  port->carry_on(now);
  const std::string moves = testing::internal::GetCapturedStderr();
  EXPECT_NE(moves.find("moves again"), std::string::npos) << moves;
  EXPECT_EQ(line.written.back(), 3U);
  EXPECT_EQ(line.bytes, 250U);
}

TEST_F(TxPortTest, FinishesABegunPacketWhereTheDriverKeepsWhatItHolds) {
  open({});
  line.moves = false;
  line.can_flush = false;
  line.room = 150;
  deliver(TrafficClass::kHil, 2, at({}));  // ends in the middle of a packet
  base::RunTime now = at(milliseconds(100));
  for (; now < at(std::chrono::seconds(5)); now = port->due()) port->carry_on(now);
  EXPECT_EQ(line.flushes, 1);
  EXPECT_EQ(line.nudges, 0) << "a zero would lie in the packet";
  line.moves = true;
  line.room = 1'000'000;
  port->carry_on(now);
  EXPECT_EQ(line.bytes, 200U);
}

TEST_F(TxPortTest, OfSetpointsThatComeTogetherTheNewestIsSent) {
  open({});
  const auto content = bytes(30);
  const PacketInfo stick = info(TrafficClass::kSetpoint, at({}), 69);
  const PacketInfo sensor = info(TrafficClass::kHil, at({}), 107);
  PacketInfo other_stick = stick;
  other_stick.source = {254, 190};
  const std::array packets{PacketRef{&stick, content}, PacketRef{&sensor, content},
                           PacketRef{&other_stick, content}, PacketRef{&stick, content}};
  port->deliver(packets, at({}));
  EXPECT_EQ(line.written, (std::vector<std::uint32_t>{107, 69, 69}));
  EXPECT_EQ(dropped(DropCause::kSuperseded), 1U);
}

TEST_F(TxPortTest, CountsTheTimeThatAPacketLayInTheSocket) {
  open({});
  const auto content = bytes(30);
  PacketInfo old = info(TrafficClass::kHil, at({}), 1);
  old.waited = milliseconds(30);
  PacketInfo late = info(TrafficClass::kHil, at({}), 2);
  late.waited = milliseconds(10);
  PacketInfo command = info(TrafficClass::kCommand, at({}), 3);
  command.waited = std::chrono::seconds(5);
  const std::array packets{PacketRef{&old, content}, PacketRef{&late, content},
                           PacketRef{&command, content}};
  port->deliver(packets, at({}));
  EXPECT_EQ(line.written, (std::vector<std::uint32_t>{2, 3})) << "in their order";
  EXPECT_EQ(dropped(DropCause::kAge), 1U);
}

TEST_F(TxPortTest, NothingOfBeforeIsSentAfterAReopen) {
  open({});
  line.room = 150;
  deliver(TrafficClass::kHil, 4, at({}));
  deliver(TrafficClass::kCommand, 2, at({}));
  port->detach(at({}));
  deliver(TrafficClass::kHil, 1, at({}));
  line = FakeLine{};
  port->attach(std::make_unique<FakeWriter>(line), at({}));
  port->carry_on(at({}));
  EXPECT_EQ(line.bytes, 0U);
  EXPECT_EQ(dropped(DropCause::kClosed), 6U) << "the one that was begun, too";
  deliver(TrafficClass::kHil, 1, at({}));
  EXPECT_EQ(line.written, (std::vector<std::uint32_t>{8}));
}

TEST_F(TxPortTest, LooksAtTheLineBeforeItWrites) {
  open({.line_bytes_s = 10'000});
  line.unsent = 500;  // 50 ms of this line
  deliver(TrafficClass::kCommand, 1, at({}));
  EXPECT_TRUE(line.written.empty());
  EXPECT_EQ(port->due(), at(milliseconds(50)) - LinePacer::kSlack);
  line.unsent = 100;  // slower than its rate
  port->carry_on(port->due());
  EXPECT_TRUE(line.written.empty());
  line.unsent = 0;
  port->carry_on(port->due());
  EXPECT_EQ(line.written.size(), 1U);
}

TEST_F(TxPortTest, DropsWhatALineThatStandsStillMakesTooOld) {
  open({.line_bytes_s = 10'000});
  line.unsent = 300;  // 30 ms: more than the age limit
  deliver(TrafficClass::kHil, 1, at({}));
  line.unsent = 0;
  port->carry_on(port->due());
  EXPECT_TRUE(line.written.empty());
  EXPECT_EQ(dropped(DropCause::kAge), 1U);
}

TEST_F(TxPortTest, DoesNotBelieveADriverThatAlwaysSaysTheSame) {
  open({.line_bytes_s = 10'000});
  line.unsent = 4096;
  base::RunTime now = at({});
  deliver(TrafficClass::kCommand, 1, now);
  for (int i = 0; i < 20 && line.written.empty(); ++i) port->carry_on(now = port->due());
  EXPECT_EQ(line.written.size(), 1U);
  EXPECT_LT(now - at({}), 2 * LineCheck::kPatience);
}

TEST_F(TxPortTest, WaitsForFlowControlAsLongAsItTakes) {
  open({.line_bytes_s = 10'000, .flow_control = true});
  line.unsent = 4096;
  base::RunTime now = at({});
  deliver(TrafficClass::kCommand, 1, now);
  for (int i = 0; i < 100; ++i) port->carry_on(now = port->due());
  EXPECT_TRUE(line.written.empty());
  line.unsent = 0;
  port->carry_on(port->due());
  EXPECT_EQ(line.written.size(), 1U);
}

TEST_F(TxPortTest, CountsWhatACapMadeTooOldAsBandwidthByMessage) {
  open({.cap_bytes_s = 1'000});
  deliver(TrafficClass::kHil, 10, at({}), 10);  // 10 ms each
  for (int i = 0; i < 20; ++i) {
    if (port->due() != PollSet::kNever) port->carry_on(port->due());
  }
  EXPECT_EQ(dropped(DropCause::kAge), 0U);
  EXPECT_EQ(line.written.size() + dropped(DropCause::kBandwidth), 10U);
  std::uint64_t by_message = 0;
  counters->tx.dropped_messages[static_cast<std::size_t>(DropCause::kBandwidth)].for_each(
      [&](const MessageCounters::Entry& entry) { by_message += entry.count; });
  EXPECT_EQ(by_message, dropped(DropCause::kBandwidth));
  EXPECT_GT(by_message, 0U);
}

TEST_F(TxPortTest, TakesTheTimeOfAWriteFromTheWriter) {
  open({});
  line.took = milliseconds(3);
  deliver(TrafficClass::kHil, 1, at({}));
  const base::MutexLock lock(counters->tx.mutex);
  EXPECT_EQ(counters->tx.forwarding.others().max(), milliseconds(3)) << "of no link of casd's";
}

/// A thread whose waits take no time of ours.
class FakeWait final : public LineWait {
 public:
  explicit FakeWait(FakeLine& line) : line_(line) {}
  base::RunTime now() const override { return time; }
  void until(base::RunTime when) override { time = std::max(time, when); }
  void for_room(int, base::Duration at_most) override {
    time += at_most;
    if (time >= room_at) line_.room = 1'000'000;
  }

  base::RunTime time = at({});
  base::RunTime room_at = base::RunTime::max();  ///< when the line takes bytes again

 private:
  FakeLine& line_;
};

class BlockingTxPortTest : public TxPortTest {
 protected:
  void open_blocking(const TxPortOptions& options) {
    port = std::make_unique<BlockingTxPort>(options, LineDrain(base::Duration{}), wait, counters,
                                            [this] { ++wakes; });
    port->attach(std::make_unique<FakeWriter>(line), at({}));
  }
  FakeWait wait{line};
};

TEST_F(BlockingTxPortTest, WritesAPacketAndWaitsUntilTheLineIsThroughWithIt) {
  open_blocking({.line_bytes_s = 10'000});
  deliver(TrafficClass::kCommand, 2, at({}));
  EXPECT_TRUE(line.written.empty()) << "each turn of the loop writes one";
  EXPECT_LE(port->due(), at({}));
  port->carry_on(at({}));
  EXPECT_EQ(line.written, (std::vector<std::uint32_t>{1}));
  EXPECT_EQ(wait.time, at(milliseconds(10)));
  EXPECT_LE(port->due(), wait.time);
  port->carry_on(wait.time);
  EXPECT_EQ(line.written, (std::vector<std::uint32_t>{1, 2}));
  EXPECT_EQ(wait.time, at(milliseconds(20)));
  EXPECT_EQ(port->due(), PollSet::kNever);
}

TEST_F(BlockingTxPortTest, LosesAPacketThatFindsNoRoomForASecond) {
  open_blocking({});
  line.room = 0;
  deliver(TrafficClass::kCommand, 1, at({}));
  EXPECT_EQ(dropped(DropCause::kStalled), 1U);
  EXPECT_EQ(wait.time, at(std::chrono::seconds(1)));
}

TEST_F(BlockingTxPortTest, WaitsForRoomForTheRestOfAPacket) {
  open_blocking({});
  line.room = 40;
  wait.room_at = at(milliseconds(300));
  deliver(TrafficClass::kCommand, 1, at({}));
  EXPECT_EQ(counters->tx.packets.get(), 1U);
  EXPECT_EQ(line.bytes, 100U);
  EXPECT_EQ(wait.time, at(milliseconds(300)));
}

}  // namespace
}  // namespace cas::casd::test
