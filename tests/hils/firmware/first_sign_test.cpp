// SPDX-License-Identifier: BSD-3-Clause
#include "hils/firmware/first_sign.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace cas::hils {
namespace {

using nlohmann::json;

json px4_stats(int connections) {
  return {{"plugins",
           {{"mavlink_interface@iris0",
             {{"endpoint", "tcp 127.0.0.1:4560"}, {"port", {{"connections", connections}}}}}}}};
}

json link(const char* name, const char* type, const char* endpoint, int bytes) {
  return {{"name", name}, {"type", type}, {"endpoint", endpoint}, {"rx", {{"bytes", bytes}}}};
}

TEST(FirstSign, OfNothingNamesEachPlaceThatWasListenedAt) {
  const json links{link("px4", "udp", "127.0.0.1:14550", 0),
                   link("hils_companion", "udp", "127.0.0.1:40000", 12)};
  const FirstSign sign = first_sign(px4_stats(0), links, "iris0", false);
  EXPECT_FALSE(sign.anything) << "hils' own link does not count";
  EXPECT_EQ(sign.words,
            "nobody connected to tcp 127.0.0.1:4560; nothing on link px4 (127.0.0.1:14550)");
}

TEST(FirstSign, InSoftwareIsAConnectionOrAPacketAtTheSimulator) {
  const json links = json::array({link("px4", "udp", "127.0.0.1:14550", 17)});
  EXPECT_TRUE(
      first_sign(px4_stats(1), json::array({link("px4", "udp", "", 0)}), "iris0", false).anything);
  const FirstSign bytes = first_sign(px4_stats(0), links, "iris0", false);
  EXPECT_FALSE(bytes.anything) << "it may be a ground station";
  EXPECT_NE(bytes.words.find("17 bytes and no HEARTBEAT of an autopilot on link px4"),
            std::string::npos);
  const json ardupilot{
      {"plugins",
       {{"ardupilot_json@iris0", {{"endpoint", "udp 127.0.0.1:9002"}, {"packets", 3}}}}}};
  EXPECT_EQ(first_sign(ardupilot, json::array(), "iris0", false).words,
            "3 packets came to udp 127.0.0.1:9002");
}

TEST(FirstSign, OfFirmwareOnASerialLineComesOverThatLine) {
  const json links{link("sim", "udp", "127.0.0.1:14561", 9000),
                   link("fcu", "serial", "/dev/pts/3", 0)};
  const FirstSign sign = first_sign(json::object(), links, "iris0", true);
  EXPECT_FALSE(sign.anything) << "the simulator's packets are not the firmware's";
  EXPECT_EQ(sign.words, "nothing on link fcu (/dev/pts/3)");
  EXPECT_TRUE(first_sign(json::object(), json::array({link("fcu", "serial", "", 1)}), "iris0", true)
                  .anything);
}

TEST(FirstSign, OfAnotherAutopilotOrAPlaneDoesNotFitTheWorld) {
  VehicleReport vehicle{.heard = true, .autopilot = "PX4", .type = "quadrotor"};
  EXPECT_FALSE(mismatch(vehicle, "PX4", false));
  EXPECT_FALSE(mismatch(vehicle, "", false));
  EXPECT_EQ(mismatch(vehicle, "ArduPilot", false),
            "the scenario's world is for ArduPilot, and the first HEARTBEAT is of PX4: start "
            "ArduPilot, or take a scenario of PX4");
  vehicle.type = "fixed_wing";
  EXPECT_EQ(mismatch(vehicle, "PX4", false),
            "the scenario's vehicle is a multirotor, and by its first HEARTBEAT the firmware flies "
            "a fixed_wing: start the firmware for copters");
  EXPECT_FALSE(mismatch(vehicle, "PX4", true));
  vehicle.type = "rover";
  EXPECT_EQ(mismatch(vehicle, "PX4", true),
            "the scenario's vehicle is a plane, and by its first HEARTBEAT the firmware flies a "
            "rover: start the firmware for planes");
}

}  // namespace
}  // namespace cas::hils
