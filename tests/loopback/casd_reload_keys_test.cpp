// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <set>
#include <sstream>
#include <utility>

#include "base/error.hpp"
#include "base/rpc/client.hpp"
#include "tests/loopback/casd_fixture.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"

// What a reload does with each key of a topology: it is in force when the call answers, or the
// answer names it and nothing has changed. The last test holds the tables here to docs/config.md.

namespace cas::test {
namespace {

using mavlink::common::Heartbeat;
using nlohmann::json;

std::string test_name(const std::string& key) {
  return std::regex_replace(key, std::regex("[^a-z0-9_]"), "_");
}

constexpr const char* kPort = "command_port: {port: 0, loopback_without_token: true}\n";

/// The real casd between a socket and a line.
class ReloadProgram {
 public:
  /// @param extra  blocks of the topology beside its links
  std::string topology(const std::string& extra, const std::string& more_links = "") {
    const bool has_port = extra.find("command_port") != std::string::npos;
    std::string yaml = kHilTopology;
    yaml.insert(yaml.find("routes:"), more_links);
    return fixture.folder.write("topology.yaml",
                                fixture.expand(yaml + (has_port ? "" : kPort) + extra));
  }
  void start(const std::string& extra, const std::string& flag = "--log-level=info") {
    casd.emplace(
        std::vector<std::string>{cas::test::binary_dir() + "/bin/casd", topology(extra), flag});
    const auto status = casd->wait_ready();
    if (!status) throw std::runtime_error(casd->output());
    const std::string word = "command_port ";
    const std::size_t at = status->find(word) + word.size();
    client.emplace(status->substr(at, status->find(' ', at) - at));
  }
  json call(const std::string& method, const json& params = json::object()) {
    return client->call(method, params);
  }
  /// The sentence of a refusal; empty: none.
  std::string refusal(const std::string& method, const json& params = json::object()) {
    try {
      call(method, params);
    } catch (const base::rpc::CallError& error) {
      return error.what();
    }
    return "";
  }
  /// A PX4 that does not say that it is in HIL has just been heard.
  void meet_vehicle() {
    const auto age = [this] {
      const json vehicles = call("casd.status").at("vehicles");
      return vehicles.empty() ? 1e9 : vehicles[0].at("heartbeat_age_s").get<double>();
    };
    Heartbeat heartbeat;
    heartbeat.type = mavlink::common::MavType::kQuadrotor;
    heartbeat.autopilot = mavlink::common::MavAutopilot::kPx4;
    heartbeat.base_mode = mavlink::common::MavModeFlag::kCustomModeEnabled;
    fixture.fcu.write(fixture.from_fcu(heartbeat));
    ASSERT_TRUE(wait_until([&] { return age() < 1; }));
  }

