// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/endpoint_notation.hpp"

#include <gtest/gtest.h>

#include "base/config/config.hpp"
#include "base/error.hpp"
#include "casd/topology/injection.hpp"
#include "casd/topology/topology.hpp"

namespace cas::casd {
namespace {

constexpr auto kPlain = EndpointUse::kPlain;
constexpr auto kMaster = EndpointUse::kMaster;
constexpr auto kOut = EndpointUse::kOut;

TEST(Notations, AreReadAsTheirProgramsMeanThem) {
  struct Notation {
    std::string text;
    EndpointUse use;
    std::string entry;  ///< of a link named l
  };
  const Notation rows[] = {
      // mavp2p
      {"serial:/dev/ttyAMA0:57600", kPlain,
       "serial, device: \"/dev/ttyAMA0\", unknown_messages: pass, baud: 57600"},
      {"udps:0.0.0.0:5600", kPlain, "udp_server, local: \"0.0.0.0:5600\""},
      {"udpc:127.0.0.1:5601", kPlain, "udp, remote: \"127.0.0.1:5601\""},
      {"tcps:0.0.0.0:5600", kPlain, "tcp_server, local: \"0.0.0.0:5600\""},
      {"tcpc:host:5601", kPlain, "tcp, remote: \"host:5601\""},
      // MAVProxy
      {"/dev/ttyACM0,115200", kMaster,
       "serial, device: \"/dev/ttyACM0\", unknown_messages: pass, baud: 115200"},
      {"udpin:0.0.0.0:14550", kMaster, "udp_server, local: \"0.0.0.0:14550\""},
      {"udp:127.0.0.1:14550", kMaster, "udp_server, local: \"127.0.0.1:14550\""},
      {"127.0.0.1:14550", kMaster, "udp_server, local: \"127.0.0.1:14550\""},
      {"127.0.0.1:14551", kOut, "udp, remote: \"127.0.0.1:14551\""},
      {"udpbcast:192.168.1.255:14550", kOut, "udp, remote: \"192.168.1.255:14550\""},
      {"tcpin:0.0.0.0:5762", kOut, "tcp_server, local: \"0.0.0.0:5762\""},
      {"tcp:127.0.0.1:5760", kMaster, "tcp, remote: \"127.0.0.1:5760\""},
      {"udpcast:192.168.1.255:14550", kOut, "udp, remote: \"192.168.1.255:14550\""},
      {"mcast:", kMaster, "udp, local: \"0.0.0.0:14550\", remote: \"239.255.145.50:14550\""},
      {"mcast::14560", kPlain, "udp, local: \"0.0.0.0:14560\", remote: \"239.255.145.50:14560\""},
      {"mcast:239.1.2.3", kPlain, "udp, local: \"0.0.0.0:14550\", remote: \"239.1.2.3:14550\""},
      {"mcast:[ff02::7]:14560", kOut, "udp, local: \"[::]:14560\", remote: \"[ff02::7]:14560\""},
      // mavlink-router
      {"192.168.1.2", kOut, "udp, remote: \"192.168.1.2:14550\""},
      {"[::1]", kOut, "udp, remote: \"[::1]:14550\""},
      {"/dev/ttyS1:1500000", kPlain,
       "serial, device: \"/dev/ttyS1\", unknown_messages: pass, baud: 1500000"},
      {"/dev/ttyS1:57600,115200", kPlain,
       "serial, device: \"/dev/ttyS1\", unknown_messages: pass, baud: [57600, 115200]"},
      {"serial:/dev/ttyS1,57600,115200,921600", kMaster,
       "serial, device: \"/dev/ttyS1\", unknown_messages: pass, baud: [57600, 115200, 921600]"},
      {"0.0.0.0:24550", kPlain, "udp_server, local: \"0.0.0.0:24550\""},
      // MAVSDK
      {"udp://:14540", kPlain, "udp_server, local: \"127.0.0.1:14540\""},
      {"serial:///dev/ttyUSB0:57600", kPlain,
       "serial, device: \"/dev/ttyUSB0\", unknown_messages: pass, baud: 57600"},
      {"serial_flowcontrol:///dev/ttyUSB0:57600", kPlain,
       "serial, device: \"/dev/ttyUSB0\", unknown_messages: pass, baud: 57600, flow_control: true"},
      // short
      {"udp:14550", kPlain, "udp_server, local: \"127.0.0.1:14550\""},
      {"tcp:5760", kPlain, "tcp_server, local: \"127.0.0.1:5760\""},
      {"udp:[::1]:14550", kPlain, "udp, remote: \"[::1]:14550\""},
      {"udp:[::]:14550", kPlain, "udp_server, local: \"[::]:14550\""},
      {"serial:/dev/ttyACM0:0", kPlain, "serial, device: \"/dev/ttyACM0\", unknown_messages: pass"},
      {"/dev/ttyACM0", kPlain, "serial, device: \"/dev/ttyACM0\", unknown_messages: pass"},
      {"serial:/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0", kPlain,
       "serial, device: \"/dev/serial/by-path/pci-0000:00:14.0-usb-0:1:1.0\", "
       "unknown_messages: pass"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.text);
    LinkConfig link = parse_endpoint(row.text, row.use);
    link.name = "l";
    EXPECT_EQ(link_entry(link), "- {name: \"l\", type: " + row.entry + "}");
  }
}

TEST(EndpointNotation, RefusesWhatIsNoPlace) {
  for (const char* text : {"udp:host",
                           "udp:",
                           "tcp:127.0.0.1:99999",
                           "udp:65536",
                           "udp:127.0.0.1:0",
                           "serial:",
                           "udpout:14550",
                           "/dev/ttyACM0,fast",
                           "nonsense",
                           "tcp:[::1:5760",
                           "udp:::1:14550",
                           "udp:1:2:14550",
                           "udpout:[1:2]:14550",
                           "udo:14550",
                           "mcast:1.2.3.4:14550",
                           "mcast:[fe80::1]",
                           "udp://:14540@127.0.0.1:14557",
                           "/dev/ttyS1:57600:115200",
                           "/dev/ttyS1,,57600",
                           "/dev/ttyS1:",
                           "/dev/ttyS1:,57600",
                           "/dev/ttyS1:100,57600",
                           "/dev/ttyS1:57600 ,115200",
                           "/dev/ttyS1:99999999999",
                           "serial:/dev/ttyS0:57600:8N1",
                           "/dev/ttyS1:57600,57600",
                           "serial:///dev/ttyACM0:57600?ids=1,240",
                           "udp://:14540@",
                           "tcp-l://:5760",
                           "/dev/ttyS1:abc",
                           "UDP:14550",
                           "ttyS1:57600"}) {
    EXPECT_THROW(parse_endpoint(text), base::ConfigError) << text;
  }
}

TEST(EndpointNotation, HostsWithoutAPortGetTheNextOneThatIsFree) {
  std::vector<LinkConfig> links{parse_endpoint("udp:h:14550"), parse_endpoint("udp:14551")};
  const auto next = [&](const std::string& host) {
    links.push_back(parse_endpoint(host, EndpointUse::kOut, links));
    return links.back().remote;
  };
  EXPECT_EQ(next("h"), "h:14551") << "a server of this machine's takes no port of h";
  links.push_back(parse_endpoint("udp:14550"));
  EXPECT_EQ(next("127.0.0.1"), "127.0.0.1:14552") << "casd would send to itself";
  EXPECT_EQ(next("h"), "h:14552");
  EXPECT_EQ(next("other"), "other:14550");
  for (const char* text : {"14550", "a/b", "::1"}) {
    EXPECT_THROW(parse_endpoint(text, EndpointUse::kOut), base::ConfigError) << text;
  }
}

TEST(EndpointNotation, TopologyRecordsWhereItIsTold) {
  const std::vector<LinkConfig> links{parse_endpoint("udp:14550")};
  const auto parsed = [&](const EndpointLog& log) {
    return Topology::parse(
        base::ConfigNode::parse(topology_of_endpoints(links, {.command_port = 0, .log = log})));
  };
  EXPECT_FALSE(parsed({}).log.autopilot);
  const Topology logs = parsed({.folder = "/var/log/a: b"});
  EXPECT_EQ(logs.log.folder, "/var/log/a: b");
  EXPECT_TRUE(logs.log.autopilot);
  EXPECT_TRUE(logs.log.tlog.empty());
  EXPECT_EQ(parsed({.folder = "/x", .telemetry = true}).log.tlog, "flight");
}

TEST(EndpointNotation, TellsEndpointsFromFiles) {
  for (const char* text : {"udp:14550", "serial:/dev/ttyACM0", "/dev/ttyACM0", "127.0.0.1:14550"}) {
    EXPECT_TRUE(is_endpoint(text)) << text;
  }
  for (const char* text : {"bench.yaml", "topologies/bench_pty.yaml", "/etc/cas/topology.yaml",
                           "configs/lab:3", "/dev/stdin", "/dev/fd/63"}) {
    EXPECT_FALSE(is_endpoint(text)) << text;
  }
}

TEST(EndpointNotation, TopologyCarriesEverythingButASimulatorsSensors) {
  const std::string text = topology_of_endpoints(
      {parse_endpoint("/dev/ttyACM0"), parse_endpoint("udp:14550"), parse_endpoint("udp:h:1")},
      {.command_port = 0, .silent = true});
  const Topology topology = Topology::parse(base::ConfigNode::parse(text));
  ASSERT_EQ(topology.links.size(), 3U);
  EXPECT_EQ(topology.links[0].name, "serial");
  EXPECT_EQ(topology.links[1].name, "udp");
  EXPECT_EQ(topology.links[2].name, "udp2");
  ASSERT_EQ(topology.routes.size(), 7U);
  EXPECT_EQ(topology.routes[6].from, "udp") << "the peers of a server hear each other";
  EXPECT_EQ(topology.routes[6].to, "udp");
  EXPECT_EQ(topology.command_port.port, 0);
  EXPECT_TRUE(injection_warnings(topology).empty());
  EXPECT_EQ(topology.commanding.heartbeat_hz, 0);
  EXPECT_FALSE(topology.commanding.ask_on_sight);
}

TEST(EndpointNotation, UartsHaveARateAndUsbHasNone) {
  for (const char* device :
       {"/dev/ttyS1", "/dev/ttyAMA0", "/dev/ttyUSB0", "/dev/ttyHS1", "/dev/serial0"}) {
    EXPECT_EQ(usual_baud(device), 115'200U) << device;
  }
  for (const char* device : {"/dev/ttyACM0", "/dev/serial/by-id/usb-x", "/dev/pts/3", "/tmp/fc",
                             "/dev/serial_fcu", "/dev/ttySLOW", "/dev/ttyUSB_px4"}) {
    EXPECT_EQ(usual_baud(device), 0U) << device;
  }
}

}  // namespace
}  // namespace cas::casd
