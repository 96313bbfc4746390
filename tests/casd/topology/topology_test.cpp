// SPDX-License-Identifier: BSD-3-Clause
#include "casd/topology/topology.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "casd/topology/line_budget.hpp"
#include "casd/topology/routing_plan.hpp"
#include "casd/topology/topology_text.hpp"
#include "mavlink_gen/runtime/public_table.hpp"
#include "tests/casd/packets.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::casd::test {
namespace {

const std::string kLinks = R"(schema: 1
links:
  - {name: sim, type: udp, local: 127.0.0.1:14561, remote: 127.0.0.1:14560}
  - {name: fcu, type: serial, device: /dev/ttyACM0, baud: 921600}
  - {name: gcs, type: udp_server, local: "0.0.0.0:14551", max_peers: 16, expiry_s: 10}
)";

Topology parse(const std::string& yaml) {
  return Topology::parse(base::ConfigNode::parse(yaml, "t.yaml"));
}

TEST(Topology, ReadsLinksRoutesAndTheRest) {
  const Topology topology = parse(kLinks + R"(
system_id: 250
component_id: 191
threads: single
cpu_dma_latency_us: 20
command_port: {port: 0, unix: /tmp/casd.sock}
commanding: {heartbeat_hz: 2, allow_not_hil: true}
routes:
  - {from: sim, to: fcu, allow: [HEARTBEAT, HIL_SENSOR, 113]}
  - {from: fcu, to: [sim, gcs], block: HIL_GPS, rates: {ATTITUDE: 10, HIL_SENSOR: {every: 4}}}
)");
  EXPECT_EQ(topology.self, (mav::Source{250, 191}));
  EXPECT_EQ(topology.threads, ThreadModel::kSingle);
  EXPECT_EQ(topology.cpu_dma_latency_us, 20);
  EXPECT_EQ(topology.command_port.port, 0);
  EXPECT_EQ(topology.command_port.unix_path, "/tmp/casd.sock");
  EXPECT_TRUE(topology.commanding.allow_not_hil);
  ASSERT_EQ(topology.links.size(), 3U);
  EXPECT_EQ(topology.links[0].remote, "127.0.0.1:14560");
  EXPECT_EQ(topology.links[1].baud, std::vector<unsigned>{921600});
  EXPECT_TRUE(topology.links[1].pace);
  EXPECT_FALSE(topology.links[1].pass_unknown);
  EXPECT_TRUE(topology.links[0].pass_unknown);
  EXPECT_EQ(topology.links[2].max_peers, 16);
  EXPECT_EQ(topology.links[2].expiry, std::chrono::seconds(10));
  ASSERT_EQ(topology.routes.size(), 3U);
  EXPECT_EQ(topology.routes[0].rule.allow, (std::vector<std::uint32_t>{0, 107, 113}));
  EXPECT_EQ(topology.routes[1].to, "sim");
  EXPECT_EQ(topology.routes[2].to, "gcs");
  EXPECT_EQ(topology.routes[2].rule.rates[0].max_hz, 10);
  EXPECT_EQ(topology.routes[2].rule.rates[1].every, 4U);
}

TEST(Topology, WithoutRoutesEveryLinkTalksToEveryOther) {
  EXPECT_EQ(parse(kLinks).routes.size(), 6U);
}

TEST(Topology, PlanFollowsTheRoutesAndLetsTheStationHearAllButHil) {
  const Topology topology = parse(kLinks + R"(
routes:
  - {from: sim, to: fcu, allow: [HIL_SENSOR]}
  - {from: fcu, to: gcs}
)");
  const auto plan = make_plan(topology, slots_in_order(topology));
  const ForwardTable& from_sim = plan->rules.from(0);
  EXPECT_EQ(from_sim.destinations(107, {1, 1}), bit(1));
  EXPECT_EQ(from_sim.destinations(0, {1, 1}), bit(kLocalLink));
  EXPECT_EQ(plan->rules.from(1).destinations(91, {1, 1}), bit(2));
  EXPECT_EQ(plan->rules.from(1).destinations(30, {1, 1}), bit(2) | bit(kLocalLink));
  EXPECT_EQ(plan->rules.from(kLocalLink).destinations(76, {254, 190}), bit(0) | bit(1) | bit(2));
}

