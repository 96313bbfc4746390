// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/injection.hpp"

#include <gtest/gtest.h>

#include "base/config/config.hpp"

namespace cas::casd {
namespace {

std::vector<std::string> warnings(const std::string& gcs, const std::string& routes) {
  return injection_warnings(Topology::parse(
      base::ConfigNode::parse("schema: 1\nlinks:\n"
                              "  - {name: sim, type: udp, local: '127.0.0.1:0'}\n"
                              "  - {name: fcu, type: serial, device: /dev/x}\n"
                              "  - {name: gcs, type: udp_server, local: '127.0.0.1:0'" +
                              gcs + "}\n" + routes)));
}

const std::string kSimulator = "routes:\n  - {from: sim, to: fcu, allow: [HIL_SENSOR]}\n";

TEST(Injection, AnOpenRouteToAControllerIsTold) {
  const auto told = warnings("", kSimulator + "  - {from: gcs, to: fcu}\n");
  ASSERT_EQ(told.size(), 1U);
  EXPECT_EQ(told[0].rfind("whoever is at link gcs can send HIL_SENSOR to fcu", 0), 0U) << told[0];
}

TEST(Injection, WithoutRoutesEverybodyIsTold) { EXPECT_EQ(warnings("", "").size(), 2U); }

TEST(Injection, AControllerOnASocketIsKnownByTheSimulatorsRoute) {
  const auto told = injection_warnings(Topology::parse(
      base::ConfigNode::parse("schema: 1\nlinks:\n"
                              "  - {name: sim, type: udp, local: '127.0.0.1:0'}\n"
                              "  - {name: sitl, type: tcp, remote: '127.0.0.1:5760'}\n"
                              "  - {name: gcs, type: udp, local: '127.0.0.1:0'}\n"
                              "routes:\n"
                              "  - {from: sim, to: sitl, allow: [HIL_SENSOR]}\n"
                              "  - {from: gcs, to: sitl, block: [HIL_GPS]}\n"
                              "  - {from: sitl, to: gcs}\n")));
  ASSERT_EQ(told.size(), 1U);
}

struct QuietCase {
  const char* name;
  const char* gcs;
  const char* route;
};

class NoInjection : public testing::TestWithParam<QuietCase> {};

TEST_P(NoInjection, WhereHilSensorIsKeptOut) {
  const auto told = warnings(GetParam().gcs, kSimulator + GetParam().route);
  EXPECT_TRUE(told.empty()) << told.front();
}

INSTANTIATE_TEST_SUITE_P(
    By, NoInjection,
    testing::Values(
        QuietCase{"Traffic", ", accept: {traffic: ground_station}", "  - {from: gcs, to: fcu}\n"},
        QuietCase{"Messages", ", accept: {messages: [COMMAND_LONG]}", "  - {from: gcs, to: fcu}\n"},
        QuietCase{"ReadOnly", ", accept: nothing", "  - {from: gcs, to: fcu}\n"},
        QuietCase{"Block", "", "  - {from: gcs, to: fcu, block: [HIL_SENSOR]}\n"},
        QuietCase{"Allow", "", "  - {from: gcs, to: fcu, allow: [COMMAND_LONG]}\n"},
        QuietCase{"NoRoute", "", "  - {from: fcu, to: gcs}\n"}),
    [](const auto& test) { return test.param.name; });

TEST(Injection, NamedMessagesOpenStationTrafficAgain) {
  EXPECT_EQ(warnings(", accept: {traffic: ground_station, messages: [HIL_SENSOR]}",
                     kSimulator + "  - {from: gcs, to: fcu}\n")
                .size(),
            1U);
}

}  // namespace
}  // namespace cas::casd
