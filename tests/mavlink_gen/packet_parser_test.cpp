// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/public_table.hpp"
#include "mavlink_gen/runtime/sequence_tracker.hpp"

namespace {

using namespace cas::mav;
namespace common = mavlink::common;

using Bytes = std::vector<std::uint8_t>;

void append(Bytes& out, std::span<const std::uint8_t> bytes) {
  out.insert(out.end(), bytes.begin(), bytes.end());
}

Bytes packet_of(auto message, std::uint8_t sequence = 0) {
  PacketBuffer buffer;
  buffer.size = encode(message, {1, 1}, sequence, buffer.bytes);
  return {buffer.view().begin(), buffer.view().end()};
}

struct Received {
  std::vector<Bytes> packets, unknown;
  PacketParser::Stats stats;
};

Received receive(const Bytes& stream, std::size_t chunk,
                 const MessageTable& table = common::table()) {
  Received received;
  PacketParser parser(table);
  const auto keep = [](std::vector<Bytes>& into) {
    return [&into](const PacketView& view) {
      into.emplace_back(view.bytes.begin(), view.bytes.end());
    };
  };
  for (std::size_t i = 0; i < stream.size(); i += chunk) {
    const auto size = std::min(chunk, stream.size() - i);
    parser.feed(std::span(stream).subspan(i, size), keep(received.packets), keep(received.unknown));
  }
  received.stats = parser.stats();
  return received;
}

TEST(PacketParser, FindsPacketsBetweenGarbageWholeAndBytewise) {
  std::mt19937 random(7);
  Bytes stream;
  std::vector<Bytes> sent;
  const auto garbage = [&] {
    for (auto n = random() % 60; n > 0; --n) {
      const std::uint8_t start = random() % 2 == 0 ? kStartV1 : kStartV2;
      stream.push_back(random() % 4 == 0 ? start : static_cast<std::uint8_t>(random()));
    }
  };
  for (std::uint32_t i = 0; i < 2000; ++i) {
    garbage();
    common::HilSensor message{.time_usec = i, .xacc = static_cast<float>(random()) * 1e-9F};
    sent.push_back(packet_of(message, static_cast<std::uint8_t>(i)));
    append(stream, sent.back());
  }
  // Closes candidates that the last garbage may have opened.
  stream.insert(stream.end(), kMaxPacketBytes, 0);
  for (const std::size_t chunk :
       {stream.size(), std::size_t{1}, std::size_t{7}, std::size_t{300}}) {
    const auto received = receive(stream, chunk);
    EXPECT_EQ(received.packets, sent) << "chunks of " << chunk;
  }
}

TEST(PacketParser, StartByteAtTheEndOfAFailingPacketDoesNotCostTheNext) {
  auto broken = packet_of(common::Attitude{.time_boot_ms = 5, .yawspeed = 1});
  broken[12] ^= 1;
  broken.back() = kStartV2;
  auto stream = broken;
  const auto good = packet_of(common::Attitude{.time_boot_ms = 6, .yawspeed = 2});
  append(stream, good);
  append(stream, good);
  stream.insert(stream.end(), kMaxPacketBytes, 0);
  EXPECT_EQ(receive(stream, stream.size()).packets, (std::vector{good, good}));
  EXPECT_EQ(receive(stream, 1).packets, (std::vector{good, good}));
}

TEST(PacketParser, PacketComesOutWithItsLastByte) {
  const auto packet = packet_of(common::Heartbeat{});
  PacketParser parser(common::table());
  for (std::size_t i = 0; i < packet.size(); ++i) {
    int packets = 0;
    parser.feed(std::span(packet).subspan(i, 1), [&](const PacketView&) { ++packets; });
    EXPECT_EQ(packets, i + 1 == packet.size() ? 1 : 0);
  }
}

TEST(PacketParser, ReportsUnknownIdsApart) {
  static constexpr MessageInfo kOnlyHeartbeat[] = {{0, 50, 9, 9, -1, -1, "HEARTBEAT"}};
  static constexpr StaticMessageTable kStorage(kOnlyHeartbeat);
  Bytes stream = packet_of(common::Attitude{.time_boot_ms = 6, .yawspeed = 2});
  append(stream, packet_of(common::Heartbeat{}));
  const auto received = receive(stream, stream.size(), kStorage.view());
  EXPECT_EQ(received.packets.size(), 1U);
  EXPECT_EQ(received.unknown.size(), 1U);
  EXPECT_EQ(received.stats.unknown_ids, 1U);
}

TEST(PacketParser, PublicTableKnowsEveryMessageOfOurDialect) {
  for (const auto& info : common::table().all()) {
    const auto* found = public_table().find(info.id);
    ASSERT_NE(found, nullptr) << info.name;
    EXPECT_EQ(found->name, info.name);
    EXPECT_EQ(found->crc_extra, info.crc_extra) << info.name;
    EXPECT_EQ(found->min_length, info.min_length) << info.name;
    EXPECT_EQ(found->max_length, info.max_length) << info.name;
    EXPECT_EQ(found->target_system_offset, info.target_system_offset) << info.name;
    EXPECT_EQ(found->target_component_offset, info.target_component_offset) << info.name;
    EXPECT_EQ(public_table().find(info.name), found);
  }
  EXPECT_EQ(public_table().find(std::uint32_t{3}), nullptr);
}

TEST(SequenceTracker, CountsGapsPerSource) {
  SequenceTracker tracker;
  EXPECT_EQ(tracker.update({1, 1}, 250), 0U);
  EXPECT_EQ(tracker.update({1, 1}, 251), 0U);
  EXPECT_EQ(tracker.update({1, 2}, 9), 0U);
  EXPECT_EQ(tracker.update({1, 1}, 1), 5U);
  EXPECT_EQ(tracker.update({1, 2}, 10), 0U);
  EXPECT_EQ(tracker.lost(), 5U);
  EXPECT_EQ(tracker.received(), 5U);
}

}  // namespace
