// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/router_import.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "base/config/config.hpp"
#include "base/error.hpp"
#include "casd/topology/topology.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::casd {
namespace {

constexpr const char* kConf = R"([General]
# a comment
TcpServerPort = 5790
ReportStats = false
Log = /var/log/flight-stack
LogTelemetry = true
LogMode = while-armed
MinFreeSpace = 1073741824
MaxLogFiles = 20

[UartEndpoint autopilot]
Device = /dev/ttyS1
Baud = 1500000, 115200
FlowControl = true
Group = wing

[UdpEndpoint station]
Mode = Normal
Address = 127.0.0.1
Port = 14560
AllowMsgIdOut = 0,30
BlockSrcSysIn = 1

[udpendpoint Mission Planner]
mode = server
address = 0.0.0.0
port = 14550
BlockMsgIdIn = 76
AllowSrcCompOut = 1

[TcpEndpoint peer]
Address = 10.0.0.1
Port = 5760
RetryTimeout = 5
)";

ImportedTopology import_text(const std::string& text, const std::string& file) {
  return import_mavlink_router({{file, text}});
}

Topology parsed(const ImportedTopology& imported) {
  return Topology::parse(base::ConfigNode::parse(imported.yaml, "t.yaml"));
}

const RouteConfig& route(const Topology& topology, const std::string& from, const std::string& to) {
  const auto found =
      std::find_if(topology.routes.begin(), topology.routes.end(),
                   [&](const RouteConfig& each) { return each.from == from && each.to == to; });
  if (found == topology.routes.end()) throw std::runtime_error("no route " + from + " -> " + to);
  return *found;
}

