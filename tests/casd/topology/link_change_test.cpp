// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/link_change.hpp"

#include <gmock/gmock.h>

#include <algorithm>
#include <string>
#include <vector>

#include "base/config/config.hpp"
#include "base/error.hpp"
#include "tests/support/refusal.hpp"

namespace cas::casd::test {
namespace {

using base::ConfigNode;
using testing::HasSubstr;

constexpr const char* kBench = R"(schema: 1
links:
  - {name: sim, type: udp, local: "127.0.0.1:0"}
  - {name: fcu, type: serial, device: /dev/ttyACM0, baud: 57600}
routes:
  - {from: sim, to: fcu, allow: [HIL_SENSOR]}
)";

Topology bench() { return Topology::parse(ConfigNode::parse(kBench)); }

Topology with(const std::string& request, const std::vector<std::uint8_t>& vehicles = {}) {
  return with_link(bench(), ConfigNode::parse(request, "link.add"), vehicles);
}

std::string fault_of(const std::string& request) {
  return cas::test::refusal([&] { with(request); });
}

TEST(LinkChange, WhatIsLeftOutIsNarrow) {
  const Topology changed = with("entry: {name: gcs, type: udp, remote: 'h:1'}", {1, 2});
  const AcceptRule& accept = changed.links.back().accept;
  EXPECT_TRUE(accept.ground_station);
  EXPECT_EQ(accept.block_systems, (std::vector<std::uint8_t>{1, 2, 254}));
  EXPECT_FALSE(changed.links.back().inject_failures);
  ASSERT_EQ(changed.routes.size(), 5U);
  for (std::size_t i = 1; i < changed.routes.size(); ++i) {
    const ForwardRule& rule = changed.routes[i].rule;
    EXPECT_EQ(std::ranges::count(rule.block, 107U), 1);  // HIL_SENSOR
  }
}

TEST(LinkChange, ReadsNoFileThatTheTopologyDoesNotCountOn) {
  for (const char* file : {"/etc/shadow", "../x.tlog", "elsewhere/x.tlog"}) {
    EXPECT_THAT(fault_of("entry: {name: l, type: tlog, file: " + std::string(file) + "}"),
                HasSubstr("the folder of recordings"))
        << file;
  }
  EXPECT_EQ(fault_of("entry: {name: l, type: tlog, file: x.tlog}"), "");
  EXPECT_THAT(fault_of("entry: {name: l, type: udp, remote: 'h:1', signing: {key_file: /etc/key}}"),
              HasSubstr("at run time only keys"));
}

TEST(LinkChange, ALogPlaysWhatVehiclesSaidAndMovesNoneThatIsNotInHil) {
  const Topology changed = with("entry: {name: l, type: tlog, file: x.tlog}", {1});
  const LinkConfig& log = changed.links.back();
  EXPECT_TRUE(log.accept.vehicles);
  EXPECT_FALSE(log.accept.ground_station);
  EXPECT_EQ(log.accept.block_systems, (std::vector<std::uint8_t>{1, 254}));
  EXPECT_EQ(log.to_not_hil, ToNotHil::kStopsOnly);
  EXPECT_THAT(fault_of("entry: {name: l, type: tlog, file: x.tlog, to_not_hil: all}"),
              HasSubstr("is for files"));
}

TEST(LinkChange, AcceptEverythingIsSaidAloud) {
  const Topology changed =
      with("entry: {name: v2, type: udp, remote: 'h:1', accept: everything}", {1});
  EXPECT_EQ(changed.links.back().accept, AcceptRule{});
}

TEST(LinkChange, TheOtherLinksAndTheirRoutesStayAsTheyAre) {
  const Topology before = bench();
  // More telemetry on the line than it carries, which would pace it in a topology read from a file.
  const Topology after = with("entry: {name: b, type: udp, remote: 'h:1', accept: everything}");
  ASSERT_EQ(after.links.size(), 3U);
  EXPECT_EQ(after.links[0], before.links[0]);
  EXPECT_EQ(after.links[1], before.links[1]);
  EXPECT_EQ(after.routes[0], before.routes[0]);
  EXPECT_EQ(without_link(after, "b"), before);
}

TEST(LinkChange, OfAnyTheRoutesOfOtherLinksAreLeftOut) {
  const Topology changed = with(
      "entry: {name: b, type: udp, remote: 'h:1'}\nroutes: [{from: any, to: any, block: [300]}]");
  EXPECT_EQ(changed.routes.size(), 5U);
  EXPECT_EQ(changed.routes[0].rule, bench().routes[0].rule);
}

TEST(LinkChange, AnEndpointStandsForNameTypeAndPlace) {
  const LinkConfig link = with("entry: {endpoint: 'udp:10.0.0.7:14550'}").links.back();
  EXPECT_EQ(link.name, "udp");
  EXPECT_EQ(link.type, LinkType::kUdp);
  EXPECT_EQ(link.remote, "10.0.0.7:14550");
  EXPECT_EQ(with("entry: {endpoint: 'tcp:5760', name: tools}").links.back().name, "tools");
}

TEST(LinkChange, OnePeerIsTheEndOfOneLink) {
  for (const std::string type : {"udp", "tcp"}) {
    const ConfigNode first = ConfigNode::parse("entry: {endpoint: '" + type + ":h:1'}");
    const Topology once = with_link(bench(), first, {});
    EXPECT_THROW(with_link(once, first, {}), base::ConfigError) << "each packet would come twice";
    const std::string other = "entry: {endpoint: '" + type + ":h:2'}";
    EXPECT_EQ(with_link(once, ConfigNode::parse(other), {}).links.size(), 4U);
  }
}

TEST(LinkChange, ClientsReadNothingOfTheEnvironment) {
  for (const char* entry :
       {"{name: l, type: serial, device: '/dev/${HOME}'}", "{endpoint: 'serial:${HOME}'}"}) {
    EXPECT_THAT(fault_of("entry: " + std::string(entry)),
                HasSubstr("device: variables are for files"))
        << entry << ": ";
  }
}

TEST(LinkChange, FaultsBearTheirPlace) {
  EXPECT_EQ(fault_of("entry: {name: fcu, type: udp, remote: 'h:1'}"),
            "link.add:1: entry.name: 'fcu' is the name of another link");
  EXPECT_THAT(fault_of("entry: {name: b, type: tcp_server, local: '0.0.0.0:5790'}"),
              HasSubstr("command port"));
  EXPECT_EQ(fault_of("entry: {name: b, type: udp, remote: h}"),
            "link.add:1: entry.remote: 'h' is not HOST:PORT");
  EXPECT_EQ(fault_of("entry: {name: b, type: udp, remote: 'h:1'}\nroutes: [{from: sim, to: fcu}]"),
            "link.add:2: routes[0]: has nothing to do with the new link 'b'");
  EXPECT_THAT(fault_of("entry: {name: b, type: udp, remote: 'h:1', speed: 1}"),
              HasSubstr("entry.speed"));
  EXPECT_THAT(fault_of("entry: {endpoint: 'udp:nowhere'}"), HasSubstr("entry.endpoint: endpoint"));
  EXPECT_EQ(fault_of("entry: {endpoint: 'udp:14550', type: udp}"),
            "link.add:1: entry.type: 'endpoint' says that already");
  EXPECT_THROW(without_link(bench(), "b"), base::ConfigError);
}

}  // namespace
}  // namespace cas::casd::test