  CasdFixture fixture;
  std::optional<ChildProcess> casd;
  std::optional<base::rpc::Client> client;
};

// Blocks of casd itself.

struct RefusedCase {
  const char* key;
  const char* before;
  const char* after;
};

constexpr RefusedCase kRefused[] = {
    {"system_id", "", "system_id: 253"},
    {"component_id", "component_id: 191", "component_id: 192"},
    {"threads", "", "threads: single"},
    {"drain_tick_ms", "", "drain_tick_ms: 4"},
    {"pace", "pace: lockstep", "pace: realtime"},
    {"scheduling.fifo_priority", "", "scheduling: {fifo_priority: 1}"},
    {"scheduling.cpus", "", "scheduling: {cpus: [0]}"},
    {"lock_memory", "", "lock_memory: true"},
    {"cpu_dma_latency_us", "", "cpu_dma_latency_us: 100"},
    {"route_lifetime_s", "route_lifetime_s: 60", "route_lifetime_s: 5"},
    {"command_port.address", "",
     "command_port: {port: 0, loopback_without_token: true, address: '::1'}"},
    {"command_port.port", "", "command_port: {port: 1, loopback_without_token: true}"},
    {"command_port.unix", "",
     "command_port: {port: 0, loopback_without_token: true, unix: $DIR/casd.sock}"},
    {"command_port.unix_group", "",
     "command_port: {port: 0, loopback_without_token: true, unix_group: root}"},
    {"command_port.token_file", "",
     "command_port: {port: 0, loopback_without_token: true, token_file: token}"},
    {"command_port.loopback_without_token", "", "command_port: {port: 0}"},
    {"log.folder", "", "log: {folder: $DIR}"},
    {"log.tlog", "log: {folder: $DIR}", "log: {folder: $DIR, tlog: a}"},
    {"log.rotate_mib", "log: {folder: $DIR}", "log: {folder: $DIR, rotate_mib: 1}"},
    {"log.rotate_minutes", "log: {folder: $DIR}", "log: {folder: $DIR, rotate_minutes: 1}"},
    {"log.keep", "log: {folder: $DIR}", "log: {folder: $DIR, keep: 1}"},
    {"log.max_mib", "log: {folder: $DIR}", "log: {folder: $DIR, max_mib: 1}"},
    {"log.free_space_min_mib", "log: {folder: $DIR}", "log: {folder: $DIR, free_space_min_mib: 1}"},
    {"log.while_armed", "log: {folder: $DIR}", "log: {folder: $DIR, while_armed: true}"},
    {"log.overwrite", "log: {folder: $DIR}", "log: {folder: $DIR, overwrite: true}"},
    {"metrics.address", "metrics: {port: 0}", "metrics: {port: 0, address: '::1'}"},
    {"metrics.port", "", "metrics: {port: 0}"},
};

class RefusedKey : public testing::TestWithParam<RefusedCase> {};

TEST_P(RefusedKey, IsNamedAndNothingChanges) {
  const auto& [key, before, after] = GetParam();
  ReloadProgram program;
  program.start(before);
  program.topology(after, "  - {name: gcs, type: udp_server, local: '127.0.0.1:0'}\n");
  const std::string block = std::string(key).substr(0, std::string(key).find('.'));
  const std::string said = program.refusal("casd.reload");
  EXPECT_TRUE(
      std::regex_search(said, std::regex("topology.yaml:[0-9]+: " + block + ": takes a restart")))
      << said;
  EXPECT_EQ(program.call("link.list").size(), 2U);
  program.topology(before);
  EXPECT_EQ(program.refusal("casd.reload"), "");
}

INSTANTIATE_TEST_SUITE_P(Casd, RefusedKey, testing::ValuesIn(kRefused),
                         [](const auto& test) { return test_name(test.param.key); });

TEST(ReloadKeys, NamesAKeyThatWasTakenOut) {
  ReloadProgram program;
  program.start("metrics: {port: 0}\n");
  program.topology("");
  const std::string said = program.refusal("casd.reload");
  EXPECT_NE(said.find("metrics: takes a restart"), std::string::npos) << said;
}

TEST(ReloadKeys, KeepTheLockstepOfTheFlag) {
  ReloadProgram program;
  program.start("", "--lockstep");
  program.topology("", "  - {name: gcs, type: udp_server, local: '127.0.0.1:0'}\n");
  EXPECT_EQ(program.refusal("casd.reload"), "");
  EXPECT_EQ(program.call("link.list").size(), 3U);
}

struct InForceCase {
  const char* key;
  const char* before;
  const char* after;
  /// How to see which of the two is in force.
  void (*expect)(ReloadProgram& program, bool reloaded);
};

void expect_fast_beats(ReloadProgram& program, bool reloaded) {
  CasdFixture& fixture = program.fixture;
  if (!reloaded) {  // the next one is due in 100 s
    EXPECT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHeartbeat) == 1; }));
    return;
  }
  EXPECT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHeartbeat) > 3; }));
}

