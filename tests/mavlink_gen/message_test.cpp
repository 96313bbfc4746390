// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <sstream>
#include <string>
#include <type_traits>

#include "mavlink/common/all.hpp"
#include "mavlink/common/enum_text.hpp"
#include "mavlink_gen/runtime/compare.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/print.hpp"

namespace {

using namespace cas::mav;
namespace common = mavlink::common;

std::string json_of(const auto& message) {
  std::string out;
  write_json(message, [&](std::string_view piece) { out += piece; });
  return out;
}

std::string text_of(const auto& message) {
  std::string out;
  write_text(message, [&](std::string_view piece) { out += piece; });
  return out;
}

/// Random bits in every field: enum values without a name, NaNs, and all.
template <class T>
void randomise(T& value, std::mt19937_64& random) {
  const auto bits = random();
  std::memcpy(&value, &bits, sizeof value);
}

template <class T, std::size_t n>
void randomise(std::array<T, n>& values, std::mt19937_64& random) {
  for (auto& value : values) randomise(value, random);
}

template <class Message>
Message random_message(std::mt19937_64& random) {
  std::array<std::uint8_t, Message::kMaxLength> payload;
  randomise(payload, random);
  // The last bytes are zero now and then, so that truncation meets every field.
  const auto kept = random() % (payload.size() + 1);
  if (random() % 2 == 0)
    std::fill(payload.begin() + static_cast<std::ptrdiff_t>(kept), payload.end(), std::uint8_t{0});
  auto message = Message::unpack(payload.data());
  if constexpr (Message::kId == 0) message.mavlink_version = 3;  // constant of the encoder
  return message;
}

template <class Message>
void expect_same_bytes(const Message& a, const Message& b) {
  std::array<std::uint8_t, Message::kMaxLength> left, right;
  a.pack(left.data());
  b.pack(right.data());
  EXPECT_EQ(left, right) << Message::kName;
}

template <class Message>
void expect_round_trip(const Message& message) {
  PacketBuffer buffer;
  buffer.size = encode(message, {1, 2}, 3, buffer.bytes);
  PacketParser parser(common::table());
  int packets = 0;
  parser.feed(buffer.view(), [&](const PacketView& packet) {
    ++packets;
    const auto decoded = decode<Message>(packet);
    ASSERT_TRUE(decoded.has_value());
    expect_same_bytes(*decoded, message);
    EXPECT_EQ(for_each_difference(*decoded, message, [](const auto&...) {}), 0U);
  });
  EXPECT_EQ(packets, 1) << Message::kName;
}

template <class Visitor>
void for_each_message(Visitor&& visitor) {
  for (const auto& info : common::table().all()) {
    EXPECT_TRUE(common::dispatch(PacketView{.message_id = info.id}, visitor)) << info.name;
  }
}

TEST(Message, EveryMessageSurvivesARoundTripWithAnyValues) {
  std::mt19937_64 random(11);
  for_each_message([&]<class Message>(const Message&) {
    for (int i = 0; i < 50; ++i) expect_round_trip(random_message<Message>(random));
  });
}

TEST(Message, Version1CarriesTheBaseFieldsOnly) {
  std::mt19937_64 random(12);
  for_each_message([&]<class Message>(const Message&) {
    if constexpr (Message::kId <= 0xFF) {
      const auto message = random_message<Message>(random);
      PacketBuffer buffer;
      buffer.size = encode_v1(message, {1, 2}, 3, buffer.bytes);
      EXPECT_EQ(buffer.size, kHeaderBytesV1 + Message::kMinLength + kChecksumBytes);
      PacketParser parser(common::table());
      int packets = 0;
      parser.feed(buffer.view(), [&](const PacketView& packet) {
        ++packets;
        const auto decoded = decode<Message>(packet);
        ASSERT_TRUE(decoded.has_value());
        for_each_difference(*decoded, message, [](const FieldInfo& field, const auto&...) {
          EXPECT_TRUE(field.extension) << field.name;
        });
      });
      EXPECT_EQ(packets, 1) << Message::kName;
    }
  });
}

TEST(Message, ViewReadsTheSameValuesAsDecodingAtEveryTruncation) {
  std::mt19937_64 random(13);
  std::array<std::uint8_t, 255> payload;
  randomise(payload, random);
  for (std::size_t size = 0; size <= payload.size(); ++size) {
    const std::span<const std::uint8_t> cut(payload.data(), size);
    const auto message = decode_payload<common::BatteryStatus>(cut);
    const common::BatteryStatus::View view(cut.data(), cut.size());
    ASSERT_EQ(view.id(), message.id) << size;
    ASSERT_EQ(view.type(), message.type) << size;
    ASSERT_EQ(view.voltages(), message.voltages) << size;
    ASSERT_EQ(view.current_consumed(), message.current_consumed) << size;
    ASSERT_EQ(view.voltages_ext(), message.voltages_ext) << size;
    ASSERT_EQ(view.fault_bitmask(), message.fault_bitmask) << size;
  }
}

TEST(Message, ViewOfTextBorrowsThePacketsBytes) {
  common::Statustext message{.severity = common::MavSeverity::kNotice};
  set_text(message.text, "calibrated");
  PacketBuffer buffer;
  buffer.size = encode(message, {1, 1}, 0, buffer.bytes);
  const auto packet = view_packet(buffer.view());
  const auto view = view_as<common::Statustext>(packet);
  ASSERT_TRUE(view.has_value());
  EXPECT_EQ(view->text(), "calibrated");
  EXPECT_GE(view->text().data(), reinterpret_cast<const char*>(buffer.bytes.data()));
  EXPECT_FALSE(view_as<common::Heartbeat>(packet).has_value());
}

TEST(Message, LongPayloadOfANewerDialectIsCut) {
  std::array<std::uint8_t, 255> payload;
  payload.fill(1);
  EXPECT_EQ(decode_payload<common::Heartbeat>(payload).custom_mode, 0x01010101U);
}

TEST(Message, MetadataIsThereAtCompileTime) {
  static_assert(std::is_same_v<common::MessageWithId<107>::type, common::HilSensor>);
  static_assert(std::is_same_v<common::MessageNamed<"HIL_SENSOR">, common::HilSensor>);
  static_assert(common::table().find("HIL_SENSOR")->id == 107);
  static_assert(common::table().find(107)->crc_extra == common::HilSensor::kCrcExtra);
  static_assert(common::table().find(9999) == nullptr);
  static_assert(common::HilSensor::kFields<>[0].units == "us");
  static_assert(name_of(common::MavResult::kDenied) == "MAV_RESULT_DENIED");
  static_assert(std::is_aggregate_v<common::HilSensor>);
}

TEST(Message, FieldsAreKnownById) {
  const auto fields = common::fields_of(common::GpsRawInt::kId);
  ASSERT_EQ(fields.size(), 16U);
  EXPECT_EQ(fields[2].name, "lat");
  EXPECT_EQ(fields[2].units, "degE7");
  EXPECT_EQ(fields[2].wire_offset, 8);
  EXPECT_TRUE(fields[15].extension);
  EXPECT_TRUE(common::fields_of(12345).empty());
}

TEST(Message, DispatchReachesOnlyTypesThatTheVisitorTakes) {
  PacketView packet{.message_id = common::Heartbeat::kId};
  int heartbeats = 0;
  const auto visitor = [&](const common::Heartbeat&) { ++heartbeats; };
  EXPECT_TRUE(common::dispatch(packet, visitor));
  packet.message_id = common::Attitude::kId;
  EXPECT_FALSE(common::dispatch(packet, visitor));
  packet.message_id = 123456;
  EXPECT_FALSE(common::dispatch(packet, visitor));
  EXPECT_EQ(heartbeats, 1);
}

TEST(Message, UnknownEnumValuesSurviveAndFlagsCombine) {
  using common::MavModeFlag;
  auto mode = MavModeFlag::kSafetyArmed | MavModeFlag::kHilEnabled;
  EXPECT_TRUE(has(mode, MavModeFlag::kHilEnabled));
  EXPECT_FALSE(has(mode, MavModeFlag::kAutoEnabled));
  EXPECT_TRUE(any(mode & MavModeFlag::kSafetyArmed));
  mode &= ~MavModeFlag::kSafetyArmed;
  EXPECT_EQ(mode, MavModeFlag::kHilEnabled);
  expect_round_trip(common::CommandAck{.command = static_cast<common::MavCmd>(64999),
                                       .result = static_cast<common::MavResult>(77)});
}

TEST(Print, JsonNamesEnumsAndFlagsAndKeepsUnknownNumbers) {
  common::Heartbeat heartbeat{
      .type = common::MavType::kQuadrotor,
      .autopilot = static_cast<common::MavAutopilot>(200),
      .base_mode = common::MavModeFlag::kSafetyArmed | common::MavModeFlag::kHilEnabled,
      .custom_mode = 4};
  EXPECT_EQ(json_of(heartbeat),
            R"({"message":"HEARTBEAT","type":"MAV_TYPE_QUADROTOR","autopilot":200,)"
            R"("base_mode":"MAV_MODE_FLAG_HIL_ENABLED|MAV_MODE_FLAG_SAFETY_ARMED",)"
            R"("custom_mode":4,"system_status":"MAV_STATE_UNINIT","mavlink_version":3})");
}

TEST(Print, JsonHasNoNanAndEscapesText) {
  common::NamedValueFloat named{.time_boot_ms = 1, .value = std::nanf("")};
  set_text(named.name, "a\"\\\n\xe9");
  EXPECT_EQ(json_of(named), R"({"message":"NAMED_VALUE_FLOAT","time_boot_ms":1,)"
                            R"("name":"a\"\\\u000a\u00e9","value":null})");
}

