// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>
#include <sched.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <thread>

#include "base/rpc/client.hpp"
#include "tests/base/rpc/raw_client.hpp"
#include "tests/loopback/casd_fixture.hpp"
#include "tests/loopback/running_casd.hpp"
#include "tests/support/ended_with.hpp"
#include "tests/support/paths.hpp"

namespace cas::test {
namespace {

using base::rpc::RawClient;
using nlohmann::json;

constexpr const char* kLabDialect = R"(<?xml version="1.0"?>
<mavlink><messages>
  <message id="54321" name="LAB_THING">
    <description>A thing.</description>
    <field type="uint8_t" name="state">State.</field>
    <field type="float" name="heat" units="degC">Heat.</field>
  </message>
</messages></mavlink>)";

/// A packet of a private message: state 7, heat 42.
std::vector<std::uint8_t> lab_thing(std::uint8_t crc_extra) {
  std::vector<std::uint8_t> packet{0xFD, 5, 0, 0, 0, 1, 200, 0x31, 0xD4, 0, 0, 0, 0x28, 0x42, 7};
  packet.resize(packet.size() + 2);
  mav::detail::append_checksum(packet.data(), packet.size() - 2, crc_extra);
  return packet;
}

class CasdObserve : public testing::Test {
 protected:
  void start(const std::string& more) {
    const auto file = fixture.folder.write(
        "topology.yaml", fixture.expand("command_port: {port: 0, loopback_without_token: true}\n" +
                                        more + kHilTopology));
    casd.emplace(std::vector<std::string>{kCasdProgram, file});
    fixture.sim.set_remote(casd->port("sim"));
  }
  json call(const std::string& method, const json& params = json::object()) {
    return casd->call(method, params);
  }
  /// All that an HTTP server answers to these bytes.
  std::vector<std::string> http(const std::string& request) {
    RawClient raw(casd->port("metrics"));
    EXPECT_TRUE(raw.send(request));
    std::vector<std::string> lines;
    while (auto line = raw.line()) lines.push_back(*line);
    return lines;
  }

  CasdFixture fixture;
  std::optional<RunningCasd> casd;
};

TEST_F(CasdObserve, PublishesDropsThatTheRulesAloneMake) {
  start("");
  call("subscribe", {{"topic", "drops"}});
  fixture.sim.send(fixture.from_sim(mavlink::common::HilStateQuaternion{}));  // no route
  // casd's own heartbeat may have met the serial line before it was open: a drop of another link.
  std::optional<json> of_sim;
  while (!of_sim) {
    std::string topic;
    json told;
    ASSERT_TRUE(casd->client().next_notification(topic, told, kPatience));
    ASSERT_EQ(topic, "drops");
    for (const json& drop : told.at("dropped")) {
      if (drop.at("link") == "sim") of_sim = drop;
    }
  }
  EXPECT_EQ(of_sim->at("name"), "HIL_STATE_QUATERNION");
  EXPECT_EQ(of_sim->at("cause"), "no_rule");
}

TEST_F(CasdObserve, ListsMessagesAndDropsByPageAndLink) {
  start("");
  fixture.sim.send(fixture.from_sim(hil_sensor(1)));
  fixture.sim.send(fixture.from_sim(mavlink::common::HilStateQuaternion{}));  // no route
  const auto drops_of_sim = [this](const json& params) {
    return call("link.drops", params).at("dropped");
  };
  ASSERT_TRUE(wait_until([&] {
    return std::ranges::any_of(drops_of_sim({{"link", "sim"}}), [](const json& drop) {
      return drop.at("name") == "HIL_STATE_QUATERNION";
    });
  }));
  EXPECT_EQ(drops_of_sim({{"link", "sim"}, {"limit", 1}}).size(), 1U);
  EXPECT_TRUE(drops_of_sim({{"link", "sim"}, {"offset", 1000}}).empty());
  const json all = call("message.list", {{"link", "sim"}});
  ASSERT_GE(all.size(), 3U);  // received twice, dropped once
  const json first = call("message.list", {{"link", "sim"}, {"limit", 1}});
  ASSERT_EQ(first.size(), 1U);
  EXPECT_EQ(first[0].at("name"), all[0].at("name"));
  const json rest = call("message.list", {{"link", "sim"}, {"offset", 1}});
  EXPECT_GE(rest.size() + 1, all.size());
  EXPECT_NE(rest.at(0), first.at(0));
  EXPECT_THROW(call("link.drops", {{"link", "none"}}), base::rpc::CallError);
  EXPECT_THROW(call("message.list", {{"limit", 0}}), base::rpc::CallError);
}

TEST_F(CasdObserve, TellsPrometheusItsFigures) {
  start("metrics: {port: 0}\n");
  fixture.sim.send(fixture.from_sim(hil_sensor(1)));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == 1; }));
  const auto lines = http("GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n");
  const auto has = [&](const std::string& wanted) {
    return std::find(lines.begin(), lines.end(), wanted) != lines.end();
  };
  ASSERT_FALSE(lines.empty());
  EXPECT_EQ(lines.front(), "HTTP/1.1 200 OK\r");
  EXPECT_TRUE(has("# TYPE casd_link_rx_packets_total counter"));
  EXPECT_TRUE(has("casd_link_rx_packets_total{link=\"sim\"} 1"));
  EXPECT_TRUE(has("casd_command_refused_total{reason=\"not_json_rpc\"} 0"));
  EXPECT_TRUE(has("casd_link_up{link=\"fcu\",type=\"serial\"} 1"));
  EXPECT_TRUE(has("# TYPE casd_vehicle_armed gauge"));
  EXPECT_TRUE(
      has("casd_messages_total{link=\"sim\",direction=\"rx\",message=\"HIL_SENSOR\","
          "system=\"1\",component=\"200\"} 1"));
}