bool consents(ReloadProgram& program) {
  program.meet_vehicle();
  const std::string said = program.refusal("vehicle.manual_control", {{"not_hil", true}});
  EXPECT_TRUE(said.empty() || said.find("allow_not_hil") != std::string::npos) << said;
  if (!said.empty()) {
    const std::string armed = program.refusal("vehicle.arm", {{"not_hil", true}});
    EXPECT_NE(armed.find("allow_not_hil"), std::string::npos) << armed;
  }
  return said.empty();
}

void expect_consent_given(ReloadProgram& program, bool reloaded) {
  EXPECT_EQ(consents(program), reloaded);
}

void expect_consent_withdrawn(ReloadProgram& program, bool reloaded) {
  EXPECT_EQ(consents(program), !reloaded);
}

void expect_dialect(ReloadProgram& program, bool reloaded) {
  const json asked{{"link", "sim"}, {"message", "LAB_THING"}, {"system", 1}, {"component", 200}};
  EXPECT_EQ(program.refusal("message.value", asked).empty(), reloaded);
}

void expect_gains(ReloadProgram& program, bool reloaded) {
  program.meet_vehicle();
  EXPECT_EQ(program.call("gain.list").at("loops").at(0).at("parameters").at("p"),
            reloaded ? "NEW_P" : "OLD_P");
}

constexpr InForceCase kInForce[] = {
    {"commanding.heartbeat_hz", "commanding: {heartbeat_hz: 0.01}",
     "commanding: {heartbeat_hz: 50}", expect_fast_beats},
    {"commanding.allow_not_hil", "commanding: {allow_not_hil: true}",
     "commanding: {allow_not_hil: false}", expect_consent_withdrawn},
    {"commanding.allow_not_hil", "", "commanding: {allow_not_hil: true}", expect_consent_given},
    {"commanding.allow_not_hil", "commanding: {allow_not_hil: true}", "", expect_consent_withdrawn},
    {"dialect", "", "dialect: lab.xml", expect_dialect},
    {"gains", "gains: old.yaml", "gains: new.yaml", expect_gains},
};

class InForceKey : public testing::TestWithParam<InForceCase> {};

TEST_P(InForceKey, IsInForceWhenTheReloadAnswers) {
  const auto& [key, before, after, expect] = GetParam();
  ReloadProgram program;
  const TemporaryFolder& folder = program.fixture.folder;
  folder.write("old.yaml", "schema: 1\npx4:\n  roll: {p: OLD_P}\n");
  folder.write("new.yaml", "schema: 1\npx4:\n  roll: {p: NEW_P}\n");
  folder.write("lab.xml",
               "<mavlink><messages><message id='54321' name='LAB_THING'>"
               "<field type='uint8_t' name='x'>x</field></message></messages></mavlink>");
  program.start(before);
  expect(program, false);
  program.topology(after);
  EXPECT_EQ(program.call("casd.reload"), (json{{"reloaded", true}}));
  expect(program, true);
}

INSTANTIATE_TEST_SUITE_P(Casd, InForceKey, testing::ValuesIn(kInForce), [](const auto& test) {
  return test_name(test.param.key) + "_" + std::to_string(test.index);
});

// Keys of a link: the link is made anew from them, and no other is touched.

struct LinkCase {
  const char* key;
  const char* before;
  const char* after;
};

constexpr const char* kUdpLink = "name: x, type: udp, local: '127.0.0.1:0'";
constexpr const char* kSerialLink = "name: x, type: serial, device: $DIR/none, baud: 921600";
constexpr const char* kTlogLink = "name: x, type: tlog, file: $DIR/none.tlog";
constexpr const char* kSignedLink =
    "name: x, type: udp, local: '127.0.0.1:0', signing: {key_file: $DIR/a.key}";

