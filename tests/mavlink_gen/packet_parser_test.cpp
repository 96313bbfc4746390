// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>
#include <stdexcept>
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
                 const MessageTable& table = common::table(), bool flush = false) {
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
  if (flush) parser.flush(keep(received.packets), keep(received.unknown));
  received.stats = parser.stats();
  return received;
}

/// The packets that a flushed parser must find, by the simplest search: a fresh one at every start
/// byte.
Received plain_search(const Bytes& stream, const MessageTable& table) {
  Received found;
  for (std::size_t i = 0; i < stream.size();) {
    const auto left = stream.size() - i;
    const auto* p = stream.data() + i;
    const std::size_t header = p[0] == kStartV1 ? kHeaderBytesV1 : kHeaderBytesV2;
    const bool start = p[0] == kStartV1 || p[0] == kStartV2;
    std::size_t used = 1;
    if (start && left >= header) {
      const bool is_signed = p[0] == kStartV2 && (p[2] & kIncompatSigned) != 0;
      const auto size = header + p[1] + kChecksumBytes + (is_signed ? kSignatureBytes : 0U);
      const auto id = p[0] == kStartV1 ? p[5]
                                       : p[7] | static_cast<unsigned>(p[8]) << 8U |
                                             static_cast<unsigned>(p[9]) << 16U;
      const auto* info = table.find(id);
      const bool fits = info == nullptr || p[0] == kStartV2 ||
                        (p[1] >= info->min_length && p[1] <= info->max_length);
      if (left >= size && fits) {
        const auto* end = p + header + p[1];
        const auto sum = Crc16().update({p + 1, end});
        const auto has_checksum = [&](unsigned extra) {
          const auto crc = Crc16(sum).update(static_cast<std::uint8_t>(extra)).value();
          return crc == (end[0] | end[1] << 8U);
        };
        const bool known_flags = p[0] == kStartV1 || (p[2] & ~unsigned{kIncompatSigned}) == 0;
        if (info == nullptr) {
          bool probable = false;
          for (unsigned extra = 0; extra < 256; ++extra) probable = probable || has_checksum(extra);
          if (probable && known_flags) found.unknown.emplace_back(p, p + size);
        } else if (!has_checksum(info->crc_extra)) {
          ++found.stats.crc_errors;
        } else if (!known_flags) {
          ++found.stats.incompatible;
          found.stats.skipped_bytes += size - 1;
          used = size;
        } else {
          found.packets.emplace_back(p, p + size);
          i += size;
          continue;
        }
      }
    }
    ++found.stats.skipped_bytes;
    i += used;
  }
  return found;
}

/// Starts, small lengths and ids that are known and not, repeated or at random, between packets.
Bytes hostile_stream(unsigned seed) {
  std::mt19937 random(seed);
  const auto hostile_byte = [&]() -> std::uint8_t {
    constexpr std::uint8_t kLikely[] = {kStartV1, kStartV2, 0, 0, 1, 3, 9, 10, 28, 30, 0xFF};
    return random() % 8 == 0 ? static_cast<std::uint8_t>(random())
                             : kLikely[random() % std::size(kLikely)];
  };
  Bytes stream;
  for (int part = 0; part < 30; ++part) {
    Bytes pattern(1 + random() % 6);
    for (auto& byte : pattern) byte = hostile_byte();
    for (auto n = random() % 100; n > 0; --n) append(stream, pattern);
    for (auto n = random() % 300; n > 0; --n) stream.push_back(hostile_byte());
    common::Tunnel tunnel{.payload_length = 128};
    for (auto& byte : tunnel.payload) byte = hostile_byte();
    for (auto packet : {packet_of(tunnel), packet_of(common::Heartbeat{}),
                        packet_of(common::Attitude{.yawspeed = static_cast<float>(part)})}) {
      if (random() % 4 == 0) packet[random() % packet.size()] ^= 1;
      if (random() % 4 == 0) packet.resize(random() % packet.size());
      append(stream, packet);
    }
  }
  return stream;
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
  // Zeros close candidates that the last garbage may have opened.
  stream.insert(stream.end(), kMaxPacketBytes, 0);
  for (const std::size_t chunk :
       {stream.size(), std::size_t{1}, std::size_t{7}, std::size_t{300}}) {
    const auto received = receive(stream, chunk);
    EXPECT_EQ(received.packets, sent) << "chunks of " << chunk;
  }
}