TEST(Topology, GroupMembersNeverHearEachOther) {
  const Topology topology = parse(R"(schema: 1
links:
  - {name: a, type: udp, local: "[::1]:1", group: radio}
  - {name: b, type: udp, local: "[::1]:2", group: radio}
  - {name: c, type: udp, local: "[::1]:3"}
)");
  const auto plan = make_plan(topology, slots_in_order(topology));
  EXPECT_EQ(plan->never_back[0], bit(0) | bit(1));
  EXPECT_EQ(plan->never_back[1], bit(0) | bit(1));
  EXPECT_EQ(plan->never_back[2], bit(2));
  EXPECT_EQ(plan->group[0], plan->group[1]);
  EXPECT_EQ(plan->group[2], -1);
}

TEST(Topology, ReadsWhatGuardsALink) {
  const cas::test::TemporaryFolder folder;
  const auto dialect = folder.write("lab.xml", "");
  const Topology topology = parse("dialect: " + dialect.string() + R"(
schema: 1
metrics: {}
log: {folder: d, tlog: f.tlog, rotate_mib: 2, keep: {max_files: 5, max_mib: 10}, while_armed: true}
links:
  - {name: a, type: udp, local: "[::1]:1", accept: {messages: [HEARTBEAT, 4242], systems: 1}}
  - {name: b, type: udp, local: "[::1]:2", signing: {key_file: k, link_id: 9, sign: false}}
  - {name: c, type: tlog, file: old.tlog, speed: 2}
)");
  EXPECT_EQ(topology.links[0].accept.messages, (std::vector<std::uint32_t>{0, 4242}));
  EXPECT_EQ(topology.links[0].accept.systems, (std::vector<std::uint8_t>{1}));
  ASSERT_TRUE(topology.links[1].signing);
  EXPECT_EQ(topology.links[1].signing->link_id, 9);
  EXPECT_FALSE(topology.links[1].signing->sign);
  EXPECT_EQ(topology.links[2].speed, 2);
  EXPECT_EQ(topology.dialect, dialect);
  EXPECT_EQ(topology.log.rotation.max_bytes, 2U * 1024 * 1024);
  EXPECT_EQ(topology.log.folder, "d");
  EXPECT_EQ(topology.log.keep.max_bytes, 10U * 1024 * 1024);
  EXPECT_EQ(topology.log.keep.max_files, 5);
  EXPECT_EQ(topology.log.keep.free_space_min_bytes, 64U * 1024 * 1024);
  EXPECT_TRUE(topology.log.keep.delete_oldest);
  EXPECT_TRUE(topology.log.while_armed);
  ASSERT_TRUE(topology.metrics);
  EXPECT_EQ(topology.metrics->port, 9790);
  // All to all, but nothing into a log.
  EXPECT_EQ(topology.routes.size(), 4U);
}

TEST(Topology, RefusesATickWithoutAnyTimeBetweenTwoLooks) {
  const cas::test::TemporaryFolder folder;
  EXPECT_EQ(Topology::load(folder.write("none.yaml", kLinks + "drain_tick_ms: 0\n")).drain_tick,
            base::Duration{});
  EXPECT_THROW(Topology::load(folder.write("tiny.yaml", kLinks + "drain_tick_ms: 1e-6\n")),
               base::ConfigError);
}

TEST(Topology, FindsTheShippedGainsFromAFolderOfOnesOwn) {
  const cas::test::TemporaryFolder folder;
  for (const char* gains : {"gains.yaml", "../gains.yaml"}) {
    const auto file = folder.write("mine.yaml", kLinks + "gains: " + gains + "\n");
    EXPECT_EQ(Topology::load(file).gains.filename(), "gains.yaml") << gains;
  }
}