constexpr LinkCase kLinkKeys[] = {
    {"name", kUdpLink, "name: y, type: udp, local: '127.0.0.1:0'"},
    {"type", kUdpLink, "name: x, type: udp_server, local: '127.0.0.1:0'"},
    {"local", kUdpLink, "name: x, type: udp, local: '127.0.0.2:0'"},
    {"remote", kUdpLink, "name: x, type: udp, local: '127.0.0.1:0', remote: '127.0.0.1:9'"},
    {"interface", kUdpLink, "name: x, type: udp, local: '127.0.0.1:0', interface: lo"},
    {"max_peers", "name: x, type: tcp_server, local: '127.0.0.1:0'",
     "name: x, type: tcp_server, local: '127.0.0.1:0', max_peers: 3"},
    {"expiry_s", "name: x, type: udp_server, local: '127.0.0.1:0'",
     "name: x, type: udp_server, local: '127.0.0.1:0', expiry_s: 3"},
    {"device", kSerialLink, "name: x, type: serial, device: $DIR/other, baud: 921600"},
    {"baud", kSerialLink, "name: x, type: serial, device: $DIR/none, baud: 57600"},
    {"flow_control", kSerialLink,
     "name: x, type: serial, device: $DIR/none, baud: 921600, flow_control: true"},
    // Paced without being asked for, but not on a pseudo-terminal.
    {"pace", kSerialLink, "name: x, type: serial, device: $DIR/none, baud: 921600, pace: true"},
    {"sensor_gap_ms", kSerialLink,
     "name: x, type: serial, device: $DIR/none, baud: 921600, sensor_gap_ms: 1"},
    {"unlocked_pty", kSerialLink,
     "name: x, type: serial, device: $DIR/none, baud: 921600, unlocked_pty: true"},
    {"file", kTlogLink, "name: x, type: tlog, file: $DIR/other.tlog"},
    {"speed", kTlogLink, "name: x, type: tlog, file: $DIR/none.tlog, speed: 2"},
    {"repeat", kTlogLink, "name: x, type: tlog, file: $DIR/none.tlog, repeat: true"},
    {"max_bytes_s", kUdpLink, "name: x, type: udp, local: '127.0.0.1:0', max_bytes_s: 1000"},
    {"unknown_messages", kUdpLink,
     "name: x, type: udp, local: '127.0.0.1:0', unknown_messages: drop"},
    {"group", kUdpLink, "name: x, type: udp, local: '127.0.0.1:0', group: twins"},
    {"scheduling", kUdpLink, "name: x, type: udp, local: '127.0.0.1:0', scheduling: {cpus: [0]}"},
    {"queue.hil_max_age_ms", kUdpLink,
     "name: x, type: udp, local: '127.0.0.1:0', queue: {hil_max_age_ms: 9}"},
    {"queue.gps_max_age_ms", kUdpLink,
     "name: x, type: udp, local: '127.0.0.1:0', queue: {gps_max_age_ms: 9}"},
    {"queue.setpoint_max_age_ms", kUdpLink,
     "name: x, type: udp, local: '127.0.0.1:0', queue: {setpoint_max_age_ms: 9}"},
    {"queue.telemetry_max_age_ms", kUdpLink,
     "name: x, type: udp, local: '127.0.0.1:0', queue: {telemetry_max_age_ms: 9}"},
    {"queue.command_kib", kUdpLink,
     "name: x, type: udp, local: '127.0.0.1:0', queue: {command_kib: 9}"},
    {"queue.hil_kib", kUdpLink, "name: x, type: udp, local: '127.0.0.1:0', queue: {hil_kib: 9}"},
    {"queue.gps_kib", kUdpLink, "name: x, type: udp, local: '127.0.0.1:0', queue: {gps_kib: 9}"},
    {"queue.telemetry_kib", kUdpLink,
     "name: x, type: udp, local: '127.0.0.1:0', queue: {telemetry_kib: 9}"},
    {"accept", kUdpLink, "name: x, type: udp, local: '127.0.0.1:0', accept: nothing"},
    {"accept.messages", kUdpLink,
     "name: x, type: udp, local: '127.0.0.1:0', accept: {messages: [HEARTBEAT]}"},
    {"accept.systems", kUdpLink,
     "name: x, type: udp, local: '127.0.0.1:0', accept: {systems: [7]}"},
    {"accept.traffic", kUdpLink,
     "name: x, type: udp, local: '127.0.0.1:0', accept: {traffic: ground_station}"},
    {"accept.block_systems", kUdpLink,
     "name: x, type: udp, local: '127.0.0.1:0', accept: {block_systems: [7]}"},
    {"signing.key_file", kSignedLink,
     "name: x, type: udp, local: '127.0.0.1:0', signing: {key_file: $DIR/b.key}"},
    {"signing.link_id", kSignedLink,
     "name: x, type: udp, local: '127.0.0.1:0', signing: {key_file: $DIR/a.key, link_id: 1}"},
    {"signing.verify", kSignedLink,
     "name: x, type: udp, local: '127.0.0.1:0', signing: {key_file: $DIR/a.key, verify: false}"},
    {"signing.sign", kSignedLink,
     "name: x, type: udp, local: '127.0.0.1:0', signing: {key_file: $DIR/a.key, sign: false}"},
    {"signing.max_future_s", kSignedLink,
     "name: x, type: udp, local: '127.0.0.1:0', signing: {key_file: $DIR/a.key, max_future_s: 60}"},
    {"signing.allow_unsigned", kSignedLink,
     "name: x, type: udp, local: '127.0.0.1:0', "
     "signing: {key_file: $DIR/a.key, allow_unsigned: [RADIO_STATUS]}"},
};

