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

const std::string kSimRoute = "routes:\n  - {from: sim, to: fcu, allow: [HIL_SENSOR]}\n";

TEST(Injection, AnOpenRouteToAControllerIsTold) {
  const auto told = warnings("", kSimRoute + "  - {from: gcs, to: fcu}\n");
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

TEST(NoInjection, WhereHilSensorIsKeptOut) {
  struct QuietCase {
    const char* name;
    const char* gcs;
    const char* route;
  };
  const QuietCase rows[] = {
      {"Traffic", ", accept: {traffic: ground_station}", "  - {from: gcs, to: fcu}\n"},
      {"Messages", ", accept: {messages: [COMMAND_LONG]}", "  - {from: gcs, to: fcu}\n"},
      {"ReadOnly", ", accept: nothing", "  - {from: gcs, to: fcu}\n"},
      {"Block", "", "  - {from: gcs, to: fcu, block: [HIL_SENSOR]}\n"},
      {"Allow", "", "  - {from: gcs, to: fcu, allow: [COMMAND_LONG]}\n"},
      {"NoRoute", "", "  - {from: fcu, to: gcs}\n"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const auto told = warnings(row.gcs, kSimRoute + row.route);
    EXPECT_TRUE(told.empty()) << told.front();
  }
}

TEST(Injection, NamedMessagesOpenStationTrafficAgain) {
  EXPECT_EQ(warnings(", accept: {traffic: ground_station, messages: [HIL_SENSOR]}",
                     kSimRoute + "  - {from: gcs, to: fcu}\n")
                .size(),
            1U);
}

Topology station_at(const std::string& local, const std::string& more) {
  return Topology::parse(
      base::ConfigNode::parse("schema: 1\nlinks:\n  - {name: gcs, type: udp_server, local: '" +
                              local + "', inject_failures: true" + more + "}\n"));
}

TEST(InjectingStation, IsToldOfWhereAnyHostMayBeIt) {
  struct StationCase {
    const char* name;
    const char* local;
    const char* more;
    bool may;   ///< inject failures
    bool told;  ///< warns that any station may
  };
  const StationCase rows[] = {
      {"Everywhere", "0.0.0.0:14550", "", true, true},
      {"OneNetwork", "192.168.4.1:14550", "", true, true},
      {"EverywhereV6", "[::]:14550", "", true, true},
      {"StationTraffic", "0.0.0.0:14550", ", accept: {traffic: ground_station}", true, true},
      {"CommandInt", "0.0.0.0:14550", ", accept: {messages: [COMMAND_INT]}", true, true},
      {"SignsAlone", "0.0.0.0:14550", ", signing: {key_file: k, verify: false}", true, true},
      {"Signed", "0.0.0.0:14550", ", signing: {key_file: k}", true, false},
      {"ThisMachine", "127.0.0.1:14550", "", true, false},
      {"ThisMachineV6", "[::1]:14550", "", true, false},
      {"NoCommand", "0.0.0.0:14550", ", accept: {messages: [HEARTBEAT]}", false, false},
      {"ReadOnly", "0.0.0.0:14550", ", accept: nothing", false, false}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const Topology topology = station_at(row.local, row.more);
    EXPECT_EQ(may_inject_failures(topology.links.at(0)), row.may);
    const auto told = injection_warnings(topology);
    ASSERT_EQ(told.size(), row.told ? 1U : 0U);
    if (row.told) {
      EXPECT_EQ(told[0].rfind("any host that reaches link gcs may have failures strike", 0), 0U);
    }
  }
}

}  // namespace
}  // namespace cas::casd