TEST(RouterImport, KeepsEndpointsAndFilters) {
  const Topology topology = parsed(import_text(kConf, "main.conf"));
  ASSERT_EQ(topology.links.size(), 5U);
  EXPECT_EQ(topology.links[0].device, "/dev/ttyS1");
  EXPECT_EQ(topology.links[0].baud, (std::vector<unsigned>{1'500'000, 115'200}));
  EXPECT_TRUE(topology.links[0].flow_control);
  EXPECT_EQ(topology.links[0].group, "wing");
  EXPECT_EQ(topology.links[1].remote, "127.0.0.1:14560");
  EXPECT_EQ(topology.links[1].accept.block_systems, std::vector<std::uint8_t>{1});
  EXPECT_EQ(topology.links[2].name, "Mission_Planner");
  EXPECT_EQ(topology.links[2].type, LinkType::kUdpServer);
  EXPECT_EQ(topology.links[2].local, "0.0.0.0:14550");
  EXPECT_EQ(topology.links[3].remote, "10.0.0.1:5760");
  EXPECT_EQ(topology.links[4].local, "0.0.0.0:5790");
  EXPECT_EQ(topology.command_port.port, 5791) << "casd's usual one is taken";

  EXPECT_TRUE(topology.links[0].pass_unknown);
  for (const LinkConfig& link : topology.links) {
    EXPECT_EQ(link.to_not_hil, ToNotHil::kAll) << link.name << " may be a person's station";
  }

  // Clients of the TCP server hear each other.
  EXPECT_EQ(topology.routes.size(), 21U);
  EXPECT_EQ(route(topology, "tcp", "tcp").from, "tcp");
  const ForwardRule& thinned = route(topology, "autopilot", "station").rule;
  ASSERT_TRUE(thinned.allow);
  EXPECT_EQ(*thinned.allow, (std::vector<std::uint32_t>{0, 30}));
  const ForwardRule& planner = route(topology, "Mission_Planner", "autopilot").rule;
  EXPECT_NE(std::find(planner.block.begin(), planner.block.end(), 76U), planner.block.end());
  EXPECT_NE(std::find(planner.block.begin(), planner.block.end(), 107U), planner.block.end());
  EXPECT_EQ(route(topology, "peer", "Mission_Planner").rule.allow_components,
            std::vector<std::uint8_t>{1});
  EXPECT_TRUE(topology.log.while_armed);
  EXPECT_EQ(topology.log.folder, "/var/log/flight-stack");
  EXPECT_EQ(topology.log.keep.free_space_min_bytes, 1U << 30U);
  EXPECT_TRUE(topology.log.keep.delete_oldest);
  EXPECT_EQ(topology.log.keep.max_files, 20);
  EXPECT_EQ(topology.log.keep.max_bytes, 0U) << "would delete below 4 GiB";
  ASSERT_TRUE(topology.log.autopilot);
  EXPECT_TRUE(topology.log.autopilot->while_armed);
  EXPECT_EQ(topology.duplicate_window, base::Duration::zero());
}

TEST(RouterImport, TakesAByteOrderMarkAndEndsOfLinesOfWindows) {
  std::string text = "\xef\xbb\xbf";
  for (const char* c = kConf; *c != '\0'; ++c)
    text += *c == '\n' ? std::string("\r\n") : std::string(1, *c);
  EXPECT_EQ(import_text(text, "main.conf").yaml, import_text(kConf, "main.conf").yaml);
}

TEST(RouterImport, KeepsTheTimeInWhichDuplicatesAreDropped) {
  const std::string rest = "[UartEndpoint a]\nDevice=/dev/a\n";
  EXPECT_EQ(
      parsed(import_text("[General]\nDeduplicationPeriod = 250\n" + rest, "f")).duplicate_window,
      std::chrono::milliseconds(250));
  EXPECT_THROW(import_text("[General]\nDeduplicationPeriod = 60001\n" + rest, "f"),
               base::ConfigError);
}

TEST(RouterImport, SaysWhatBecameOfEachKeyThatCasdHasNot) {
  const ImportedTopology imported = import_text(kConf, "main.conf");
  const auto told = [&](const std::string& begin) {
    return std::any_of(imported.notes.begin(), imported.notes.end(),
                       [&](const std::string& note) { return note.starts_with(begin); });
  };
  EXPECT_TRUE(told("main.conf:4: ReportStats:")) << imported.yaml;
  EXPECT_TRUE(told("main.conf:9: MaxLogFiles:"));
  EXPECT_TRUE(told("main.conf:34: RetryTimeout: casd tries again"));
  EXPECT_EQ(imported.notes.size(), 3U);
  for (const std::string& note : imported.notes) {
    EXPECT_NE(imported.yaml.find("# " + note), std::string::npos);
  }
}

TEST(RouterImport, TwoListsWithoutACommonComponentLetNothingThrough) {
  const Topology topology = parsed(
      import_text("[General]\nTcpServerPort=0\n"
                  "[UartEndpoint a]\nDevice=/dev/a\nAllowSrcCompIn=1,2\n"
                  "[UdpEndpoint b]\nMode=server\nAddress=::1\nPort=14550\nAllowSrcCompOut=3\n",
                  "f"));
  EXPECT_EQ(topology.links[1].local, "[::1]:14550");
  const ForwardRule& rule = route(topology, "a", "b").rule;
  ASSERT_TRUE(rule.allow);
  EXPECT_TRUE(rule.allow->empty());
  EXPECT_FALSE(route(topology, "b", "a").rule.allow);
}

TEST(RouterImport, ASectionThatComesAgainGoesOn) {
  const Topology topology =
      parsed(import_text("[General]\nTcpServerPort=0\n[UartEndpoint a]\nDevice=/dev/a\n"
                         "[general]\nReportStats=true\n[uartendpoint A]\nBaud=9600\n",
                         "f"));
  ASSERT_EQ(topology.links.size(), 1U);
  EXPECT_EQ(topology.links[0].baud, std::vector<unsigned>{9600});
}

TEST(RouterImport, ClientsWithoutAPortCountUp) {
  const Topology topology =
      parsed(import_text("[General]\nTcpServerPort=0\n[UdpEndpoint a]\nMode=Normal\nAddress=h\n"
                         "[UdpEndpoint b]\nMode=Normal\nAddress=h\n",
                         "f"));
  EXPECT_EQ(topology.links[0].remote, "h:14550");
  EXPECT_EQ(topology.links[1].remote, "h:14551");
}

TEST(RouterImport, ClientsWithoutAPortKeepClearOfTheOnesThatHaveOne) {
  const Topology topology =
      parsed(import_text("[General]\nTcpServerPort=0\n"
                         "[UdpEndpoint a]\nMode=Normal\nAddress=h\nPort=14550\n"
                         "[UdpEndpoint b]\nMode=Normal\nAddress=h\n"
                         "[UdpEndpoint c]\nMode=Server\nAddress=h\nPort=14552\n"
                         "[UdpEndpoint d]\nMode=Normal\nAddress=h\n"
                         "[UdpEndpoint e]\nMode=Normal\nAddress=::1\n",
                         "f"));
  EXPECT_EQ(topology.links[1].remote, "h:14551");
  EXPECT_EQ(topology.links[3].remote, "h:14553");
  EXPECT_EQ(topology.links[4].remote, "[::1]:14550");
}

TEST(RouterImport, ClientsWithoutAPortDoNotSendToAServerOfTheFile) {
  const Topology topology =
      parsed(import_text("[General]\nTcpServerPort=0\n"
                         "[UdpEndpoint a]\nMode=Server\nAddress=0.0.0.0\nPort=14550\n"
                         "[UdpEndpoint b]\nMode=Normal\nAddress=127.0.0.1\n",
                         "f"));
  EXPECT_EQ(topology.links[1].remote, "127.0.0.1:14551");
}

TEST(RouterImport, SaysThatItConnectsAgainWhereMavlinkRouterWouldNot) {
  for (const char* never : {"0", "-1"}) {
    const ImportedTopology imported = import_text(
        "[TcpEndpoint a]\nAddress=h\nPort=1\nRetryTimeout=" + std::string(never) + "\n", "f");
    EXPECT_EQ(imported.notes,
              std::vector<std::string>{
                  "f:4: RetryTimeout: casd connects again, where mavlink-router would not"});
  }
}

TEST(RouterImport, RefusesWhatWouldLoseALinkOrALog) {
  const auto refusal = [](const std::string& text) {
    return cas::test::refusal([&] { import_text(text, "f"); });
  };
  const std::string uart = "[UartEndpoint a]\nDevice=/dev/a\n";
  EXPECT_EQ(refusal(uart + "[UartEndpont b]\nDevice=/dev/b\n"),
            "f:3: [uartendpont] is no section; did you mean [uartendpoint]?");
  EXPECT_EQ(refusal("[General]\nLog=/x\nLogMode=armed\n" + uart),
            "f:3: LogMode: is always or while-armed");
}

TEST(RouterImport, NotesComeInTheOrderOfTheLines) {
  const ImportedTopology imported = import_text(
      "[General]\nReportStats=true\n[TcpEndpoint a]\nAddress=h\nPort=1\nRetryTimeout=0\n"
      "[UdpEndpoint b]\nMode=Normal\nAddress=h\nOdd=1\n",
      "f");
  ASSERT_EQ(imported.notes.size(), 3U);
  EXPECT_TRUE(imported.notes[0].starts_with("f:2: ReportStats")) << imported.notes[0];
  EXPECT_TRUE(imported.notes[1].starts_with("f:6: RetryTimeout")) << imported.notes[1];
  EXPECT_TRUE(imported.notes[2].starts_with("f:10: Odd")) << imported.notes[2];
}

TEST(RouterImport, SaysThatNothingIsRecordedWithoutAFolder) {
  const ImportedTopology imported =
      import_text("[General]\nLogMode=always\n[UartEndpoint a]\nDevice=/dev/a\n", "f");
  EXPECT_EQ(imported.notes,
            std::vector<std::string>{"f:2: LogMode: nothing is recorded without Log"});
}

/// A key of mavlink-router's configuration with a value that is not its default.
struct RouterKey {
  std::string section;
  std::string key;
  std::string value;
  std::string others;  ///< lines that it needs beside it

  std::string name() const { return section + key; }
};

std::vector<RouterKey> router_keys() {
  const std::string log = "Log=/var/log/x\n";
  std::vector<RouterKey> keys{{"General", "TcpServerPort", "5790", ""},
                              {"General", "ReportStats", "true", ""},
                              {"General", "DebugLogLevel", "debug", ""},
                              {"General", "DeduplicationPeriod", "100", ""},
                              {"General", "SnifferSysid", "250", ""},
                              {"General", "Log", "/var/log/x", ""},
                              {"General", "LogMode", "while-armed", log},
                              {"General", "MavlinkDialect", "common", log},
                              {"General", "MinFreeSpace", "1000000", log},
                              {"General", "MaxLogFiles", "20", log},
                              {"General", "LogSystemId", "1", log},
                              {"General", "LogTelemetry", "true", log},
                              {"UartEndpoint", "Device", "/dev/b", ""},
                              {"UartEndpoint", "Baud", "9600", "Device=/dev/b\n"},
                              {"UartEndpoint", "FlowControl", "true", "Device=/dev/b\n"},
                              {"UdpEndpoint", "Address", "10.0.0.1", "Mode=Normal\n"},
                              {"UdpEndpoint", "Mode", "Server", "Address=10.0.0.1\nPort=14555\n"},
                              {"UdpEndpoint", "Port", "14555", "Address=10.0.0.1\nMode=Normal\n"},
                              {"UdpEndpoint", "Filter", "0,30", "Address=10.0.0.1\nMode=Normal\n"},
                              {"TcpEndpoint", "Address", "10.0.0.1", "Port=1\n"},
                              {"TcpEndpoint", "Port", "5761", "Address=10.0.0.1\n"},
                              {"TcpEndpoint", "RetryTimeout", "7", "Address=10.0.0.1\nPort=1\n"}};
  const std::vector<std::pair<std::string, std::string>> sections{
      {"UartEndpoint", "Device=/dev/b\n"},
      {"UdpEndpoint", "Address=10.0.0.1\nMode=Normal\n"},
      {"TcpEndpoint", "Address=10.0.0.1\nPort=1\n"}};
  for (const auto& [section, others] : sections) {
    for (const char* key : {"AllowMsgIdOut", "BlockMsgIdOut", "AllowSrcCompOut", "BlockSrcCompOut",
                            "AllowSrcSysOut", "BlockSrcSysOut", "AllowMsgIdIn", "BlockMsgIdIn",
                            "AllowSrcCompIn", "BlockSrcCompIn", "AllowSrcSysIn", "BlockSrcSysIn"}) {
      keys.push_back({section, key, "3", others});
    }
    keys.push_back({section, "Group", "wing", others});
  }
  return keys;
}

class RouterImportKeys : public testing::TestWithParam<RouterKey> {};

TEST_P(RouterImportKeys, AreTakenOrExplained) {
  const RouterKey& each = GetParam();
  const std::string head = each.section == "General" ? "[General]\n" : "[" + each.section + " x]\n";
  const auto import_with = [&](const std::string& line) {
    return import_text("[UartEndpoint first]\nDevice=/dev/a\n" + head + each.others + line, "f");
  };
  const auto is_told = [&](const ImportedTopology& imported) {
    return std::ranges::any_of(imported.notes, [&](const std::string& note) {
      return note.find(": " + each.key + ": ") != note.npos;
    });
  };
  const ImportedTopology with = import_with(each.key + "=" + each.value + "\n");
  EXPECT_EQ(std::ranges::count_if(
                with.notes, [](const std::string& note) { return note.ends_with("is unknown"); }),
            0)
      << with.yaml;
  if (is_told(with)) return;
  try {
    EXPECT_NE(with.yaml, import_with("").yaml);
  } catch (const base::ConfigError&) {
    // A key without which there is no endpoint.
    const std::map<std::string, std::string> other{
        {"Mode", "Normal"}, {"Port", "5762"}, {"Address", "10.0.0.2"}, {"Device", "/dev/c"}};
    EXPECT_NE(with.yaml, import_with(each.key + "=" + other.at(each.key) + "\n").yaml);
  }
}

TEST_P(RouterImportKeys, AreOnThePageAboutEndpoints) {
  const std::string page =
      cas::test::TemporaryFolder::read(cas::test::source_dir() + "/docs/reference/endpoints.md");
  EXPECT_TRUE(std::regex_search(page, std::regex("`" + GetParam().key + "\\b"))) << GetParam().key;
}

INSTANTIATE_TEST_SUITE_P(EveryOne, RouterImportKeys, testing::ValuesIn(router_keys()),
                         [](const auto& test) { return test.param.name(); });

TEST(RouterImport, WhatTheFileHoldsGivesNoTerminalOrders) {
  const ImportedTopology imported =
      import_text("[UartEndpoint a]\nDevice=/dev/a\nOdd\x1b[2J\rkey=1\n", "f");
  ASSERT_EQ(imported.notes.size(), 1U);
  EXPECT_EQ(imported.notes[0], "f:3: Odd?[2J?key: is unknown");
}

TEST(RouterImport, HasTheTcpServerUnlessItIsTurnedOff) {
  const std::string one = "[UartEndpoint a]\nDevice=/dev/a\n";
  EXPECT_EQ(parsed(import_text(one, "f")).links.back().local, "0.0.0.0:5760");
  EXPECT_EQ(parsed(import_text("[General]\nTcpServerPort=0\n" + one, "f")).links.size(), 1U);
}

TEST(RouterImport, LaterFilesOverrideKeysAndAddEndpoints) {
  const ImportedTopology imported = import_mavlink_router(
      {{"main.conf", "[General]\nTcpServerPort=0\n[UartEndpoint a]\nDevice=/dev/a\nBaud=9600\n"},
       {"config.d/1.conf", "[uartendpoint A]\nBaud=57600\nOdd=1\n"},
       {"config.d/2.conf", "[UdpEndpoint b]\nMode=Normal\nAddress=h\nPort=1\n"}});
  const Topology topology = parsed(imported);
  ASSERT_EQ(topology.links.size(), 2U);
  EXPECT_EQ(topology.links[0].device, "/dev/a");
  EXPECT_EQ(topology.links[0].baud, std::vector<unsigned>{57'600});
  EXPECT_EQ(topology.links[1].remote, "h:1");
  EXPECT_EQ(imported.notes, std::vector<std::string>{"config.d/1.conf:3: Odd: is unknown"});
  EXPECT_NE(imported.yaml.find("# From main.conf 1.conf 2.conf of"), std::string::npos);
  EXPECT_EQ(
      cas::test::refusal([] {
        import_mavlink_router({{"main.conf", "[General]\n"}, {"config.d/1.conf", "Baud=1\n"}});
      }),
      "config.d/1.conf:1: a key stands before the first section")
      << "a key of the second file belongs to no section of the first";
}

TEST(RouterImport, TheEndpointOfTheSnifferAloneIsALinkThatSniffs) {
  const std::string conf =
      "[General]\nTcpServerPort=0\nSnifferSysid=250\n[UartEndpoint a]\nDevice=/dev/a\n"
      "[UdpEndpoint b]\nMode=Server\nAddress=127.0.0.1\nPort=14600\n";
  const Topology topology = parsed(import_text(conf + "AllowSrcSysIn=250\n", "f"));
  EXPECT_TRUE(topology.links[1].sniffer);
  EXPECT_TRUE(topology.routes.empty());

  const ImportedTopology filtered =
      import_text(conf + "AllowSrcSysIn=250\nBlockMsgIdOut=30\nGroup=g\n", "f");
  EXPECT_TRUE(parsed(filtered).links[1].sniffer);
  EXPECT_EQ(std::vector(filtered.notes.begin() + 1, filtered.notes.end()),
            (std::vector<std::string>{"f:11: BlockMsgIdOut: has no effect at a sniffer",
                                      "f:12: Group: has no effect at a sniffer"}));

  const ImportedTopology unknown = import_text(conf, "f");
  EXPECT_FALSE(parsed(unknown).links[1].sniffer);
  ASSERT_EQ(unknown.notes.size(), 1U);
  EXPECT_TRUE(unknown.notes[0].starts_with("f:3: SnifferSysid: in casd a sniffer is a link"))
      << unknown.notes[0];
}

TEST(BrokenConf, IsRefusedAtItsLine) {
  struct Broken {
    std::string text;
    std::string sentence;
  };
  const Broken rows[] = {
      {"Device=/dev/a\n", "1: a key stands before the first section"},
      {"[General\n", "1: a section ends with ]"},
      {"[General]\nnonsense\n", "2: is neither [section] nor key = value"},
      {"\n[UartEndpoint a]\nBaud=9600\n", "2: endpoint 'a' has no Device"},
      {"[UartEndpoint a]\nDevice=/dev/a\nBaud=fast\n", "3: Baud: 'fast' is not a number"},
      {"[UdpEndpoint a]\nAddress=h\nMode=server\n", "1: endpoint 'a' has no Port"},
      {"[UartEndpoint a]\nDevice=/dev/a\nFlowControl=ture\n", "3: FlowControl: is true or false"},
      {"[TcpEndpoint a]\nAddress=h\nPort=99999\n", "3: Port: is more than 65535"},
      {"[UartEndpoint a]\nDevice=/dev/a\nAllowSrcSysIn=300\n",
       "3: AllowSrcSysIn: is more than 255"},
      {"[UdpEndpoint a]\nAddress=h\nMode=odd\n",
       "3: Mode: is normal, client, server or eavesdropping"},
      {"[UdpEndpoint a]\nMode=normal\nAddress=1.2.3.4 # the radio\nPort=1\n",
       "3: Address: '1.2.3.4 # the radio' is not a host"},
      {"[UdpEndpoint a]\nMode=normal\nAddress=h\nPort=0\n", "4: Port: of a peer is 1 to 65535"},
      {"[TcpEndpoint a]\nAddress=h\nPort=0\n", "3: Port: of a peer is 1 to 65535"},
      {"[TcpEndpoint a]\nAddress=127.0.0.1\nPort=5760\n",
       "1: endpoint 'a' meets 0.0.0.0:5760, where TCP clients are served "
       "(TcpServerPort=0: none are)"},
      {"[UartEndpoint a]\nDevice=/dev/a\n[UartEndpoint b]\nDevice=/dev/a\n",
       "3: endpoint 'b': link 'a' has the device /dev/a already"},
      {"[General]\nTcpServerPort=0\n", "1: has no endpoint"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.text);
    EXPECT_EQ(cas::test::refusal([&] { import_text(row.text, "main.conf"); }),
              "main.conf:" + row.sentence);
  }
}

TEST(RouterImport, SaysThatTwoEndpointsLeadToOnePlace) {
  const ImportedTopology twice = import_text(
      "[General]\nTcpServerPort=0\n[UdpEndpoint a]\nMode=Normal\nAddress=h\nPort=1\n"
      "[UdpEndpoint b]\nMode=Normal\nAddress=h\nPort=1\n",
      "f");
  EXPECT_EQ(twice.notes,
            std::vector<std::string>{"f:7: endpoint 'b' sends to h:1, as 'a' does: each packet "
                                     "arrives there twice"});
}

}  // namespace
}  // namespace cas::casd