void write_key(const TemporaryFolder& folder, const char* name, const char* phrase) {
  namespace fs = std::filesystem;
  fs::permissions(folder.write(name, phrase), fs::perms::owner_read | fs::perms::owner_write);
}

class LinkKey : public testing::TestWithParam<LinkCase> {
 protected:
  LinkKey() {
    write_key(folder(), "a.key", "a pass phrase of one key\n");
    write_key(folder(), "b.key", "a pass phrase of another\n");
  }
  const TemporaryFolder& folder() const { return fixture_.folder; }
  casd::Topology parse(const std::string& link) const {
    return fixture_.parse(
        "schema: 1\nlinks:\n  - {name: other, type: udp, local: '127.0.0.1:0'}\n"
        "  - {" +
        link + "}\n");
  }
  CasdFixture fixture_;
};

TEST_P(LinkKey, MakesItsLinkAnewAndNoOther) {
  casd::LinkSet links(parse(GetParam().before));
  links.figures().keep_ledgers();  // each link that is made has one of its own
  links.start();
  const auto before = links.figures().ledgers();
  links.reload(parse(GetParam().before));
  EXPECT_EQ(links.figures().ledgers(), before);  // nothing has changed
  links.reload(parse(GetParam().after));
  const auto after = links.figures().ledgers();
  EXPECT_EQ(after.at("other"), before.at("other"));
  ASSERT_EQ(after.size(), 2U);
  for (const auto& [name, ledger] : after) {
    if (name == "other") continue;
    EXPECT_NE(ledger, before.at("x"));
  }
}

INSTANTIATE_TEST_SUITE_P(Link, LinkKey, testing::ValuesIn(kLinkKeys),
                         [](const auto& test) { return test_name(test.param.key); });

TEST(ReloadKeys, RefuseAnotherSigningKeyInTheSameFile) {
  CasdFixture fixture;
  write_key(fixture.folder, "a.key", "a pass phrase of one key\n");
  const std::string yaml = "schema: 1\nlinks:\n  - {" + std::string(kSignedLink) + "}\n";
  casd::LinkSet links(fixture.parse(yaml));
  links.reload(fixture.parse(yaml));
  write_key(fixture.folder, "a.key", "a pass phrase of another\n");
  try {
    links.reload(fixture.parse(yaml));
    ADD_FAILURE() << "taken";
  } catch (const base::ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("a.key"), std::string::npos) << error.what();
  }
}

// Keys of a route: how many of two HIL_CONTROLS get through from the controller to the simulator.