TEST(Print, TextShowsUnits) {
  EXPECT_EQ(text_of(common::RawRpm{.index = 2, .frequency = 1.5F}),
            "RAW_RPM index=2 frequency=1.5 rpm");
}

TEST(Print, BufferSinkCutsAndSaysSo) {
  std::array<char, 10> buffer;
  BufferSink sink(buffer);
  write_text(common::RawRpm{}, sink);
  EXPECT_EQ(sink.text(), "RAW_RPM in");
  EXPECT_FALSE(sink.complete());
}

TEST(Compare, NamesTheFieldsThatDiffer) {
  const auto nan = std::nanf("");
  const common::Attitude a{.time_boot_ms = 1, .roll = nan, .yaw = 1};
  const common::Attitude b{.time_boot_ms = 1, .roll = nan, .pitch = 2, .yaw = 3};
  std::string names;
  const auto count = for_each_difference(a, b, [&](const FieldInfo& field, const auto&...) {
    names += std::string(field.name) + ' ';
  });
  EXPECT_EQ(count, 2U);
  EXPECT_EQ(names, "pitch yaw ");
}

TEST(Quantity, ScaledFieldsReadAndWriteInPlainUnits) {
  common::GpsRawInt gps;
  gps.set_lat_deg(47.3977418);
  gps.set_alt_m(488.25);
  gps.set_vel_m_s(12.345);
  gps.set_eph_scaled(0.7);
  EXPECT_EQ(gps.lat, 473977418);
  EXPECT_DOUBLE_EQ(gps.lat_deg(), 47.3977418);
  EXPECT_EQ(gps.alt, 488250);
  EXPECT_EQ(gps.vel, 1235);
  EXPECT_DOUBLE_EQ(gps.eph_scaled(), 0.7);
}