TEST(PacketParser, FindsInHostileBytesWhatThePlainestSearchFinds) {
  static constexpr MessageInfo kFew[] = {{0, 50, 9, 9, -1, -1, "HEARTBEAT"},
                                         {385, 147, 133, 133, 2, 3, "TUNNEL"}};
  static constexpr StaticMessageTable kStorage(kFew);
  std::size_t packets = 0;
  std::size_t unknown = 0;
  for (unsigned seed = 0; seed < 40; ++seed) {
    const auto stream = hostile_stream(seed);
    for (const auto& table : {common::table(), kStorage.view()}) {
      const auto expected = plain_search(stream, table);
      packets += expected.packets.size();
      unknown += expected.unknown.size();
      for (const std::size_t chunk :
           {stream.size(), std::size_t{1}, std::size_t{8}, std::size_t{301}}) {
        const auto received = receive(stream, chunk, table, true);
        ASSERT_EQ(received.packets, expected.packets) << "seed " << seed << ", chunks of " << chunk;
        ASSERT_EQ(received.unknown, expected.unknown) << "seed " << seed << ", chunks of " << chunk;
        ASSERT_EQ(received.stats.crc_errors, expected.stats.crc_errors);
        ASSERT_EQ(received.stats.skipped_bytes, expected.stats.skipped_bytes);
        ASSERT_EQ(received.stats.incompatible, expected.stats.incompatible);
      }
    }
  }
  EXPECT_GT(packets, 3000U);
  EXPECT_GT(unknown, 500U);
}

TEST(PacketParser, CallbackThatThrowsEachTimeGetsEachPacketOnce) {
  const auto stream = hostile_stream(3);
  const auto expected = receive(stream, stream.size(), common::table(), true);
  ASSERT_FALSE(expected.packets.empty() || expected.unknown.empty());
  for (const std::size_t chunk :
       {stream.size(), std::size_t{1}, std::size_t{8}, std::size_t{301}}) {
    Received received;
    PacketParser parser(common::table());
    const auto keep = [](std::vector<Bytes>& into) {
      return [&into](const PacketView& view) {
        into.emplace_back(view.bytes.begin(), view.bytes.end());
        throw std::runtime_error("of the callback");
      };
    };
    const auto feed = [&](std::span<const std::uint8_t> bytes) {
      while (true) {
        try {
          return parser.feed(bytes, keep(received.packets), keep(received.unknown));
        } catch (const std::runtime_error&) {
          bytes = bytes.last(parser.unread());
        }
      }
    };
    for (std::size_t i = 0; i < stream.size(); i += chunk) {
      feed(std::span(stream).subspan(i, std::min(chunk, stream.size() - i)));
    }
    const auto flushed = [&] {
      try {
        parser.flush(keep(received.packets), keep(received.unknown));
      } catch (const std::runtime_error&) {
        return false;
      }
      return true;
    };
    while (!flushed()) continue;
    EXPECT_EQ(received.packets, expected.packets) << "chunks of " << chunk;
    EXPECT_EQ(received.unknown, expected.unknown) << "chunks of " << chunk;
    EXPECT_EQ(parser.stats().skipped_bytes, expected.stats.skipped_bytes);
    EXPECT_EQ(parser.unread(), 0U);
  }
}