struct RouteCase {
  const char* key;
  const char* before;
  std::size_t passed_before;
  const char* after;
  std::size_t passed_after;
};

constexpr const char* kOpen = "from: fcu, to: sim";

constexpr RouteCase kRouteKeys[] = {
    {"from", "from: sim, to: fcu", 0, kOpen, 2},
    {"to", "from: fcu, to: gcs", 0, kOpen, 2},
    {"allow", kOpen, 2, "from: fcu, to: sim, allow: [HEARTBEAT]", 0},
    {"block", kOpen, 2, "from: fcu, to: sim, block: [HIL_CONTROLS]", 0},
    {"allow_systems", kOpen, 2, "from: fcu, to: sim, allow_systems: [7]", 0},
    {"block_systems", "from: fcu, to: sim, block_systems: [1]", 0, kOpen, 2},
    {"allow_components", kOpen, 2, "from: fcu, to: sim, allow_components: [7]", 0},
    {"block_components", kOpen, 2, "from: fcu, to: sim, block_components: [1]", 0},
    {"rates", kOpen, 2, "from: fcu, to: sim, rates: {HIL_CONTROLS: 0.001}", 1},
    {"max_hz", "from: fcu, to: sim, rates: {HIL_CONTROLS: {max_hz: 0.001}}", 1, kOpen, 2},
    {"every", kOpen, 2, "from: fcu, to: sim, rates: {HIL_CONTROLS: {every: 2}}", 1},
};

class RouteKey : public testing::TestWithParam<RouteCase> {
 protected:
  std::string yaml(const std::string& route) const {
    const std::string whole = kHilTopology;
    return whole.substr(0, whole.find("routes:")) +
           "  - {name: gcs, type: udp_server, local: '127.0.0.1:0'}\nroutes:\n  - {" + route +
           "}\n";
  }
  /// Sends two packets. @return how many the simulator has got, once it has those it should have
  /// and then one of casd's own station, which no route stops
  std::size_t passed(std::size_t expected) {
    const std::size_t before = fixture_.at_sim.count(kHilControls);
    const std::uint64_t received = fixture_.status("fcu").rx.packets;
    for (int i = 0; i < 2; ++i) fixture_.fcu.write(fixture_.from_fcu(hil_controls(++number_)));
    EXPECT_TRUE(fixture_.collect_until([&] {
      return fixture_.status("fcu").rx.packets == received + 2 &&
             fixture_.at_sim.count(kHilControls) >= before + expected;
    }));
    const std::size_t beats = fixture_.at_sim.count(kHeartbeat);
    fixture_.links().local().send(station_(Heartbeat{}), {}, base::steady_now());
    EXPECT_TRUE(fixture_.collect_until([&] { return fixture_.at_sim.count(kHeartbeat) > beats; }));
    return fixture_.at_sim.count(kHilControls) - before;
  }
  CasdFixture fixture_;
  mav::Encoder station_{{254, 190}};
  std::uint64_t number_ = 0;
};

TEST_P(RouteKey, IsInForceAfterAReload) {
  const RouteCase& test = GetParam();
  fixture_.start(yaml(test.before));
  EXPECT_EQ(passed(test.passed_before), test.passed_before);
  fixture_.links().reload(fixture_.parse(yaml(test.after)));
  EXPECT_EQ(passed(test.passed_after), test.passed_after);
}

INSTANTIATE_TEST_SUITE_P(Route, RouteKey, testing::ValuesIn(kRouteKeys),
                         [](const auto& test) { return test_name(test.param.key); });

// The reference of docs/config.md.

/// What stands between backquotes.
std::vector<std::string> quoted(const std::string& text) {
  std::vector<std::string> words;
  const std::regex quotes("`([^`]*)`");
  for (std::sregex_iterator it(text.begin(), text.end(), quotes), end; it != end; ++it) {
    words.push_back((*it)[1]);
  }
  return words;
}