TEST(Quantity, SentinelStandsForUnknown) {
  common::GpsRawInt gps{.vel = 65535};
  EXPECT_FALSE(gps.vel_known());
  EXPECT_TRUE(std::isnan(gps.vel_m_s()));
  gps.set_vel_m_s(1e9);
  EXPECT_TRUE(gps.vel_known());
  EXPECT_EQ(gps.vel, 65534);
  gps.set_vel_m_s(std::nan(""));
  EXPECT_EQ(gps.vel, 65535);
  EXPECT_FALSE(common::CommandLong{.param1 = std::nanf("")}.param1_known());
  common::BatteryStatus battery;
  battery.voltages.fill(UINT16_MAX);
  EXPECT_FALSE(battery.voltages_known());
  battery.voltages[0] = 3700;
  EXPECT_TRUE(battery.voltages_known());
}

TEST(Quantity, OutOfRangeIsHeldAtTheLimit) {
  common::GlobalPositionInt position;
  position.set_vx_m_s(1000);
  EXPECT_EQ(position.vx, std::numeric_limits<std::int16_t>::max());
  position.set_vx_m_s(-1000);
  EXPECT_EQ(position.vx, std::numeric_limits<std::int16_t>::min());
}

TEST(EnumText, EveryEnumIsFoundByNameAlsoOneThatNoFieldHas) {
  const auto* item = common::find_enum("MAV_VTOL_STATE");  // of a command's parameter alone
  ASSERT_NE(item, nullptr);
  EXPECT_EQ(item->name, "MAV_VTOL_STATE");
  EXPECT_FALSE(item->entries.empty());
  EXPECT_EQ(common::find_enum("MAV_VTOL_STAT"), nullptr);
  EXPECT_TRUE(std::ranges::is_sorted(common::enums(), {}, &EnumInfo::name));
  static_assert(common::find_enum("MAV_CMD")->entries.size() > 10);
}

TEST(TextView, TradesWithTheStandardsTexts) {
  static_assert(TextView("abc") == "abc" && "abc" == TextView("abc") && TextView("abc") != "ab");
  static_assert(std::string_view(TextView("abc")) == "abc");
  static_assert(TextView("abcd", 2) == std::string_view("ab"));
  static_assert(TextView().empty() && TextView("HIL_GPS").starts_with("HIL_"));
  static_assert(!TextView("HIL").starts_with("HIL_"));
  const std::string text(common::Heartbeat::kName);
  EXPECT_EQ(text, common::Heartbeat::kName);
  const std::string_view view = TextView(text);
  EXPECT_EQ(view.data(), text.data());
  std::ostringstream out;
  out << common::Heartbeat::kName << '.';
  EXPECT_EQ(out.str(), "HEARTBEAT.");
}

TEST(EnumText, EntriesAreFoundByNameAndCommandsKnowTheirParameters) {
  EXPECT_EQ(value_of<common::MavCmd>("MAV_CMD_NAV_TAKEOFF"), common::MavCmd::kNavTakeoff);
  EXPECT_EQ(value_of<common::MavCmd>("MAV_CMD_NAV_TAKEOF"), std::nullopt);
  const auto* takeoff = find_entry(common::MavCmd::kNavTakeoff);
  ASSERT_NE(takeoff, nullptr);
  ASSERT_EQ(takeoff->params.size(), 7U);
  EXPECT_EQ(takeoff->params[6].label, "Altitude");
  EXPECT_EQ(takeoff->params[6].units, "m");
  EXPECT_EQ(name_of(static_cast<common::MavCmd>(64999)), "");
}

}  // namespace
