// SPDX-License-Identifier: BSD-3-Clause
#include <gmock/gmock.h>

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <set>
#include <utility>

#include "tests/casd/key_changes.hpp"
#include "tests/loopback/casd_fixture.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/support/refusal.hpp"

// Effect of a reload on each key of a topology: the new value is in force when the call answers, or
// the answer names the key and nothing has changed. The keys are those that casd reads.

namespace cas::test {
namespace {

using mavlink::common::CommandLong;
using mavlink::common::Heartbeat;
using nlohmann::json;
using testing::HasSubstr;

std::string test_name(const std::string& key) {
  return std::regex_replace(key, std::regex("[^a-z0-9_]"), "_");
}

/// The real casd between a socket and a line.
class ReloadProgram {
 public:
  /// @param extra  blocks of the topology beside its links
  std::string topology(const std::string& extra, const std::string& more_links = "") {
    const bool has_port = extra.find("command_port") != std::string::npos;
    std::string yaml = kHilTopology;
    yaml.insert(yaml.find("routes:"), more_links);
    return fixture.folder.write("topology.yaml",
                                fixture.expand(yaml + (has_port ? "" : kOpenPort) + extra));
  }
  void start(const std::string& extra, const std::string& flag = "--log-level=info") {
    casd.emplace(std::vector<std::string>{kCasdProgram, topology(extra), flag});
  }
  json call(const std::string& method, const json& params = json::object()) {
    return casd->call(method, params);
  }
  /// Another topology in force, or the sentence of the refusal.
  std::string reload(const std::string& extra) {
    topology(extra);
    return refusal("casd.reload");
  }
  std::string refusal(const std::string& method, const json& params = json::object()) {
    return casd->refusal(method, params);
  }
  /// A PX4 that does not say that it is in HIL has just been heard.
  void meet_vehicle(std::uint8_t system = 1) {
    const auto age = [this, system] {
      const json vehicles = call("casd.status").at("vehicles");
      for (const json& vehicle : vehicles) {
        if (vehicle.at("system") == system) return vehicle.at("heartbeat_age_s").get<double>();
      }
      return 1e9;
    };
    Heartbeat heartbeat{.type = mavlink::common::MavType::kQuadrotor,
                        .autopilot = mavlink::common::MavAutopilot::kPx4,
                        .base_mode = mavlink::common::MavModeFlag::kCustomModeEnabled};
    mav::Encoder vehicle{{system, 1}};
    fixture.fcu.write(vehicle(heartbeat));
    ASSERT_TRUE(wait_until([&] { return age() < 1; }));
  }