TEST_F(CasdObserve, TellsPrometheusOfALinkThatIsDown) {
  start("metrics: {port: 0}\n");
  fixture.fcu.hang_up();
  EXPECT_TRUE(wait_until([&] {
    const auto lines = http("GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n");
    return std::find(lines.begin(), lines.end(), "casd_link_up{link=\"fcu\",type=\"serial\"} 0") !=
           lines.end();
  }));
}

TEST_F(CasdObserve, AnswersOnlyGetOfMetricsOverHttp) {
  start("metrics: {port: 0}\n");
  EXPECT_EQ(http("GET / HTTP/1.1\r\n\r\n").front(), "HTTP/1.1 404 Not Found\r");
  EXPECT_EQ(http("POST /metrics HTTP/1.1\r\n\r\n").front(), "HTTP/1.1 405 Method Not Allowed\r");
  EXPECT_TRUE(http("no HTTP at all\r\n\r\n").empty());
  EXPECT_TRUE(http("GET /" + std::string(20'000, 'x') + " HTTP/1.1\r\n\r\n").empty());
}

TEST_F(CasdObserve, AnswersScrapersAmongClientsThatNeverFinishARequest) {
  start("metrics: {port: 0}\n");
  std::vector<RawClient> slow;
  for (int i = 0; i < 300; ++i) slow.emplace_back(casd->port("metrics")).send("GET /metr");
  const base::RunTime begin = base::steady_now();
  EXPECT_EQ(http("GET /metrics HTTP/1.1\r\n\r\n").front(), "HTTP/1.1 200 OK\r");
  EXPECT_LT(base::steady_now() - begin, std::chrono::seconds(2));
  EXPECT_EQ(call("link.list").size(), 2U);
}

TEST_F(CasdObserve, AnswersAllWhoAskAtOnceWithOnePage) {
  start("metrics: {port: 0}\n");
  const base::RunTime begin = base::steady_now();
  std::set<std::string> pages;
  constexpr int kScrapes = 15;
  for (int i = 0; i < kScrapes; ++i) {
    for (const std::string& line : http("GET /metrics HTTP/1.1\r\nHost: x\r\n\r\n")) {
      if (line.starts_with("casd_uptime_seconds ")) pages.insert(line);
    }
  }
  // Each page lasts a quarter of a second.
  const double quarters = base::to_seconds(base::steady_now() - begin) / 0.25;
  EXPECT_GE(pages.size(), 1U);
  EXPECT_LE(static_cast<double>(pages.size()), quarters + 1);
}

TEST_F(CasdObserve, AnswersAHastyScraperAndKeepsTheOthersGoing) {
  start("metrics: {port: 0}\n");
  for (int i = 0; i < 30; ++i) {
    EXPECT_EQ(http("GET /metrics HTTP/1.1\r\n\r\n").front(), "HTTP/1.1 200 OK\r");
  }
  fixture.sim.send(fixture.from_sim(hil_sensor(1)));
  EXPECT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == 1; }));
  EXPECT_EQ(call("link.list").size(), 2U);
}

TEST_F(CasdObserve, ServesMetricsBehindItsOtherThreads) {
  start("metrics: {port: 0}\n");
  const std::string tasks = "/proc/" + std::to_string(casd->pid()) + "/task";
  // The thread is there when it has answered.
  EXPECT_FALSE(http("GET /metrics HTTP/1.1\r\n\r\n").empty());
  int found = 0;
  for (const auto& task : std::filesystem::directory_iterator(tasks)) {
    const int policy = ::sched_getscheduler(std::stoi(task.path().filename().string()));
    if (TemporaryFolder::read(task.path() / "comm") != "metrics\n") {
      EXPECT_NE(policy, SCHED_BATCH);
      continue;
    }
    EXPECT_EQ(policy, SCHED_BATCH);
    ++found;
  }
  EXPECT_EQ(found, 1);
}

/// Processor time of casd's main thread so far.
double main_thread_s(pid_t pid) {
  const std::string id = std::to_string(pid);
  std::istringstream stat(TemporaryFolder::read("/proc/" + id + "/task/" + id + "/stat"));
  std::string word;
  double ticks = 0;
  for (int field = 1; field <= 15 && stat >> word; ++field) {
    if (field >= 14) ticks += std::stod(word);  // utime, stime
  }
  return ticks / static_cast<double>(::sysconf(_SC_CLK_TCK));
}