TEST(PacketParser, NoBytesCostMoreThanTwoReadsAndThreeHeadersEach) {
  std::vector<Bytes> patterns{{0xFE, 0xFF},       {0xFE, 0xFE, 0x0A},       {0xFD, 0xFF, 0x00},
                              {0xFE, 0x03},       {0xFD, 0xFD, 0x00, 0x00}, {0xFE},
                              {0xFD, 0xFD, 0x00}, {0xFD, 0, 0, 0, 0, 0, 0}, {0xFE, 9, 0, 0, 0}};
  for (const auto& pattern : patterns) {
    Bytes stream;
    while (stream.size() < 20000) append(stream, pattern);
    for (const std::size_t chunk : {stream.size(), std::size_t{1}, std::size_t{8}}) {
      const auto stats = receive(stream, chunk).stats;
      EXPECT_LE(stats.summed_bytes, 2 * stream.size()) << testing::PrintToString(pattern);
      EXPECT_LE(stats.headers, 3 * stream.size()) << testing::PrintToString(pattern);
    }
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

TEST(PacketParser, StrayStartByteDoesNotDelayThePacketBehindIt) {
  Bytes stream{kStartV2, 200, 0, 0, 1, 2, 3, 0xAA, 0xBB, 0xCC};  // looks like an unknown id
  append(stream, packet_of(common::Heartbeat{}));
  EXPECT_EQ(receive(stream, 1).packets.size(), 1U);
  EXPECT_EQ(receive(stream, stream.size()).packets.size(), 1U);
}

TEST(PacketParser, PacketInsideAPacketsPayloadIsNotInvented) {
  common::Tunnel tunnel{.payload_length = 128};
  const auto inner = packet_of(common::Heartbeat{});
  std::copy(inner.begin(), inner.end(), tunnel.payload.begin());
  tunnel.payload.back() = kStartV2;
  auto stream = packet_of(tunnel);
  append(stream, inner);
  for (const std::size_t chunk : {stream.size(), std::size_t{1}}) {
    const auto received = receive(stream, chunk);
    ASSERT_EQ(received.packets.size(), 2U);
    EXPECT_EQ(received.packets[1], inner);
    EXPECT_EQ(received.stats.skipped_bytes, 0U);
  }
}

TEST(PacketParser, AbuttingPacketsOfBothVersionsComeOut) {
  Bytes stream;
  PacketBuffer v1;
  for (std::uint8_t i = 0; i < 100; ++i) {
    append(stream, packet_of(common::HilSensor{.time_usec = i, .zacc = -9.8F}, i));
    v1.size = encode_v1(common::Attitude{.time_boot_ms = i}, {1, 1}, i, v1.bytes);
    append(stream, v1.view());
  }
  for (const std::size_t chunk : {stream.size(), std::size_t{1}, std::size_t{11}}) {
    const auto received = receive(stream, chunk);
    EXPECT_EQ(received.packets.size(), 200U);
    EXPECT_EQ(received.stats.skipped_bytes, 0U);
    EXPECT_EQ(received.stats.crc_errors, 0U);
  }
}

TEST(PacketParser, CutPacketCostsOnlyItself) {
  const auto whole = packet_of(common::Attitude{.time_boot_ms = 6, .yawspeed = 2});
  for (std::size_t kept = 0; kept < whole.size(); ++kept) {
    Bytes stream(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(kept));
    append(stream, whole);
    append(stream, whole);
    EXPECT_EQ(receive(stream, stream.size()).packets.size(), 2U) << kept;
    EXPECT_EQ(receive(stream, 1).packets.size(), 2U) << kept;
  }
}

TEST(PacketParser, FlushGivesUpOnAnIncompleteCandidate) {
  // The header of a long packet that never came, then a short one.
  auto stream = packet_of(common::HilSensor{.time_usec = 1, .id = 1});
  stream.resize(12);
  const auto inner = packet_of(common::Heartbeat{});
  append(stream, inner);
  PacketParser parser(common::table());
  int packets = 0;
  const auto count = [&](const PacketView&) { ++packets; };
  parser.feed(stream, count);
  EXPECT_EQ(packets, 0);
  parser.flush(count);
  EXPECT_EQ(packets, 1);
  parser.feed(inner, count);
  EXPECT_EQ(packets, 2);
}

TEST(PacketParser, ResetForgetsAHalfPacket) {
  const auto packet = packet_of(common::Heartbeat{});
  PacketParser parser(common::table());
  int packets = 0;
  const auto count = [&](const PacketView&) { ++packets; };
  parser.feed(std::span(packet).first(5), count);
  parser.reset();
  parser.feed(packet, count);
  EXPECT_EQ(packets, 1);
}

TEST(PacketParser, UnknownIncompatibilityFlagDropsThePacket) {
  auto packet = packet_of(common::Heartbeat{});
  const auto finish = [&](std::uint8_t incompat, std::uint8_t compat) {
    packet[2] = incompat;
    packet[3] = compat;
    const std::span body(packet.data() + 1, packet.size() - 3);
    const auto crc = Crc16().update(body).update(common::Heartbeat::kCrcExtra).value();
    packet[packet.size() - 2] = static_cast<std::uint8_t>(crc & 0xFFU);
    packet[packet.size() - 1] = static_cast<std::uint8_t>(crc >> 8U);
    return receive(packet, packet.size());
  };
  const auto dropped = finish(0x80, 0);
  EXPECT_TRUE(dropped.packets.empty());
  EXPECT_EQ(dropped.stats.incompatible, 1U);
  EXPECT_EQ(finish(0, 0xFF).packets.size(), 1U) << "compatibility flags never matter";
}

TEST(PacketParser, Version1LengthMustFitTheMessage) {
  const auto heartbeat_of_length = [](std::uint8_t length) {
    Bytes bytes{kStartV1, length, 0, 1, 1, 0};
    bytes.resize(kHeaderBytesV1 + length, 1);
    const auto crc = Crc16().update(std::span(bytes).subspan(1)).update(50).value();
    bytes.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
    bytes.push_back(static_cast<std::uint8_t>(crc >> 8U));
    return receive(bytes, bytes.size()).packets.size();
  };
  EXPECT_EQ(heartbeat_of_length(9), 1U);
  EXPECT_EQ(heartbeat_of_length(8), 0U);
  EXPECT_EQ(heartbeat_of_length(10), 0U);
}

TEST(PacketParser, UntrimmedEmptyAndLongPayloadsAreAccepted) {
  for (const std::size_t length : {0U, 1U, 9U, 20U, 255U}) {
    Bytes bytes{kStartV2, static_cast<std::uint8_t>(length), 0, 0, 0, 1, 1, 0, 0, 0};
    bytes.resize(kHeaderBytesV2 + length, 0);
    const auto crc = Crc16().update(std::span(bytes).subspan(1)).update(50).value();
    bytes.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
    bytes.push_back(static_cast<std::uint8_t>(crc >> 8U));
    EXPECT_EQ(receive(bytes, bytes.size()).packets.size(), 1U) << length;
    EXPECT_EQ(receive(bytes, 1).packets.size(), 1U) << length;
  }
}

TEST(PacketParser, ReportsUnknownIdsApart) {
  static constexpr MessageInfo kOnlyHeartbeat[] = {{0, 50, 9, 9, -1, -1, "HEARTBEAT"}};
  static constexpr StaticMessageTable kStorage(kOnlyHeartbeat);
  Bytes stream = packet_of(common::Attitude{.time_boot_ms = 6, .yawspeed = 2});
  append(stream, packet_of(common::Heartbeat{}));
  for (const std::size_t chunk : {stream.size(), std::size_t{1}, std::size_t{5}}) {
    const auto received = receive(stream, chunk, kStorage.view());
    EXPECT_EQ(received.packets.size(), 1U);
    EXPECT_EQ(received.unknown.size(), 1U);
    EXPECT_EQ(received.stats.unknown_ids, 1U);
  }
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
  ASSERT_NE(public_table().find(std::uint32_t{53}), nullptr);  // of development.xml
  EXPECT_EQ(public_table().find(std::uint32_t{53})->crc_extra, 3);
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