  CasdFixture fixture;
  std::optional<RunningCasd> casd;
};

// Blocks of casd itself.

class RefusedKey : public testing::TestWithParam<KeyChange> {};

TEST_P(RefusedKey, IsNamedAndNothingChanges) {
  const KeyChange& change = GetParam();
  ReloadProgram program;
  program.start(change.before);
  const std::string block = change.key.substr(0, change.key.find('.'));
  std::string said;
  for (const std::string& after : change.after) {
    if (after.empty() || !said.empty()) continue;
    program.topology(after, "  - {name: gcs, type: udp_server, local: '127.0.0.1:0'}\n");
    said = program.refusal("casd.reload");
    if (said.empty()) program.reload(change.before);  // the old value
  }
  EXPECT_TRUE(
      std::regex_search(said, std::regex("topology.yaml:[0-9]+: " + block + ": takes a restart")))
      << said;
  EXPECT_EQ(program.call("link.list").size(), 2U);
  EXPECT_EQ(program.reload(change.before), "");
}

INSTANTIATE_TEST_SUITE_P(Casd, RefusedKey,
                         testing::ValuesIn(topology_changes(casd::restart_rows())),
                         [](const auto& test) { return test_name(test.param.key); });

TEST(ReloadKeys, NamesAKeyThatWasTakenOut) {
  ReloadProgram program;
  program.start("metrics: {port: 0}\n");
  program.topology("");
  EXPECT_THAT(program.refusal("casd.reload"), HasSubstr("metrics: takes a restart"));
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

void expect_questions(ReloadProgram& program, bool reloaded) {
  CasdFixture& fixture = program.fixture;
  program.meet_vehicle(reloaded ? 2 : 1);
  const auto asked = [&] { return fixture.at_fcu.count(CommandLong::kId) > 0; };
  if (reloaded) {
    EXPECT_TRUE(fixture.collect_until(asked));
  } else {
    fixture.collect();
    EXPECT_FALSE(asked());
  }
}

bool consents(ReloadProgram& program) {
  program.meet_vehicle();
  const std::string said = program.refusal("vehicle.manual_control", {{"not_hil", true}});
  EXPECT_TRUE(said.empty() || said.find("allow_not_hil") != std::string::npos) << said;
  if (!said.empty()) {
    EXPECT_THAT(program.refusal("vehicle.arm", {{"not_hil", true}}), HasSubstr("allow_not_hil"));
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

/// Both links bring the same packet: is the second one told to be a duplicate?
void expect_one_of_two(ReloadProgram& program, bool reloaded) {
  CasdFixture& fixture = program.fixture;
  const auto verdicts = [&](const char* name) -> json {
    for (const json& link : program.call("link.list")) {
      if (link.at("name") != name) continue;
      if (link.at("name") == "sim") fixture.sim.set_remote(port_of(link.at("endpoint")));
      return link.at("rx").at("verdicts");
    }
    return {};
  };
  const auto packet = fixture.from_fcu(Heartbeat{});
  const json fcu_before = verdicts("fcu");
  const json sim_before = verdicts("sim");
  fixture.fcu.write(packet);
  EXPECT_TRUE(wait_until([&] { return verdicts("fcu") != fcu_before; }));
  fixture.sim.send(packet);
  EXPECT_TRUE(wait_until([&] { return verdicts("sim") != sim_before; }));
  EXPECT_EQ(verdicts("sim").at("duplicate"), reloaded ? 1 : 0);
}

constexpr InForceCase kInForce[] = {
    {"duplicate_window_ms", "", "duplicate_window_ms: 60000", expect_one_of_two},
    {"commanding.heartbeat_hz", "commanding: {heartbeat_hz: 0.01}",
     "commanding: {heartbeat_hz: 50}", expect_fast_beats},
    {"commanding.allow_not_hil", "commanding: {allow_not_hil: true}",
     "commanding: {allow_not_hil: false}", expect_consent_withdrawn},
    {"commanding.allow_not_hil", "", "commanding: {allow_not_hil: true}", expect_consent_given},
    {"commanding.allow_not_hil", "commanding: {allow_not_hil: true}", "", expect_consent_withdrawn},
    {"commanding.ask_on_sight", "commanding: {ask_on_sight: false}", "", expect_questions},
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

// Keys of a link: the link is remade from them, and no other is touched.

constexpr const char* kSignedLink =
    "{name: x, type: udp, local: '127.0.0.1:0', signing: {key_file: $DIR/a.key}}";

void write_key(const TemporaryFolder& folder, const char* name, const char* phrase) {
  namespace fs = std::filesystem;
  fs::permissions(folder.write(name, phrase), fs::perms::owner_read | fs::perms::owner_write);
}

class LinkKey : public testing::TestWithParam<KeyChange> {
 protected:
  LinkKey() {
    write_key(folder(), "a.key", "a pass phrase of one key\n");
    write_key(folder(), "b.key", "a pass phrase of another\n");
  }
  const TemporaryFolder& folder() const { return fixture_.folder; }
  casd::Topology parse(const std::string& link) const {
    return fixture_.parse(
        "schema: 1\nlinks:\n  - {name: other, type: udp, local: '127.0.0.1:0'}\n"
        "  - " +
        link + "\n");
  }
  /// The first of the two that is another value than before.
  casd::Topology after(const casd::Topology& before) const {
    for (const std::string& link : GetParam().after) {
      if (link.empty()) continue;
      casd::Topology topology = parse(link);
      if (topology != before) return topology;
    }
    throw std::runtime_error("no other value");
  }
  CasdFixture fixture_;
};

TEST_P(LinkKey, MakesItsLinkAnewAndNoOther) {
  const casd::Topology topology = parse(GetParam().before);
  casd::LinkSet links(topology);
  links.figures().keep_ledgers();  // each link that is made has one of its own
  links.start();
  const auto before = links.figures().ledgers();
  links.reload(topology);
  EXPECT_EQ(links.figures().ledgers(), before);  // nothing has changed
  links.reload(after(topology));
  const auto after = links.figures().ledgers();
  EXPECT_EQ(after.at("other"), before.at("other"));
  ASSERT_EQ(after.size(), 2U);
  for (const auto& [name, ledger] : after) {
    if (name == "other") continue;
    EXPECT_NE(ledger, before.at(topology.links[1].name));
  }
}

// Those of every link once, and those of each type.
std::vector<KeyChange> all_link_changes() {
  std::vector<KeyChange> changes;
  std::set<std::string> seen;
  for (int i = 0; i <= static_cast<int>(casd::LinkType::kTlog); ++i) {
    for (KeyChange& change : link_changes(static_cast<casd::LinkType>(i))) {
      if (seen.insert(change.key).second) changes.push_back(std::move(change));
    }
  }
  return changes;
}

INSTANTIATE_TEST_SUITE_P(Link, LinkKey, testing::ValuesIn(all_link_changes()),
                         [](const auto& test) { return test_name(test.param.key); });

TEST(ReloadKeys, RefuseAnotherSigningKeyInTheSameFile) {
  CasdFixture fixture;
  write_key(fixture.folder, "a.key", "a pass phrase of one key\n");
  const std::string yaml = "schema: 1\nlinks:\n  - " + std::string(kSignedLink) + "\n";
  casd::LinkSet links(fixture.parse(yaml));
  links.reload(fixture.parse(yaml));
  write_key(fixture.folder, "a.key", "a pass phrase of another\n");
  EXPECT_THAT(refusal([&] { links.reload(fixture.parse(yaml)); }), HasSubstr("a.key"));
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
    {"rates.max_hz", "from: fcu, to: sim, rates: {HIL_CONTROLS: {max_hz: 0.001}}", 1, kOpen, 2},
    {"rates.every", kOpen, 2, "from: fcu, to: sim, rates: {HIL_CONTROLS: {every: 2}}", 1},
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

TEST(ReloadKeys, EachHasACase) {
  std::set<std::string> tested;
  for (const InForceCase& test : kInForce) tested.insert(test.key);
  for (const RouteCase& test : kRouteKeys) tested.insert(test.key);
  std::vector<base::KeyRow> rows = casd::reload_rows();
  for (base::KeyRow& row : casd::route_rows()) rows.push_back(std::move(row));
  for (const base::KeyRow& row : rows) {
    if (row.key == "links" || row.key == "routes") continue;  // their keys
    EXPECT_TRUE(tested.contains(row.key)) << "no test says what a reload does with " << row.key;
  }
}

}  // namespace
}  // namespace cas::test
