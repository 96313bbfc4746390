// SPDX-License-Identifier: BSD-3-Clause
#include "casd/port/message_decoder.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "base/error.hpp"
#include "casd/counters/message_taps.hpp"
#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/codec.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::casd {
namespace {

using namespace std::chrono_literals;
using nlohmann::json;

template <class M>
mav::PacketBuffer packed(const M& message) {
  mav::PacketBuffer packet;
  packet.size = mav::encode(message, {1, 1}, 0, packet.bytes);
  return packet;
}

TEST(MessageDecoder, GivesFieldsInTheOrderOfTheXmlWithUnits) {
  const mav::PacketBuffer packet = packed(mavlink::common::Attitude{.roll = 0.25F});
  const json fields = MessageDecoder().fields(30, mav::view_packet(packet.view()).payload);
  EXPECT_EQ(fields.at(0), (json{{"name", "time_boot_ms"}, {"units", "ms"}, {"value", 0}}));
  EXPECT_EQ(fields.at(1), (json{{"name", "roll"}, {"units", "rad"}, {"value", 0.25}}));
  EXPECT_EQ(fields.size(), 7U);
}

TEST(MessageDecoder, ReadsTextsAndArrays) {
  mavlink::common::ParamValue value;
  mav::set_text(value.param_id, "MC_ROLL_P");
  const mav::PacketBuffer text = packed(value);
  EXPECT_EQ(MessageDecoder().fields(22, mav::view_packet(text.view()).payload).at(0).at("value"),
            "MC_ROLL_P");
  mavlink::common::HilActuatorControls controls;
  controls.controls[1] = 0.5F;
  const mav::PacketBuffer array = packed(controls);
  const json fields = MessageDecoder().fields(93, mav::view_packet(array.view()).payload);
  EXPECT_EQ(fields.at(1).at("value").size(), 16U);
  EXPECT_EQ(fields.at(1).at("value").at(1), 0.5);
}

TEST(MessageDecoder, KnowsNoFieldsOfAnUnknownMessage) {
  const std::uint8_t payload[] = {1, 2, 3};
  EXPECT_TRUE(MessageDecoder().fields(54321, payload).empty());
}

TEST(MessageDecoder, ShowsALaboratorysOwnDialectWithoutARebuild) {
  const cas::test::TemporaryFolder folder;
  const auto xml = folder.write("lab.xml", R"(<?xml version="1.0"?>
<mavlink><messages>
  <message id="54321" name="LAB_THING">
    <description>A thing.</description>
    <field type="uint8_t" name="state">State.</field>
    <field type="float" name="heat" units="degC">Heat.</field>
  </message>
</messages></mavlink>)");
  MessageDecoder decoder;
  add_dialect(xml, decoder);
  EXPECT_EQ(decoder.name(54321), "LAB_THING");
  const std::uint8_t payload[] = {0, 0, 0x28, 0x42, 7};  // 42.0f, then the byte
  EXPECT_EQ(decoder.fields(54321, payload),
            (json::array({{{"name", "state"}, {"value", 7}},
                          {{"name", "heat"}, {"units", "degC"}, {"value", 42}}})));
}

TEST(MessageDecoder, SaysWhatIsWrongWithADialect) {
  const cas::test::TemporaryFolder folder;
  MessageDecoder decoder;
  EXPECT_THROW(add_dialect(folder.write("bad.xml", "<mavlink><messages>"), decoder),
               base::ConfigError);
}

TEST(MessageTaps, KeepsTheNewestPacketOfWhatIsLookedAt) {
  MessageTaps taps;
  const MessageTaps::Key key{2, 30, {1, 1}};
  mavlink::common::Attitude attitude;
  base::RunTime now{1s};
  const auto arrive = [&](float roll) {
    attitude.roll = roll;
    const mav::PacketBuffer packet = packed(attitude);
    taps.on_packet(2, mav::view_packet(packet.view()), now);
  };
  arrive(0.1F);  // no look yet
  EXPECT_FALSE(taps.look(key, now).has_value());
  arrive(0.2F);
  arrive(0.3F);
  const auto sample = taps.look(key, now);
  ASSERT_TRUE(sample.has_value());
  EXPECT_EQ(sample->count, 2U);
  const json fields = MessageDecoder().fields(30, std::span(sample->payload).first(sample->size));
  EXPECT_EQ(fields.at(1).at("value"), 0.3);
}

TEST(MessageTaps, ForgetsWhatNobodyLooksAtAnyMore) {
  MessageTaps taps;
  const MessageTaps::Key key{2, 30, {1, 1}};
  EXPECT_FALSE(taps.look(key, base::RunTime{1s}).has_value());
  const mav::PacketBuffer packet = packed(mavlink::common::Attitude{});
  taps.on_packet(2, mav::view_packet(packet.view()), base::RunTime{2s});
  EXPECT_FALSE(taps.look(key, base::RunTime{10s}).has_value());  // a new look begins
}

TEST(MessageTaps, LooksAtABoundedNumberOfMessages) {
  MessageTaps taps;
  for (std::uint32_t id = 0; id < 200; ++id) {
    taps.look({1, id, {1, 1}}, base::RunTime{1s});
  }
  const mav::PacketBuffer packet = packed(mavlink::common::HomePosition{});  // id 242
  taps.on_packet(1, mav::view_packet(packet.view()), base::RunTime{1s});
  EXPECT_FALSE(taps.look({1, 242, {1, 1}}, base::RunTime{1s}).has_value());
}

}  // namespace
}  // namespace cas::casd