/// "key", "key: FILE" and "key: {a, b: FILE}" as "key" or "key.a", "key.b".
std::vector<std::string> keys_in(const std::string& word) {
  const std::string key = word.substr(0, word.find(':'));
  const std::size_t block = word.find('{');
  if (block == std::string::npos) return {key};
  std::vector<std::string> keys;
  std::istringstream inner(word.substr(block + 1, word.find('}') - block - 1));
  for (std::string part; std::getline(inner, part, ',');) {
    part = part.substr(part.find_first_not_of(' '));
    keys.push_back(key + "." + part.substr(0, part.find(':')));
  }
  return keys;
}

/// The keys that the chapter "Topology" names: in its tables, and in the paragraphs on links,
/// queues, accept and routes.
std::set<std::string> documented_keys() {
  const std::string whole = TemporaryFolder::read(source_dir() + "/docs/config.md");
  const std::size_t begin = whole.find("\n## Topology");
  std::istringstream chapter(whole.substr(begin, whole.find("\n## ", begin + 1) - begin));
  const std::regex brackets("\\([^)]*\\)");
  std::set<std::string> keys;
  std::string paragraph;
  enum { kTop, kLinks, kSigning } table = kTop;
  const auto end_paragraph = [&] {
    const std::string text = std::exchange(paragraph, "");
    if (text.starts_with("A link has") || text.starts_with("`queue` sets")) {
      const std::string prefix = text.starts_with("A") ? "links." : "links.queue.";
      for (const std::string& word : quoted(text)) {
        if (word != "queue") keys.insert(prefix + word);
      }
    } else if (text.starts_with("`accept` limits")) {
      const std::regex lists("(\\w+): (?:\\[|ground_station)");
      for (std::sregex_iterator it(text.begin(), text.end(), lists), end; it != end; ++it) {
        keys.insert("links.accept." + (*it)[1].str());
      }
    } else if (text.starts_with("A route has")) {
      for (const std::string& word : quoted(text)) {
        if (word == "any") continue;
        keys.insert("routes." +
                    (word.starts_with("{") ? word.substr(1, word.find(':') - 1) : word));
      }
    }
  };
  for (std::string line; std::getline(chapter, line);) {
    if (line.empty()) {
      end_paragraph();
    } else if (!line.starts_with("|")) {
      paragraph += line + " ";
    } else if (line.starts_with("| type |")) {
      table = kLinks;
    } else if (line.starts_with("| key |")) {
      table = table == kTop ? kTop : kSigning;
    } else if (!line.starts_with("|-")) {
      const std::size_t second = line.find(" | ");
      const std::string first = line.substr(0, second);
      if (table == kLinks) {
        const std::string cell = std::regex_replace(line.substr(second), brackets, "");
        for (const std::string& word : quoted(cell)) keys.insert("links." + word);
        continue;
      }
      for (const std::string& word : quoted(first)) {
        for (const std::string& key : keys_in(word)) {
          keys.insert(table == kTop ? key : "links.signing." + key);
        }
      }
    }
  }
  end_paragraph();
  // Blocks whose keys are named one by one.
  for (const char* block : {"links", "routes", "links.queue", "links.signing"}) keys.erase(block);
  return keys;
}

TEST(ReloadKeys, AreTheKeysOfTheReference) {
  std::set<std::string> tested;
  for (const RefusedCase& test : kRefused) tested.insert(test.key);
  for (const InForceCase& test : kInForce) tested.insert(test.key);
  for (const LinkCase& test : kLinkKeys) tested.insert(std::string("links.") + test.key);
  for (const RouteCase& test : kRouteKeys) tested.insert(std::string("routes.") + test.key);
  const std::set<std::string> documented = documented_keys();
  for (const std::string& key : documented) {
    EXPECT_TRUE(tested.contains(key)) << "no test says what a reload does with " << key;
  }
  for (const std::string& key : tested) {
    EXPECT_TRUE(documented.contains(key)) << "docs/config.md does not name " << key;
  }
}

}  // namespace
}  // namespace cas::test
