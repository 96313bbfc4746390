// SPDX-License-Identifier: BSD-3-Clause
#include "mavlink_gen/json/message_codec.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "mavlink/common/all.hpp"
#include "mavlink/common/enum_text.hpp"
#include "mavlink_gen/parser/dialect_loader.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/print.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::mav::services {
namespace {

using namespace mavlink::common;
using Json = nlohmann::ordered_json;

constexpr Source kSender{1, 1};

std::string packed_text(const PacketBuffer& packet) {
  return {packet.bytes.begin(), packet.bytes.begin() + static_cast<std::ptrdiff_t>(packet.size)};
}

/// A message with a bit of everything.
template <class M>
void round_trip(const M& message) {
  const MessageCodec codec;
  PacketBuffer packet;
  packet.size = encode(message, kSender, 9, packet.bytes);
  const Json object = codec.to_json(view_packet(packet.view()));
  std::string printed;
  write_json(message, [&](std::string_view piece) { printed += piece; });
  EXPECT_EQ(object, Json::parse(printed)) << "the generated code says the same";
  EXPECT_EQ(packed_text(codec.from_json(object, kSender, 9)), packed_text(packet)) << object;
}

TEST(MessageCodec, GivesAndTakesWhatTheGeneratedCodeSays) {
  round_trip(Attitude{.time_boot_ms = 5, .roll = 0.1F, .yaw = -1.5F});
  round_trip(Heartbeat{.type = MavType::kQuadrotor,
                       .base_mode = MavModeFlag::kSafetyArmed | MavModeFlag::kHilEnabled,
                       .custom_mode = 4'000'000'000});
  ParamValue value{.param_count = 7};
  set_text(value.param_id, "MC_ROLL_P");
  round_trip(value);
  Statustext text;
  set_text(text.text, "20 \xB0, \x80 and \xFF");
  round_trip(text);
  HilActuatorControls controls;
  controls.controls[3] = 0.25F;
  round_trip(controls);
  round_trip(CommandLong{.command = MavCmd::kNavTakeoff,
                         .param5 = std::numeric_limits<float>::quiet_NaN()});
}

TEST(MessageCodec, TakesEnumsByNameAndByNumber) {
  const MessageCodec codec;
  const Json by_name = {{"message", "HEARTBEAT"},
                        {"type", "MAV_TYPE_QUADROTOR"},
                        {"base_mode", "MAV_MODE_FLAG_SAFETY_ARMED|1"}};
  const auto heartbeat =
      decode<Heartbeat>(view_packet(codec.from_json(by_name, kSender, 0).view()));
  ASSERT_TRUE(heartbeat);
  EXPECT_EQ(heartbeat->type, MavType::kQuadrotor);
  EXPECT_EQ(static_cast<int>(heartbeat->base_mode), 129);
  EXPECT_EQ(heartbeat->mavlink_version, 3) << "the dialect's, not the sender's";
  EXPECT_EQ(packed_text(codec.from_json({{"message", "HEARTBEAT"}, {"type", 2}, {"base_mode", 129}},
                                        kSender, 0)),
            packed_text(codec.from_json(by_name, kSender, 0)));
}

TEST(Refused, WithASentence) {
  struct Refusal {
    const char* object;
    const char* sentence;
  };
  const Refusal rows[] = {
      {R"({"roll": 1})", R"(a message is an object with its name under "message")"},
      {R"({"message": "ATITUDE"})", "there is no message ATITUDE"},
      {R"({"message": "ATTITUDE", "rol": 1})", "ATTITUDE has no field 'rol'; did you mean 'roll'?"},
      {R"({"message": "HEARTBEAT", "autopilot": 256})",
       "autopilot: 256 does not fit into the field"},
      {R"({"message": "HEARTBEAT", "custom_mode": 1.5})", "custom_mode: 1.5 is no whole number"},
      {R"({"message": "HEARTBEAT", "type": "MAV_TYPE_QUADROTR"})",
       "type: \"MAV_TYPE_QUADROTR\" is no entry of MAV_TYPE; did you mean 'MAV_TYPE_QUADROTOR'?"},
      {R"({"message": "STATUSTEXT", "text": "\u20ac"})",
       "text: \"\u20ac\" has a character that is no byte of Latin-1"},
      {R"({"message": "PARAM_SET", "param_id": "SEVENTEEN_LETTERS"})",
       "param_id: \"SEVENTEEN_LETTERS\" is longer than 16 characters"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.object);
    EXPECT_EQ(cas::test::refusal<std::invalid_argument>(
                  [&] { MessageCodec().from_json(Json::parse(row.object), kSender, 0); }),
              row.sentence);
  }
}

TEST(MessageCodec, ReadsAndWritesADialectThatIsReadAtRunTime) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("lab.xml", R"(<?xml version="1.0"?>
<mavlink>
  <enums><enum name="LAB_STATE"><entry value="-1" name="LAB_OFF"/><entry value="3" name="LAB_ON"/></enum></enums>
  <messages>
    <message id="54321" name="LAB_THING">
      <field type="int8_t" name="state" enum="LAB_STATE">State.</field>
      <field type="uint16_t[2]" name="counts">Counts.</field>
      <field type="float" name="heat" units="degC">Heat.</field>
    </message>
  </messages>
</mavlink>)");
  xml::Diagnostics diagnostics;
  const auto dialect = xml::load_dialect(file, diagnostics);
  ASSERT_TRUE(dialect) << diagnostics.render();
  MessageCodec codec;
  codec.add(*dialect);
  const Json object = {
      {"message", "LAB_THING"}, {"state", "LAB_OFF"}, {"counts", {1, 65535}}, {"heat", 21.5}};
  const PacketBuffer packet = codec.from_json(object, kSender, 0);
  EXPECT_EQ(codec.to_json(view_packet(packet.view())), object);
  EXPECT_EQ(codec.find("LAB_THING"), 54321U);
  EXPECT_EQ(codec.name(0), "HEARTBEAT") << "the project's dialect stays";
}

}  // namespace
}  // namespace cas::mav::services
