// SPDX-License-Identifier: BSD-3-Clause
// casweb against programs that answer late, long or wrongly.
#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "tests/loopback/casweb_fixture.hpp"
#include "tests/loopback/fake_program.hpp"

namespace cas::test {
namespace {

using nlohmann::json;

/// Waits until casweb has found casd.
bool finds_casd(WebPage& page) {
  return wait_until([&] {
    const json status = page.call("bench.status", json::object()).at("result");
    return status.at("programs")[1].at("state") == "up";
  });
}

TEST(CaswebPrograms, AnAnswerOfAnotherShapeEndsNoTopic) {
  const TemporaryFolder folder;
  std::atomic<int> asked{0};
  const FakeProgram casd(folder / "casd.sock", [&asked](const std::string& method, const json&) {
    if (method != "link.echo") return json::object();
    if (++asked == 1) return json{5};  // no vehicle's figures
    return json{{{"vehicle", 1}, {"count", 7}}};
  });
  CaswebFixture casweb(folder.path());
  auto page = casweb.open_page();
  ASSERT_TRUE(finds_casd(*page));
  page->call("watch", {{"topics", {{"loop", 1}}}});
  const auto loop = page->next("snap.loop");
  ASSERT_TRUE(loop);
  EXPECT_EQ(loop->at("vehicles")[0].at("count"), 7);
}

TEST(CaswebPrograms, ARunOfHilsTellsItsReferenceItsLimitsAndItsVerdict) {
  const TemporaryFolder folder;
  std::atomic<int> subscribed{0};
  std::atomic<bool> told{false};
  FakeProgram hils(folder / "hils.sock", [&](const std::string& method, const json& params) {
    if (method == "run.reference") return json{{"t_s", 3.5}, {"v", json::array()}};
    if (method == "run.status") return json::object({{"state", "running"}});
    if (method == "fault.inject") return params;
    subscribed += method == "subscribe" ? 1 : 0;
    if (method == "run.told") told = true;
    return json::object();
  });
  CaswebFixture casweb(folder.path(), {"--hils", (folder / "hils.sock").string()});
  auto page = casweb.open_page();
  ASSERT_TRUE(wait_until([&] { return subscribed == 2; }));
  page->call("watch", {{"topics", {{"ref", 20}, {"verdict", 2}}}});
  const auto reference = page->next("snap.ref");
  ASSERT_TRUE(reference);
  EXPECT_EQ(reference->at("t_s"), 3.5);
  const auto status = page->next("snap.verdict");
  ASSERT_TRUE(status);
  EXPECT_EQ(status->at("state"), "running");
  const json fault{{"drop", "gps"}, {"for_s", 1}};
  EXPECT_EQ(page->call("fault.inject", fault).at("result"), fault);
  hils.notify("verdict", {{"state", "passed"}});
  const auto verdict = page->next("event.verdict");
  ASSERT_TRUE(verdict);
  EXPECT_EQ(verdict->at("state"), "passed");
  EXPECT_TRUE(wait_until([&] { return told.load(); })) << "hils waits for it";
}

TEST(CaswebPrograms, WithoutARunOfHilsThereAreNoFaultsByHand) {
  const TemporaryFolder folder;
  CaswebFixture casweb(folder.path());
  auto page = casweb.open_page();
  const json refused = page->call("fault.inject", {{"drop", "gps"}, {"for_s", 1}});
  EXPECT_EQ(refused.at("error").at("message"), "no run of hils is shown here");
  EXPECT_TRUE(page->call("watch", {{"topics", {{"ref", 20}}}}).contains("error"));
}

TEST(CaswebPrograms, ALongAnswerReachesAPageThatReads) {
  const TemporaryFolder folder;
  const std::string long_text(3U << 20, 'x');
  const FakeProgram casd(folder / "casd.sock",
                         [&long_text](const std::string& method, const json&) {
                           return method == "link.routes" ? json(long_text) : json::object();
                         });
  CaswebFixture casweb(folder.path());
  auto page = casweb.open_page();
  ASSERT_TRUE(finds_casd(*page));
  EXPECT_EQ(page->call("link.routes", json::object()).at("result"), long_text);
}

TEST(CaswebPrograms, AMeshIsFetchedOnceForAllWhoAskForIt) {
  const TemporaryFolder folder;
  std::atomic<int> asked{0};
  std::atomic<bool> may_answer{false};
  const FakeProgram hilsim(folder / "hilsim.sock", [&](const std::string& method, const json&) {
    if (method != "sim.mesh") return json::object();
    ++asked;
    wait_until([&] { return may_answer.load(); });
    return json{{"bytes", 3}, {"base64", "Zm9v"}};
  });
  CaswebFixture casweb(folder.path());
  auto page = casweb.open_page();
  ASSERT_TRUE(
      wait_until([&] { return page->call("sim.scene", json::object()).contains("result"); }));
  const std::string target = "/mesh/" + std::string(64, 'a');
  std::vector<std::string> bodies(4);
  std::vector<std::jthread> threads;
  for (std::string& body : bodies) {
    threads.emplace_back(
        [&] { body = http_request(casweb.port(), "GET", target, casweb.host()).body; });
  }
  EXPECT_TRUE(wait_until([&] { return asked > 0; }));
  for (int i = 0; i < 20; ++i) page->call("bench.status", json::object());  // the others come
  may_answer = true;
  threads.clear();
  for (const std::string& body : bodies) EXPECT_EQ(body, "foo");
  EXPECT_EQ(asked, 1);
}

TEST(CaswebPrograms, AMeshOverTheBoundIsRefused) {
  const TemporaryFolder folder;
  const FakeProgram hilsim(folder / "hilsim.sock", [](const std::string& method, const json&) {
    if (method != "sim.mesh") return json::object();
    return json{{"bytes", (64U << 20) + 1}, {"base64", "Zm9v"}};
  });
  CaswebFixture casweb(folder.path());
  auto page = casweb.open_page();
  ASSERT_TRUE(
      wait_until([&] { return page->call("sim.scene", json::object()).contains("result"); }));
  EXPECT_EQ(
      http_request(casweb.port(), "GET", "/mesh/" + std::string(64, 'a'), casweb.host()).status,
      404);
}

TEST(CaswebPrograms, SaysWhyASocketCannotBeTried) {
  const TemporaryFolder folder;
  CaswebFixture casweb(folder / std::string(120, 'x'));
  auto page = casweb.open_page();
  EXPECT_TRUE(wait_until([&] {
    const json status = page->call("bench.status", json::object()).at("result");
    return status.at("programs")[1]
        .value("reason", "")
        .ends_with("casd.sock: the path is too long for a Unix socket");
  }));
}

}  // namespace
}  // namespace cas::test
