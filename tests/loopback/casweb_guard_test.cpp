// SPDX-License-Identifier: BSD-3-Clause
// Who may reach casweb, and the effect of a misbehaving page on others. casd is not needed here.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <vector>

#include "base/rpc/message.hpp"
#include "base/time/clock.hpp"
#include "tests/loopback/casweb_fixture.hpp"
#include "tests/loopback/tcp_peer.hpp"
#include "tests/support/ended_with.hpp"

namespace cas::test {
namespace {

using nlohmann::json;

class CaswebGuard : public testing::Test {
 protected:
  TemporaryFolder nowhere_;
  CaswebFixture casweb_{nowhere_.path()};
};

TEST_F(CaswebGuard, ServesThePageUnderAPolicyThatLetsNothingElseIn) {
  const HttpAnswer page = http_request(casweb_.port(), "GET", "/", casweb_.host());
  EXPECT_EQ(page.status, 200);
  EXPECT_NE(page.body.find("the page"), std::string::npos);
  const std::string& policy = page.headers.at("Content-Security-Policy");
  EXPECT_EQ(policy.find("unsafe"), std::string::npos) << policy;
  EXPECT_EQ(policy.rfind("default-src 'none'", 0), 0U) << policy;
  EXPECT_NE(policy.find("frame-ancestors 'none'"), std::string::npos) << policy;
  EXPECT_EQ(page.headers.at("X-Content-Type-Options"), "nosniff");
  EXPECT_EQ(page.headers.at("Cache-Control"), "no-store");
  EXPECT_FALSE(page.headers.contains("Access-Control-Allow-Origin"));

  EXPECT_EQ(http_request(casweb_.port(), "GET", "/../token", casweb_.host()).status, 404);
  EXPECT_EQ(http_request(casweb_.port(), "POST", "/", casweb_.host()).status, 405);
  EXPECT_EQ(http_request(casweb_.port(), "GET", "/mesh/x", casweb_.host()).status, 400);
  EXPECT_EQ(http_request(casweb_.port(), "GET", "/rpc", casweb_.host()).status, 426);
  EXPECT_EQ(
      http_request(casweb_.port(), "GET", "/" + std::string(10'000, 'x'), casweb_.host()).status,
      431);
}

TEST_F(CaswebGuard, RefusesAHostThatIsNotItsOwn) {
  for (const std::string host : {"evil.example", "evil.example:5791", "localhost", ""}) {
    EXPECT_EQ(http_request(casweb_.port(), "GET", "/", host).status, 421) << host;
  }
  EXPECT_EQ(WebPage(casweb_.port(), "evil.example", "http://evil.example").refusal(), 421);
}

TEST_F(CaswebGuard, RefusesThePageOfAnotherOrigin) {
  for (const std::string origin : {"http://evil.example", "http://127.0.0.1:1", "null", ""}) {
    EXPECT_EQ(WebPage(casweb_.port(), casweb_.host(), origin).refusal(), 403) << origin;
  }
  EXPECT_EQ(WebPage(casweb_.port()).refusal(), 0);
}

TEST_F(CaswebGuard, TellsNothingWithoutTheToken) {
  WebPage page(casweb_.port());
  page.send(R"({"jsonrpc":"2.0","id":7,"method":"bench.status"})");
  const auto early = page.wait_for([](const json&) { return true; });
  ASSERT_TRUE(early);
  EXPECT_EQ(early->at("error").at("code"), base::rpc::kNotAuthorised);
  EXPECT_EQ(early->at("id"), 7);
  // Malformed requests get an answer, too.
  const std::string deep(30'000, '[');
  for (const std::string& text :
       {std::string("no JSON"), std::string(R"({"method":5})"), deep,
        R"({"method":"hello","params":[],"id":)" + deep + std::string(deep.size(), ']') + "}"}) {
    WebPage stranger(casweb_.port());
    stranger.send(text);
    const auto answer = stranger.wait_for([](const json&) { return true; });
    ASSERT_TRUE(answer);
    EXPECT_EQ(answer->at("error").at("code"), base::rpc::kNotAuthorised);
  }
  const json refused = page.hello("another token of the tests");
  EXPECT_EQ(refused.at("error").at("code"), base::rpc::kNotAuthorised);
  EXPECT_EQ(page.wait_closed(), 4403);

  WebPage none(casweb_.port());
  EXPECT_TRUE(none.call("hello", {{"protocol", 2}}).contains("error"));
  EXPECT_EQ(none.wait_closed(), 4403);
  WebPage token(casweb_.port());  // casweb never asks for it, and it opens nothing
  EXPECT_TRUE(
      token.call("hello", {{"protocol", 2}, {"token", CaswebFixture::kToken}}).contains("error"));
  EXPECT_EQ(token.wait_closed(), 4403);
}

TEST_F(CaswebGuard, ProvesThatItKnowsTheTokenAndDoesNotTellIt) {
  WebPage page(casweb_.port());
  const json answer = page.exchange_nonces().at("result");
  EXPECT_EQ(answer.dump().find(CaswebFixture::kToken), std::string::npos);
  EXPECT_EQ(answer.at("proof").get<std::string>().size(), 64U);
  EXPECT_NE(answer.at("proof"), page.proof(CaswebFixture::kToken)) << "its own is no page's";
  WebPage again(casweb_.port());
  EXPECT_NE(again.exchange_nonces().at("result").at("nonce"), answer.at("nonce"));
  EXPECT_TRUE(page.call("hello", {{"protocol", 2}, {"nonce", "short"}}).contains("error"));
}

TEST_F(CaswebGuard, AStolenProofOpensNothing) {
  WebPage owner(casweb_.port());
  owner.exchange_nonces();
  const std::string stolen = owner.proof(CaswebFixture::kToken);
  ASSERT_TRUE(owner.call("hello", {{"protocol", 2}, {"proof", stolen}}).contains("result"));
  WebPage thief(casweb_.port());
  thief.exchange_nonces();
  EXPECT_TRUE(thief.call("hello", {{"protocol", 2}, {"proof", stolen}}).contains("error"));
  EXPECT_EQ(thief.wait_closed(), 4403);
  WebPage early(casweb_.port());  // before any nonce
  EXPECT_TRUE(early.call("hello", {{"protocol", 2}, {"proof", stolen}}).contains("error"));
  EXPECT_EQ(early.wait_closed(), 4403);
  // One that another program was given at its own port, and passes on.
  WebPage relay(casweb_.port());
  relay.exchange_nonces();
  const std::string elsewhere = relay.proof(CaswebFixture::kToken, "127.0.0.1:5791");
  EXPECT_TRUE(relay.call("hello", {{"protocol", 2}, {"proof", elsewhere}}).contains("error"));
  EXPECT_EQ(relay.wait_closed(), 4403);
}

TEST_F(CaswebGuard, KeepsTheTokenOutOfItsOutputAndInAFileOfItsOwner) {
  EXPECT_EQ(casweb_.program().output().find(CaswebFixture::kToken), std::string::npos);
  EXPECT_EQ(TemporaryFolder::read(casweb_.address_file()),
            "http://" + casweb_.host() + "/#k=" + CaswebFixture::kToken + "\n");
  struct stat status {};
  ASSERT_EQ(::stat(casweb_.address_file().c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777U, 0600U);
}

TEST_F(CaswebGuard, ClosesAPageThatSpeaksNoJson) {
  auto page = casweb_.open_page();
  page->send("no JSON");
  EXPECT_EQ(page->wait_closed(), 1008);
  auto large = casweb_.open_page();
  large->send(std::string(70'000, ' '));
  EXPECT_EQ(large->wait_closed(), 1009);
}

TEST_F(CaswebGuard, HasPlacesForSixteenPages) {
  std::vector<std::unique_ptr<WebPage>> pages;
  for (int i = 0; i < 16; ++i) pages.push_back(casweb_.open_page());
  EXPECT_EQ(WebPage(casweb_.port()).refusal(), 503);
  pages.pop_back();
  EXPECT_TRUE(wait_until([&] { return WebPage(casweb_.port()).refusal() == 0; }));
}

TEST_F(CaswebGuard, StrangersLockNobodyOut) {
  std::vector<std::unique_ptr<WebPage>> strangers;
  for (int i = 0; i < 70; ++i) {  // more than there are places for them
    strangers.push_back(std::make_unique<WebPage>(casweb_.port()));
    EXPECT_EQ(strangers.back()->refusal(), 0);
  }
  auto page = casweb_.open_page();
  for (int i = 0; i < 70; ++i) {
    strangers.push_back(std::make_unique<WebPage>(casweb_.port()));
  }
  EXPECT_TRUE(page->call("bench.status", json::object()).contains("result"));
}

TEST_F(CaswebGuard, HalfRequestsOfStrangersKeepNobodyOut) {
  const std::string text = "GET / HTTP/1.1\r\nHo";
  const std::vector<std::uint8_t> half(text.begin(), text.end());
  for (int i = 0; i < 2000; ++i) {
    TcpPeer stranger(casweb_.port());
    ASSERT_TRUE(stranger.connected());
    stranger.send(half);
  }
  // On a busy machine, where casweb steps back (nice 10), many of them are still to be taken in,
  // and the newest caller may pay for that.
  constexpr auto kTakenIn = std::chrono::seconds(90);
  EXPECT_TRUE(wait_until(
      [&] { return http_request(casweb_.port(), "GET", "/", casweb_.host()).status == 200; },
      kTakenIn));
  EXPECT_TRUE(wait_until([&] { return WebPage(casweb_.port()).refusal() == 0; }, kTakenIn));
  EXPECT_TRUE(casweb_.open_page()->call("bench.status", json::object()).contains("result"));
}

TEST_F(CaswebGuard, ChangesThatAreRefusedDelayNoLaterOne) {
  auto page = casweb_.open_page();
  const auto is_limited = [&](const char* method) {
    const json error = page->call(method, json::object()).at("error");
    return error.at("message") == "over 16 changes in a second: wait";
  };
  int more = 1000;
  while (!is_limited("vehicle.rtl") && more > 0) --more;
  EXPECT_FALSE(is_limited("vehicle.land"));
  EXPECT_FALSE(is_limited("vehicle.hold"));
  EXPECT_FALSE(is_limited("vehicle.disarm"));
  EXPECT_TRUE(wait_until([&] { return !is_limited("vehicle.rtl"); })) << "though it is repeated";
}

TEST_F(CaswebGuard, SaysWhichProgramIsMissing) {
  auto page = casweb_.open_page();
  const json status = page->call("bench.status", json::object()).at("result");
  EXPECT_EQ(status.at("programs")[0].at("name"), "hilsim");
  EXPECT_EQ(status.at("programs")[0].at("state"), "down");
  const json refused = page->call("vehicle.land", json::object());
  EXPECT_EQ(refused.at("error").at("code"), base::rpc::kRefused);
}

TEST_F(CaswebGuard, RefusesToOverruleTheInterlockAndParametersThatItDoesNotKnow) {
  auto page = casweb_.open_page();
  EXPECT_EQ(page->call("vehicle.arm", {{"not_hil", true}}).at("error").at("code"),
            base::rpc::kInterlock);
  EXPECT_EQ(page->call("vehicle.command", {{"command", 400}}).at("error").at("code"),
            base::rpc::kMethodNotFound);
  EXPECT_EQ(page->call("watch", {{"topics", json::object()}, {"x", 1}}).at("error").at("code"),
            base::rpc::kInvalidParams);
  EXPECT_EQ(page->call("watch", {{"topics", {{"x", 1}}}}).at("error").at("code"),
            base::rpc::kInvalidParams);
  EXPECT_EQ(page->call("pilot.take", {{"vehicle", 257}}).at("error").at("code"),
            base::rpc::kInvalidParams)
      << "not vehicle 1";
}

TEST_F(CaswebGuard, EndsInGoodOrderWithPagesOpen) {
  auto page = casweb_.open_page();
  casweb_.program().signal(SIGTERM);
  EXPECT_EQ(casweb_.program().wait_exit(), 0) << casweb_.program().output();
}

/// All that the page's document names is there.
TEST(CaswebPage, ThatWasBuiltIsServedWhole) {
  const std::string folder = cas::test::binary_dir() + "/share/cas/web";
  if (!std::filesystem::exists(folder + "/index.html")) GTEST_SKIP() << "the page was not built";
  const TemporaryFolder nowhere;
  CaswebFixture casweb(nowhere.path(), {}, folder);
  const HttpAnswer page = http_request(casweb.port(), "GET", "/", casweb.host());
  ASSERT_EQ(page.status, 200);
  const std::regex named("(?:src|href)=\"?(/[^\" >]+)");
  int files = 0;
  for (std::sregex_iterator each(page.body.begin(), page.body.end(), named), end; each != end;
       ++each, ++files) {
    const std::string file = (*each)[1];
    const HttpAnswer answer = http_request(casweb.port(), "GET", file, casweb.host());
    EXPECT_EQ(answer.status, 200) << file;
    EXPECT_FALSE(answer.body.empty()) << file;
  }
  EXPECT_GE(files, 2) << page.body;
}

TEST(CaswebReadOnly, ShowsAndChangesNothing) {
  const TemporaryFolder nowhere;
  CaswebFixture casweb(nowhere.path(), {"--read-only"});
  WebPage page(casweb.port());
  const json greeting = page.hello(CaswebFixture::kToken).at("result");
  EXPECT_EQ(greeting.at("read_only"), true);
  for (const json& method : greeting.at("methods")) {
    EXPECT_NE(method, "vehicle.arm");
    EXPECT_NE(method, "sim.pause");
  }
  for (const char* method : {"vehicle.arm", "param.set", "sim.reset", "pilot.take"}) {
    EXPECT_EQ(page.call(method, json::object()).at("error").at("code"), base::rpc::kNotAuthorised)
        << method;
  }
}

TEST(CaswebStart, RefusesAnAddressThatOthersReachWithoutATokenFile) {
  EXPECT_THAT(
      ChildProcess({cas::test::binary_dir() + "/bin/casweb", "--listen", "0.0.0.0:0"}).end(),
      EndedWith(78, "--token-file must be given"));
}

}  // namespace
}  // namespace cas::test
