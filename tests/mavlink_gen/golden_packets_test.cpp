// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "tests/support/paths.hpp"

namespace {

using namespace cas::mav;
using nlohmann::json;
namespace common = mavlink::common;

std::vector<std::uint8_t> bytes_of_hex(const std::string& hex) {
  std::vector<std::uint8_t> bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

template <class T>
void set_from_json(T& member, const json& value) {
  if constexpr (std::is_enum_v<T>) {
    member = static_cast<T>(value.get<std::underlying_type_t<T>>());
  } else {
    member = value.get<T>();
  }
}

/// char arrays stand as hex, other arrays as lists.
template <class T, std::size_t n>
void set_from_json(std::array<T, n>& member, const json& value) {
  if constexpr (std::is_same_v<T, char>) {
    const auto bytes = bytes_of_hex(value.get<std::string>());
    ASSERT_EQ(bytes.size(), n);
    std::memcpy(member.data(), bytes.data(), n);
  } else {
    ASSERT_EQ(value.size(), n);
    for (std::size_t i = 0; i < n; ++i) set_from_json(member[i], value[i]);
  }
}

struct Packet {
  std::vector<std::uint8_t> bytes;
  json facts;
};

template <class Message>
void expect_both_ways(const Packet& packet) {
  SCOPED_TRACE(packet.facts.dump());
  Message expected;
  Message::for_each_field(
      [&](const FieldInfo& field, auto& member) {
        set_from_json(member, packet.facts["values"][std::string(field.name)]);
      },
      expected);

  PacketParser parser(common::table());
  int packets = 0;
  parser.feed(packet.bytes, [&](const PacketView& view) {
    ++packets;
    const auto decoded = decode<Message>(view);
    ASSERT_TRUE(decoded.has_value());
    if (view.version == 2) {
      EXPECT_EQ(*decoded, expected);
    }
    PacketBuffer out;
    const auto version = packet.facts["version"].get<int>();
    const auto sequence = packet.facts["seq"].get<std::uint8_t>();
    const Source source{packet.facts["sysid"].get<std::uint8_t>(),
                        packet.facts["compid"].get<std::uint8_t>()};
    EXPECT_EQ(view.source, source);
    EXPECT_EQ(view.sequence, sequence);
    if constexpr (Message::kId <= 0xFF) {
      out.size = version == 1 ? encode_v1(expected, source, sequence, out.bytes)
                              : encode(expected, source, sequence, out.bytes);
    } else {
      out.size = encode(expected, source, sequence, out.bytes);
    }
    EXPECT_EQ(std::vector(out.view().begin(), out.view().end()), packet.bytes);
  });
  EXPECT_EQ(packets, 1);
}

TEST(GoldenPackets, DecodeToTheirValuesAndEncodeToTheirBytes) {
  std::ifstream file(cas::test::source_dir() + "/tests/golden/mavlink_packets.jsonl");
  ASSERT_TRUE(file.is_open());
  int packets = 0;
  for (std::string line; std::getline(file, line);) {
    const auto message = json::parse(line);
    for (const auto& facts : message["frames"]) {
      const Packet packet{bytes_of_hex(facts["hex"].get<std::string>()), facts};
      const auto id = message["id"].get<std::uint32_t>();
      const bool known = common::dispatch(
          PacketView{.message_id = id},
          [&]<class Message>(const Message&) { expect_both_ways<Message>(packet); });
      EXPECT_TRUE(known) << id;
      ++packets;
    }
  }
  EXPECT_EQ(packets, 30);
}

}  // namespace
