// SPDX-License-Identifier: BSD-3-Clause
#include "plugins/common/plugin_messages.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "mavlink/common/all.hpp"
#include "mavlink_gen/runtime/public_table.hpp"
#include "plugins/mavlink_interface/hil_interface.hpp"
#include "tests/plugins/recording_port.hpp"
#include "tests/support/refusal.hpp"

namespace cas::sim {
namespace {

namespace mv = mavlink::common;
using test::at_ms;
using test::RecordingPort;

constexpr std::uint32_t kOpticalFlow = 100;  // not in our own dialect

std::vector<MavlinkSender> sender(std::vector<std::string> messages) {
  return {{.plugin = "battery", .topic = "iris0/mavlink/battery", .messages = std::move(messages)}};
}

MavlinkMessage message(std::uint32_t id, std::size_t size) {
  MavlinkMessage result{.id = id, .size = size};
  result.payload.fill(7);
  return result;
}

TEST(PluginMessages, AdmitsWhatIsDeclaredByNameOrId) {
  PluginMessages messages(sender({"147", "OPTICAL_FLOW"}));
  std::string refusal;
  const mav::MessageInfo* battery = messages.admit(0, message(147, 54), at_ms(0), refusal);
  ASSERT_NE(battery, nullptr);
  EXPECT_EQ(battery->name, "BATTERY_STATUS");
  EXPECT_NE(messages.admit(0, message(kOpticalFlow, 26), at_ms(0), refusal), nullptr);
  EXPECT_EQ(refusal, "");
  EXPECT_EQ(messages.refused(), 0U);
}

TEST(PluginMessages, RefusesTheRestAndSaysSoOnce) {
  PluginMessages messages(sender({"BATTERY_STATUS"}));
  std::string refusal;
  EXPECT_EQ(messages.admit(0, message(253, 51), at_ms(0), refusal), nullptr);
  EXPECT_EQ(refusal,
            "plugin battery publishes STATUSTEXT, which it does not declare (CAS_PLUGIN_SENDS); it "
            "is not sent");
  refusal.clear();
  EXPECT_EQ(messages.admit(0, message(253, 51), at_ms(1), refusal), nullptr);
  EXPECT_EQ(refusal, "");
  for (const std::size_t size : {0U, 55U, 255U, 1000U}) {
    EXPECT_EQ(messages.admit(0, message(147, size), at_ms(1), refusal), nullptr) << size;
  }
  EXPECT_EQ(refusal,
            "plugin battery publishes BATTERY_STATUS with a payload of a wrong size; it "
            "is not sent");
  EXPECT_EQ(
      messages.json().dump(),
      R"({"battery":{"declares":["BATTERY_STATUS"],"undeclared":2,"wrong_size":4,"too_often":0}})");
  messages.reset();
  EXPECT_EQ(messages.refused(), 0U);
}

TEST(PluginMessages, Lets250OfAMessagePassInASecond) {
  PluginMessages messages(sender({"BATTERY_STATUS", "OPTICAL_FLOW"}));
  std::string refusal;
  int admitted = 0;
  for (int ms = 0; ms < 2000; ++ms) {
    if (messages.admit(0, message(147, 54), at_ms(ms), refusal) != nullptr) ++admitted;
  }
  EXPECT_EQ(admitted, 500);
  EXPECT_EQ(refusal,
            "plugin battery publishes BATTERY_STATUS more than 250 times in a second; the "
            "rest is not sent");
  EXPECT_NE(messages.admit(0, message(kOpticalFlow, 26), at_ms(1999), refusal), nullptr);
}

TEST(PluginMessages, RefusesDeclarationsOfWhatIsNoneOrTheLoops) {
  const auto refusal = [](const std::string& word) {
    return test::refusal([&] { PluginMessages messages(sender({word})); });
  };
  EXPECT_EQ(refusal("NO_SUCH"),
            "plugin battery declares NO_SUCH, which is no message of the public MAVLink dialects");
  EXPECT_NE(refusal("16777217").find("is no message"), std::string::npos);
  EXPECT_NE(refusal("99999999999").find("is no message"), std::string::npos);
  for (const char* word : {"HEARTBEAT", "HIL_SENSOR", "113", "HIL_CONTROLS", "93"}) {
    EXPECT_NE(refusal(word).find("has for itself"), std::string::npos) << word;
  }
}

/// Sent messages are packets that another parser accepts, in one sequence with the others.
TEST(PluginMessages, GoOutAsPacketsOfTheSimulatorBeforeTheSensors) {
  RecordingPort port;
  HilInterfaceParams params;
  params.self = {3, 200};
  HilInterface interface(params, port, nullptr);
  PluginMessages messages(sender({"BATTERY_STATUS", "OPTICAL_FLOW"}));
  std::string refusal;
  mv::BatteryStatus status;
  status.voltages[0] = 12'345;
  const MavlinkMessage battery = mavlink_message(status);
  interface.on_imu(ImuSample{.time = at_ms(2)});
  EXPECT_TRUE(interface.on_message(*messages.admit(0, battery, at_ms(2), refusal), battery));
  const MavlinkMessage flow = message(kOpticalFlow, 26);
  EXPECT_TRUE(interface.on_message(*messages.admit(0, flow, at_ms(2), refusal), flow));
  interface.flush(at_ms(2));

  std::vector<std::uint32_t> ids;
  std::vector<int> sequence;
  mav::PacketParser parser(mav::public_table());
  for (const auto& packet : port.packets) {
    parser.feed(packet, [&](const mav::PacketView& view) {
      ids.push_back(view.message_id);
      sequence.push_back(view.sequence);
      EXPECT_EQ(view.source.system, 3);
      EXPECT_EQ(view.source.component, 200);
      if (const auto read = mav::decode<mv::BatteryStatus>(view)) {
        EXPECT_EQ(read->voltages[0], 12'345);
      }
      if (view.message_id == kOpticalFlow) {
        EXPECT_EQ(view.payload.size(), 26U);
      }
    });
  }
  EXPECT_EQ(ids, (std::vector<std::uint32_t>{mv::Heartbeat::kId, mv::BatteryStatus::kId,
                                             kOpticalFlow, mv::HilSensor::kId}));
  EXPECT_EQ(sequence, (std::vector<int>{0, 1, 2, 3}));
  EXPECT_EQ(interface.figures()["sent"]["OPTICAL_FLOW"], 1);
}

TEST(PluginMessages, WaitInABoundedQueue) {
  RecordingPort port;
  HilInterface interface({}, port, nullptr);
  PluginMessages messages(sender({"BATTERY_STATUS"}));
  std::string refusal;
  const MavlinkMessage battery = message(147, 54);
  const mav::MessageInfo& info = *messages.admit(0, battery, at_ms(0), refusal);
  int taken = 0;
  for (int i = 0; i < 100; ++i) taken += interface.on_message(info, battery) ? 1 : 0;
  EXPECT_EQ(taken, 32);
  interface.flush(at_ms(1));
  EXPECT_TRUE(interface.on_message(info, battery));
}

}  // namespace
}  // namespace cas::sim
