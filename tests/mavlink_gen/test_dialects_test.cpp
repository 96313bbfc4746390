// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "mavlink/common/all.hpp"
#include "mavlink/common/enum_text.hpp"
#include "mavlink/every_construct/all.hpp"
#include "mavlink/every_construct/enum_text.hpp"
#include "mavlink/nasty_names/all.hpp"
#include "mavlink/nasty_names/enum_text.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/print.hpp"

namespace {

using namespace cas::mav;
namespace every = mavlink::every_construct;
namespace nasty = mavlink::nasty_names;

TEST(TestDialects, SeveralDialectsLiveInOneProgram) {
  EXPECT_EQ(every::table().all().size(), 4U);
  EXPECT_EQ(nasty::table().all().size(), 12U);
  EXPECT_EQ(mavlink::common::table().all().size(), 101U);
}

TEST(TestDialects, EveryTypeSurvivesARoundTrip) {
  std::mt19937 random(5);
  for (int i = 0; i < 200; ++i) {
    std::array<std::uint8_t, every::AllTypes::kMaxLength> payload;
    for (auto& byte : payload) byte = static_cast<std::uint8_t>(random());
    const auto message = every::AllTypes::unpack(payload.data());
    PacketBuffer buffer;
    buffer.size = encode(message, {1, 1}, 0, buffer.bytes);
    PacketParser parser(every::table());
    int packets = 0;
    parser.feed(buffer.view(), [&](const PacketView& packet) {
      ++packets;
      std::array<std::uint8_t, every::AllTypes::kMaxLength> again;
      decode<every::AllTypes>(packet)->pack(again.data());
      EXPECT_EQ(again, payload);
    });
    EXPECT_EQ(packets, 1);
  }
}

TEST(TestDialects, ConstantIsFilledByTheEncoder) {
  PacketBuffer buffer;
  buffer.size = encode(every::CraneBeat{.protocol = 99}, {1, 1}, 0, buffer.bytes);
  EXPECT_EQ(decode<every::CraneBeat>(view_packet(buffer.view()))->protocol, 7);
}

template <class Status>
constexpr bool kTakesWideFlags = requires(Status status) {
  status.narrow = every::WideFlags{};
};

TEST(TestDialects, FieldTooNarrowForItsEnumIsANumberThatNoFlagIsAssignedTo) {
  static_assert(std::is_same_v<decltype(every::CraneStatus::narrow), std::uint16_t>);
  static_assert(!kTakesWideFlags<every::CraneStatus>);
  EXPECT_EQ(every::CraneStatus::kFields<>[0].enum_name, "WIDE_FLAGS") << "of which it is, it says";
  PacketBuffer buffer;
  buffer.size = encode(every::CraneStatus{.narrow = 0x1234}, {1, 1}, 0, buffer.bytes);
  EXPECT_EQ(decode<every::CraneStatus>(view_packet(buffer.view()))->narrow, 0x1234);
}

TEST(TestDialects, EnumOfASignedFieldReadsItsNegativeValues) {
  static_assert(std::is_same_v<std::underlying_type_t<every::Outcome>, std::int16_t>,
                "in a field of int8_t and in one of uint8_t");
  PacketBuffer buffer;
  const every::CraneReport sent{
      .outcome = static_cast<every::Outcome>(-1),
      .wanted = static_cast<every::Outcome>(255),
      .outcomes = {every::Outcome::kDone, static_cast<every::Outcome>(-2)}};
  buffer.size = encode(sent, {1, 1}, 0, buffer.bytes);
  const auto packet = view_packet(buffer.view());
  const auto received = decode<every::CraneReport>(packet);
  EXPECT_EQ(static_cast<int>(received->outcome), -1);
  EXPECT_EQ(static_cast<int>(received->wanted), 255);
  EXPECT_EQ(*received, sent);
  EXPECT_EQ(static_cast<int>(view_as<every::CraneReport>(packet)->outcome()), -1);
  std::string text;
  write_text(*received, [&](std::string_view piece) { text += piece; });
  EXPECT_EQ(text, "CRANE_REPORT outcome=-1 wanted=255 outcomes=[OUTCOME_DONE -2]");
}

TEST(TestDialects, EnumsHaveTheWidthOfTheirValues) {
  static_assert(std::is_same_v<std::underlying_type_t<every::Numbers>, std::int64_t>);
  static_assert(std::is_same_v<std::underlying_type_t<every::WideFlags>, std::uint64_t>);
  static_assert(std::is_same_v<std::underlying_type_t<every::CraneState>, std::uint16_t>);
  static_assert(std::is_same_v<std::underlying_type_t<every::SmallFlags>, std::uint8_t>);
  static_assert(every::Numbers::kNegative == static_cast<every::Numbers>(-5));
  EXPECT_EQ(name_of(every::Numbers::kNegative), "NUMBERS_NEGATIVE");
  EXPECT_EQ(value_of<every::WideFlags>("WIDE_FLAGS_ALL"), every::WideFlags::kAll);
}

TEST(TestDialects, UnitsOfTheWireBecomePlainOnes) {
  every::AllTypes message{.u8 = 90, .i8 = -3, .u64 = 1'500'000};
  EXPECT_DOUBLE_EQ(message.u8_deg(),
                   180.0);                   // deg/2: half degrees of a full circle in a byte
  EXPECT_DOUBLE_EQ(message.i8_m_s(), -0.6);  // m/s*5: fifths
  EXPECT_DOUBLE_EQ(message.u64_s(), 1.5);
  message.set_i8_m_s(1.0);
  message.set_u64_s(0.25);
  EXPECT_EQ(message.i8, 5);
  EXPECT_EQ(message.u64, 250'000U);
}

TEST(TestDialects, CollidingNamesGetAnUnderscore) {
  nasty::Namespace message;
  message.class_ = nasty::Class::kNamespace | nasty::Class::kClass;
  message.errno_ = 3;
  message.NULL_ = 4;
  EXPECT_TRUE(has(message.class_, nasty::Class::kClass));
  EXPECT_EQ(nasty::Namespace::kFields<>[0].name, "class");
  nasty::Std other{.out = 1, .in = 2, .message = 3, .value = 4};
  other.set_speed_m_s_(2.5);
  EXPECT_EQ(other.speed, 250);
  EXPECT_DOUBLE_EQ(other.speed_m_s_(), 2.5);
  EXPECT_EQ(other.speed_m_s, 0);
  PacketBuffer buffer;
  buffer.size = encode(other, {1, 1}, 0, buffer.bytes);
  EXPECT_EQ(*decode<nasty::Std>(view_packet(buffer.view())), other);
}

TEST(TestDialects, NastyMessagesPrint) {
  std::string out;
  write_json(nasty::Namespace{}, [&](std::string_view piece) { out += piece; });
  EXPECT_NE(out.find("\"operator\":0"), std::string::npos);
}

}  // namespace