TEST_F(CasdObserve, GivesAllWhoAskWithoutAPauseAShareOfAProcessor) {
  start("");
  const std::uint16_t port = casd->port("command_port");
  std::atomic<bool> over{false};
  std::atomic<int> answers{0};
  std::vector<std::thread> pollers;
  const double before_s = main_thread_s(casd->pid());
  const base::RunTime begin = base::steady_now();
  for (int i = 0; i < 8; ++i) {
    pollers.emplace_back([&] {
      RawClient asks(port);
      while (!over && asks.send("{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"casd.status\"}\n") &&
             asks.line()) {
        ++answers;
      }
    });
  }
  // Another client is answered meanwhile, and packets pass.
  for (int i = 1; i <= 20; ++i) {
    EXPECT_EQ(call("link.list").size(), 2U);
    fixture.sim.send(fixture.from_sim(hil_sensor(static_cast<std::uint64_t>(i))));
    fixture.collect();
  }
  EXPECT_TRUE(wait_until([&] { return base::steady_now() - begin > std::chrono::seconds(3); }));
  const double wall_s = base::to_seconds(base::steady_now() - begin);
  const double used_s = main_thread_s(casd->pid()) - before_s;
  over = true;
  for (std::thread& poller : pollers) poller.join();
  EXPECT_GT(answers, 8);
  // Some hundredths, and the socket cost that the budget does not count; without the bound it is a
  // whole processor.
  EXPECT_LE(used_s, 0.1 + 0.4 * wall_s);
  EXPECT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == 20; }));
}

TEST_F(CasdObserve, ShowsMessagesOfADialectReadAtRunTime) {
  fixture.folder.write("lab.xml", kLabDialect);
  start("dialect: lab.xml\n");
  const json asked{{"link", "sim"}, {"message", "LAB_THING"}, {"system", 1}, {"component", 200}};
  EXPECT_EQ(call("message.value", asked).at("id"), 54321);
  json value;
  EXPECT_TRUE(wait_until([&] {
    fixture.sim.send(lab_thing(77));
    value = call("message.value", asked);
    return !value.at("fields").is_null();
  }));
  EXPECT_EQ(value.at("name"), "LAB_THING");
  EXPECT_EQ(value.at("fields").at(1), (json{{"name", "heat"}, {"units", "degC"}, {"value", 42}}));
  const json listed = call("message.list");
  EXPECT_TRUE(
      std::ranges::any_of(listed, [](const json& row) { return row.at("name") == "LAB_THING"; }));
  ChildProcess casctl({cas::test::binary_dir() + "/bin/casctl", "--address", casd->address(),
                       "message", "lab_thing", "--json", "--wait"});
  // It needs one that comes while it looks, also on a machine where it starts late.
  std::optional<int> code;
  EXPECT_TRUE(wait_until([&] {
    fixture.sim.send(lab_thing(77));
    code = casctl.wait_exit(std::chrono::milliseconds(50));
    return code.has_value();
  }));
  EXPECT_EQ(code, 0) << casctl.output();
  EXPECT_EQ(json::parse(casctl.output()).at("fields"), (json{{"state", 7}, {"heat", 42}}));
}

TEST_F(CasdObserve, RefusesABadDialectAtTheStartAndAtAReload) {
  fixture.folder.write("lab.xml", kLabDialect);
  start("dialect: lab.xml\n");
  fixture.folder.write("lab.xml", "<mavlink><messages>");
  EXPECT_THROW(call("casd.reload"), base::rpc::CallError);
  EXPECT_EQ(call("message.value",
                 {{"link", "sim"}, {"message", "LAB_THING"}, {"system", 1}, {"component", 200}})
                .at("id"),
            54321);
  EXPECT_THAT(ChildProcess({kCasdProgram, (fixture.folder / "topology.yaml").string()}).end(),
              EndedWith(78, "lab.xml"));
}

TEST(CasdLatency, TellsRoutesApartAndTimesTheEcho) {
  CasdFixture fixture(kHilTopology);
  fixture.sim.send(fixture.from_sim(hil_sensor(7)));
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_fcu.count(kHilSensor) == 1; }));
  fixture.fcu.write(fixture.from_fcu(hil_controls(7)));
  fixture.fcu.write(fixture.from_fcu(hil_controls(8)));  // no sensor has stamp 8
  ASSERT_TRUE(fixture.collect_until([&] { return fixture.at_sim.count(kHilControls) == 2; }));

  const auto echo = fixture.links().echo().figures();
  ASSERT_EQ(echo.size(), 1U);
  EXPECT_EQ(echo[0].matched, 1U);
  EXPECT_EQ(echo[0].unmatched, 1U);
  EXPECT_GT(echo[0].max, base::Duration{});

  ASSERT_TRUE(wait_until([&] { return fixture.status("sim").tx.packets == 2; }));
  const auto routes = fixture.status("sim").tx.routes;
  ASSERT_EQ(routes.size(), 1U);
  EXPECT_EQ(routes[0].from, fixture.status("fcu").id);
  EXPECT_EQ(routes[0].count, 2U);
}

}  // namespace
}  // namespace cas::test