std::string host_name() {
  std::array<char, 256> name{};
  ::gethostname(name.data(), name.size() - 1);
  return name.data();
}
std::string link(const std::string& keys) { return "schema: 1\nlinks:\n  - {" + keys + "}\n"; }
std::string route(const std::string& keys) { return kLinks + "routes:\n  - {" + keys + "}\n"; }

TEST(BadTopology, IsRefusedWithItsPlaceAndASentence) {
  struct BadCase {
    const char* name;
    std::string yaml;
    const char* says;
  };
  const BadCase rows[] = {
      {"NoSchema", "links: []\n", "schema"},
      {"OtherSchema", "schema: 2\nlinks: []\n", "schema 2"},
      {"NoLink", "schema: 1\nlinks: []\n", "no link"},
      {"UnknownType", link("name: a, type: upd, local: 'h:1'"), "upd"},
      {"KeyOfAnotherType", link("name: a, type: tcp, remote: 'h:1', baud: 9600"), "baud"},
      {"NoPort", link("name: a, type: udp, local: localhost"), "HOST:PORT"},
      {"BadPort", link("name: a, type: udp, local: 'h:70000'"), "70000"},
      {"UdpWithoutEnds", link("name: a, type: udp"), "local"},
      {"PaceWithoutBaud", link("name: a, type: serial, device: d, pace: true"), "pace"},
      {"FractionOfABaud", link("name: a, type: serial, device: d, baud: 57600.5"), "57600.5"},
      {"FractionOfAPeer", link("name: a, type: tcp_server, local: 'h:1', max_peers: 1.7"), "1.7"},
      {"KeepsANumberOfFiles", kLinks + "log: {keep: 5}\n",
       "log.keep: is a block {max_mib, max_files, free_space_min_mib} that holds for all"},
      {"NoUnixPath", kLinks + "command_port: {unix: ''}\n", "`none` means no Unix socket"},
      {"GroupWithoutASocket", kLinks + "command_port: {unix: none, unix_group: cas}\n",
       "has no meaning with `unix: none`"},
      {"FractionOfAPort", kLinks + "command_port: {port: 5790.5}\n", "5790.5"},
      {"SecondName",
       "schema: 1\nlinks:\n  - {name: a, type: udp, local: 'h:1'}\n"
       "  - {name: a, type: udp, local: 'h:2'}\n",
       "another link"},
      {"AcceptOfAnotherWord", link("name: a, type: udp, local: 'h:1', accept: all"), "all"},
      {"AcceptThatNamesNothing", link("name: a, type: udp, local: 'h:1', accept: {}"),
       "neither traffic, messages, systems nor block_systems"},
      {"AcceptOfAnotherTraffic", link("name: a, type: udp, local: 'h:1', accept: {traffic: pilot}"),
       "t.yaml:3: links[0].accept.traffic: 'pilot' is not ground_station"},
      {"DeviceWithAVariableThatIsNotSet",
       link("name: a, type: serial, device: '${CAS_NO_SUCH_VARIABLE}/fcu0'"),
       "t.yaml:3: links[0].device: environment variable CAS_NO_SUCH_VARIABLE is not set"},
      {"DeviceWithHalfAVariable", link("name: a, type: serial, device: '${CAS_NO_SUCH_VARIABLE'"),
       "no closing brace"},
      {"UnlockedSocket", link("name: a, type: udp, local: 'h:1', unlocked_pty: true"),
       "unlocked_pty"},
      {"SigningWithoutKey", link("name: a, type: udp, local: 'h:1', signing: {link_id: 1}"),
       "key_file"},
      {"SigningThatDoesNothing",
       link("name: a, type: udp, local: 'h:1', signing: {key_file: k, verify: false, sign: false}"),
       "neither verifies nor signs"},
      {"MisspeltKeyOfSigning",
       link("name: a, type: udp, local: 'h:1', signing: {key_file: k, lnk_id: 1}"), "lnk_id"},
      {"UnsignedAllowedButNothingVerified",
       link("name: a, type: udp, local: 'h:1', "
            "signing: {key_file: k, verify: false, allow_unsigned: [RADIO_STATUS]}"),
       "without verify"},
      {"FutureWithoutVerify",
       link("name: a, type: udp, local: 'h:1', "
            "signing: {key_file: k, verify: false, max_future_s: 60}"),
       "max_future_s"},
      {"RecordingByItsPath", kLinks + "log: {tlog: /data/f.tlog}\n",
       "log.tlog: '/data/f.tlog' has a slash; it is a name, and its folder is `folder`"},
      {"RecordingThatIsHidden", kLinks + "log: {tlog: .f}\n", "begins with a dot"},
      {"FlightsInOneFile", kLinks + "log: {overwrite: true, while_armed: true}\n",
       "log.overwrite: each flight"},
      {"NameThatGivesATerminalOrders", link(R"(name: "\e[31mred", type: udp, local: 'h:1')"),
       "letters, digits"},
      {"NameThatLeadsElsewhere", link("name: ../a, type: udp, local: 'h:1'"), "digits"},
      {"LongName", link("name: " + std::string(65, 'a') + ", type: udp, local: 'h:1'"), "up to 64"},
      {"LogWithoutFile", link("name: a, type: tlog"), "file"},
      {"LogThatStandsStill", link("name: a, type: tlog, file: f, speed: 0"), "speed"},
      {"RouteIntoALog",
       kLinks + "  - {name: log, type: tlog, file: f}\nroutes:\n  - {from: sim, to: log}\n",
       "nothing can be sent to 'log'"},
      {"GainsThatAreNowhere", kLinks + "gains: no_gains.yaml\n",
       "t.yaml:6: gains: there is no file 'no_gains.yaml'"},
      {"UnknownLinkInRoute", route("from: sim, to: fuc"),
       "t.yaml:7: routes[0].to: there is no link 'fuc'; links are sim, fcu, gcs"},
      {"LinkNamedTwice", route("from: [any, sim], to: fcu"),
       "t.yaml:7: routes[0].from[1]: link 'sim' is named twice"},
      {"UnknownMessage", route("from: sim, to: fcu, allow: [HIL_SENSR]"),
       "name 'HIL_SENSR'; did you mean HIL_SENSOR?"},
      {"MessageUnlikeAnyOther", route("from: sim, to: fcu, allow: [LABORATORY_THING]"),
       "give its number if it is private"},
      {"MessageIdTooGreat", route("from: sim, to: fcu, allow: [16777216]"), "24 bits"},
      {"RouteBackToItself", route("from: sim, to: sim"), "server"},
      {"RateWithoutEffect", route("from: sim, to: fcu, rates: {ATTITUDE: 0}"), "max_hz"},
      {"SecondRoute", route("from: sim, to: fcu") + "  - {from: any, to: fcu}\n", "another route"},
      {"SystemOutOfRange", route("from: sim, to: fcu, block_systems: [300]"), "300"},
      {"UnknownThreads", kLinks + "threads: many\n", "many"},
      {"SendsToAnotherLink", kLinks + "  - {name: b, type: udp, remote: 'localhost:14551'}\n",
       "t.yaml:6: links[3]: link 'b' sends to localhost:14551, where link 'gcs' listens: "
       "each packet would come back"},
      {"SendsToAnotherLinkByAnyLoopbackAddress",
       kLinks + "  - {name: b, type: udp, remote: '127.0.0.2:14551'}\n",
       "link 'b' sends to 127.0.0.2:14551, where link 'gcs' listens"},
      {"SendsToAnotherLinkByAShortAddress",
       kLinks + "  - {name: b, type: udp, remote: '127.1:14551'}\n",
       "link 'b' sends to 127.1:14551, where link 'gcs' listens"},
      {"SendsToAnotherLinkByANumber",
       kLinks + "  - {name: b, type: udp, remote: '0x7f000001:14551'}\n",
       "where link 'gcs' listens"},
      {"SendsToAnotherLinkByAMappedAddress",
       kLinks + "  - {name: b, type: udp, remote: '[::ffff:127.0.0.1]:14551'}\n",
       "where link 'gcs' listens"},
      {"SendsToAnotherLinkByAnotherNameOfLocalhost",
       kLinks + "  - {name: b, type: udp, remote: 'LOCALHOST.:14551'}\n",
       "where link 'gcs' listens"},
      {"SendsToAnotherLinkByTheNameOfThisMachine",
       kLinks + "  - {name: b, type: udp, remote: '" + host_name() + ":14551'}\n",
       "where link 'gcs' listens"},
      {"SendsToNobody", link("name: a, type: udp, remote: '0.0.0.0:14550'"),
       "0.0.0.0:14550 is no destination: to listen"},
      {"SendsToNobodyByAShortAddress", link("name: a, type: tcp, remote: '0:5760'"),
       "0:5760 is no destination"},
      {"SendsToNobodyByIpV6", link("name: a, type: udp, remote: '[::]:14550'"),
       "[::]:14550 is no destination"},
      {"BroadcastsToAnotherLink",
       kLinks + "  - {name: b, type: udp, remote: '192.168.1.255:14551'}\n",
       "link 'b' sends to 192.168.1.255:14551, where link 'gcs' listens"},
      {"SendsToAGroupThatAnotherLinkHears",
       kLinks + "  - {name: b, type: udp, remote: '239.255.145.50:14551'}\n",
       "link 'b' sends to 239.255.145.50:14551, where link 'gcs' listens"},
      {"IsSentToByAnotherLink",
       kLinks + "  - {name: b, type: udp_server, local: '0.0.0.0:14560'}\n",
       "link 'sim' sends to 127.0.0.1:14560, where link 'b' listens"},
      {"SendsToItself", link("name: a, type: udp, local: '0.0.0.0:1', remote: '127.0.0.1:1'"),
       "link 'a' sends to 127.0.0.1:1, where it listens"},
      {"ConnectsToAnotherLink",
       kLinks + "  - {name: a, type: tcp_server, local: '[::]:5760'}\n"
                "  - {name: b, type: tcp, remote: '[::1]:5760'}\n",
       "link 'b' sends to [::1]:5760, where link 'a' listens"},
      {"ListensWhereAnotherDoes", kLinks + "  - {name: b, type: udp, local: '127.0.0.1:14551'}\n",
       "t.yaml:6: links[3]: link 'gcs' listens at 0.0.0.0:14551 already"},
      {"BroadcastsToAGroupLink",
       link("name: a, type: udp, remote: '192.168.1.255:14550'") +
           "  - {name: b, type: udp, local: '0.0.0.0:14550', remote: '239.255.145.50:14550'}\n",
       "link 'a' sends to 192.168.1.255:14550, where link 'b' listens"},
      {"SendsToTheGroupOfAnotherLink",
       link("name: a, type: udp, remote: '239.255.145.50:14550'") +
           "  - {name: b, type: udp, local: '0.0.0.0:14550', remote: '239.255.145.50:14550'}\n",
       "link 'a' sends to 239.255.145.50:14550, where link 'b' listens"},
      {"SpeaksWithAnotherLink",
       link("name: a, type: udp, local: '127.0.0.1:1', remote: '127.0.0.1:2'") +
           "  - {name: b, type: udp, local: '127.0.0.1:2', remote: '127.0.0.1:1'}\n",
       "link 'b' sends to 127.0.0.1:1, where link 'a' listens"},
      {"ListensByAnotherNameOfThisMachine",
       kLinks + "  - {name: b, type: udp_server, local: '127.0.0.1:1'}\n"
                "  - {name: c, type: udp_server, local: 'localhost:1'}\n",
       "link 'b' listens at 127.0.0.1:1 already"},
      {"ListensWhereAllOfIpV6Does",
       kLinks + "  - {name: b, type: udp_server, local: '[::]:1'}\n"
                "  - {name: c, type: udp_server, local: '127.0.0.1:1'}\n",
       "link 'b' listens at [::]:1 already"},
      {"ListensAtTheCommandPortOfIpV6",
       "command_port: {address: '::1'}\n" + link("name: a, type: tcp_server, local: '[::]:5790'"),
       "[::1]:5790 is the command port"},
      {"ListensAtTheCommandPort", link("name: a, type: tcp_server, local: '0.0.0.0:5790'"),
       "t.yaml:3: links[0]: 127.0.0.1:5790 is the command port"},
      {"LogsOfNoVehicle", "log: {autopilot: {systems: []}}\n" + kLinks,
       "log.autopilot.systems: names no vehicle"},
      {"LogsOfVehicleZero", "log: {autopilot: {systems: [0, 1]}}\n" + kLinks,
       "log.autopilot.systems: 0 is no"},
      {"OneDeviceTwice", kLinks + "  - {name: a, type: serial, device: /dev/ttyACM0}\n",
       "link 'fcu' has the device /dev/ttyACM0 already"},
      {"MisspeltKey", kLinks + "comand_port: {port: 1}\n", "comand_port"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    const std::string text = cas::test::refusal([&] { parse(row.yaml); });
    EXPECT_EQ(text.rfind("t.yaml", 0), 0U) << text;
    EXPECT_NE(text.find(row.says), std::string::npos) << text;
  }
}

TEST(Topology, TakesEndpointsThatOnlyLookAlike) {
  const Topology topology = parse(kLinks + R"(
  - {name: free, type: udp_server, local: "0.0.0.0:0"}
  - {name: free2, type: udp_server, local: "0.0.0.0:0"}
  - {name: tcp, type: tcp_server, local: "0.0.0.0:14551"}
  - {name: far, type: udp, remote: "192.168.1.2:14551"}
  - {name: other, type: udp_server, local: "127.0.0.2:14561"}
  - {name: group, type: udp, local: "0.0.0.0:14570", remote: "239.255.145.50:14570"}
  - {name: group2, type: udp, local: "0.0.0.0:14570", remote: "239.255.145.51:14570"}
  - {name: all, type: udp, remote: "192.168.1.255:14599"}
  - {name: eth, type: udp_server, local: "0.0.0.0:14580", interface: eth0}
  - {name: wlan, type: udp_server, local: "0.0.0.0:14580", interface: wlan0}
  - {name: by_hand, type: udp, remote: "127.0.0.1:14580"}
  - {name: vehicle, type: udp, local: "0.0.0.0:14590", remote: "192.168.1.2:14591"}
  - {name: stations, type: udp, remote: "192.168.1.255:14590"}
  - {name: listens, type: udp_server, local: "0.0.0.0:14600", sniffer: true}
  - {name: reads, type: udp_server, local: "0.0.0.0:14601", accept: nothing}
  - {name: to_sniffer, type: udp, remote: "192.168.1.255:14600"}
  - {name: to_reader, type: udp, remote: "192.168.1.255:14601"}
  - {name: all_v4, type: udp_server, local: "0.0.0.0:14602"}
  - {name: one_v6, type: udp_server, local: "[::1]:14602"}
)");
  EXPECT_EQ(topology.links.size(), 22U);
}

TEST(TopologyText, HasEveryKeyThatIsNotTheDefault) {
  std::string yaml = kLinks;
  const std::string link = ", max_peers: 16, expiry_s: 10";
  const std::string usual =
      topology_text(parse(std::string(kLinks).erase(kLinks.find(link), link.size())));
  EXPECT_EQ(usual.find("\n    "), usual.find("\n    HEARTBEAT")) << usual;
  yaml.replace(yaml.find(link), link.size(),
               ", max_peers: 16, queue: {hil_max_age_ms: 20}, scheduling: {cpus: [0]}, "
               "request_rates: {ATTITUDE: 50}, signing: {key_file: k, max_future_s: 0}");
  const std::string text =
      topology_text(parse("command_port: {unix_group: lab}\ncommanding: {heartbeat_hz: 0}\nlog: "
                          "{autopilot: {}}\nmetrics: {port: 9101}\n" +
                          yaml));
  for (const char* key :
       {"commanding.heartbeat_hz 0", "log.autopilot", "metrics.port 9101", "max_peers 16",
        "queue.hil_max_age_ms 20", "scheduling.cpus [0]", "request_rates ATTITUDE 50",
        "signing.max_future_s 0", "command_port.unix_group lab"}) {
    EXPECT_NE(text.find(key), std::string::npos) << key << "\n" << text;
  }
}

TEST(Topology, ALogMayOnlyStopVehiclesThatAreNotInHilAndSaysWhatVehiclesSaid) {
  const Topology topology = parse(R"(schema: 1
links:
  - {name: a, type: udp, local: "[::1]:1"}
  - {name: b, type: udp, local: "[::1]:2", to_not_hil: stops_only}
  - {name: c, type: tlog, file: old.tlog}
  - {name: d, type: tlog, file: old.tlog, commands: true, to_not_hil: all}
)");
  EXPECT_EQ(topology.links[0].to_not_hil, ToNotHil::kAll);
  EXPECT_FALSE(topology.links[0].accept.vehicles);
  EXPECT_EQ(topology.links[2].to_not_hil, ToNotHil::kStopsOnly);
  EXPECT_TRUE(topology.links[2].accept.vehicles);
  EXPECT_EQ(topology.links[3].to_not_hil, ToNotHil::kAll);
  EXPECT_FALSE(topology.links[3].accept.vehicles);
  const std::string text = topology_text(topology);
  EXPECT_NE(text.find("to vehicles not in HIL\n  all: a, d\n  stops only: b, c\n"),
            std::string::npos)
      << text;
}

TEST(TopologyText, LeavesOutWhatLockstepSets) {
  Topology topology = parse(kLinks);
  topology.set_lockstep();
  EXPECT_EQ(topology_text(topology).find("max_age_ms"), std::string::npos)
      << topology_text(topology);
}

TEST(LineBudget, SaysWhichRatesWouldFit) {
  std::string yaml = kLinks;
  yaml.replace(yaml.find("921600"), 6, "115200");
  const auto sentences = line_budget_warnings(
      parse(yaml + "routes:\n  - {from: sim, to: fcu, allow: [HEARTBEAT, HIL_SENSOR, HIL_GPS]}\n"));
  ASSERT_EQ(sentences.size(), 1U);
  // 500 x 77 + 5 x 51 + 21 bytes a second; 98 % of 115200 baud are 11.3 kB/s.
  EXPECT_NE(sentences[0].find("11.3 kB/s"), std::string::npos) << sentences[0];
  EXPECT_NE(sentences[0].find("38.8 kB/s"), std::string::npos) << sentences[0];
  EXPECT_NE(sentences[0].find("HIL_SENSOR fits up to 143 Hz"), std::string::npos) << sentences[0];
}

TEST(LineBudget, TakesRoutesWithoutAnAllowListToCarryTheStreams) {
  std::string yaml = kLinks;
  yaml.replace(yaml.find("921600"), 6, "115200");
  const auto budgets = line_budgets(parse(yaml));  // every link talks to every other one
  const auto fcu = std::find_if(budgets.begin(), budgets.end(),
                                [](const LineBudget& budget) { return budget.link == "fcu"; });
  ASSERT_NE(fcu, budgets.end());
  EXPECT_FALSE(fcu->fits());
  EXPECT_EQ(fcu->fitting_baud(), 460'800U);
  const std::string words = describe(budgets);
  EXPECT_NE(words.find("HIL_SENSOR"), std::string::npos) << words;
  EXPECT_NE(words.find("500 Hz assumed"), std::string::npos) << words;
  EXPECT_NE(words.find("TOO MUCH"), std::string::npos) << words;
}

TEST(LineBudget, ExpectsNoHilControlsOfAControllerWithoutSimulatedSensors) {
  const std::string two = std::string(kLinks) +
                          "  - {name: other, type: serial, device: /dev/other, baud: 57600}\n"
                          "routes: [{from: fcu, to: other}";
  const auto has_controls = [&](const std::string& more) {
    return describe(line_budgets(parse(two + more + "]\n"))).find("HIL_CONTROLS") !=
           std::string::npos;
  };
  EXPECT_FALSE(has_controls(""));
  EXPECT_FALSE(has_controls(", {from: other, to: fcu}"));
  EXPECT_FALSE(has_controls(", {from: sim, to: fcu, block: [HIL_SENSOR]}"));
  EXPECT_TRUE(has_controls(", {from: sim, to: fcu}"));
  EXPECT_TRUE(has_controls(", {from: sim, to: fcu, allow: [HIL_SENSOR]}"));
}

TEST(LineBudget, DoesNotCallALineWideEnoughWhoseStreamsItDoesNotKnow) {
  std::string yaml = kLinks;
  yaml.replace(yaml.find("921600"), 6, "57600");
  for (const char* route : {"block: [HIL_SENSOR, HIL_GPS]", "allow: [HEARTBEAT]"}) {
    const auto topology = parse(yaml + "routes:\n  - {from: sim, to: fcu, " + route + "}\n");
    const std::string words = describe(line_budgets(topology));
    EXPECT_NE(words.find("no stream of a HIL run"), std::string::npos) << words;
    EXPECT_EQ(words.find("fits"), std::string::npos) << words;
  }
}

TEST(LineBudget, LeavesOutWhatALinkDoesNotAccept) {
  std::string yaml = kLinks;
  yaml.replace(yaml.find("921600"), 6, "57600");
  yaml +=
      "  - {name: qgc, type: udp_server, local: '127.0.0.1:0', accept: {traffic: "
      "ground_station}}\n";
  const std::string routes = "routes:\n  - {from: qgc, to: fcu}\n";
  EXPECT_TRUE(line_budget_warnings(parse(yaml + routes)).empty());
  EXPECT_EQ(line_budget_warnings(parse(yaml + routes + "  - {from: sim, to: fcu}\n")).size(), 1U);
  // A station's route that names messages says nothing of the simulator's streams.
  for (const char* named : {"HEARTBEAT, COMMAND_LONG", "HIL_SENSOR"}) {
    const auto sentences =
        line_budget_warnings(parse(yaml + "routes:\n  - {from: qgc, to: fcu, allow: [" + named +
                                   "]}\n  - {from: sim, to: fcu}\n"));
    EXPECT_EQ(sentences.size(), 1U) << named;
  }
}

TEST(LineBudget, PacesAPseudoTerminalOnlyWhereTheRateIsTight) {
  const auto paced = [](const std::string& baud, const std::string& more = "") {
    std::string yaml = kLinks;
    yaml.replace(yaml.find("921600"), 6, baud + more);
    for (const LinkConfig& link : parse(yaml).links) {
      if (link.name == "fcu") return link.pace_pty;
    }
    return false;
  };
  EXPECT_FALSE(paced("921600"));
  EXPECT_TRUE(paced("921600", ", pace: true"));
  EXPECT_TRUE(paced("115200"));
  EXPECT_FALSE(paced("115200", ", pace: false"));
}

TEST(LineBudget, IsSilentWhenTheLineSuffices) {
  EXPECT_TRUE(line_budget_warnings(
                  parse(route("from: sim, to: fcu, allow: [HEARTBEAT, HIL_SENSOR, HIL_GPS]")))
                  .empty());
}

TEST(LineBudget, CountsRateRules) {
  std::string yaml = kLinks;
  yaml.replace(yaml.find("921600"), 6, "115200");
  EXPECT_TRUE(line_budget_warnings(parse(yaml + "routes:\n  - {from: sim, to: fcu, allow: "
                                                "[HIL_SENSOR], rates: {HIL_SENSOR: 100}}\n"))
                  .empty());
}

}  // namespace
}  // namespace cas::casd::test
