// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/dispatcher.hpp"

#include <gtest/gtest.h>

#include <new>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <vector>

#include "base/error.hpp"

namespace cas::base::rpc {
namespace {

class FakePeer final : public Peer {
 public:
  void deliver(std::string line) override { lines.push_back(std::move(line)); }
  std::size_t room() const override { return most_bytes - held_bytes; }
  void on_refused() override { refused = true; }
  std::size_t most_bytes = 1 << 20;
  std::vector<std::string> lines;
  bool refused = false;
};

class DispatcherTest : public testing::Test {
 protected:
  DispatcherTest() {
    dispatcher_.add_method("echo", [](const Json& params, Reply reply) { reply.result(params); });
    dispatcher_.add_method("keep",
                           [this](const Json&, Reply reply) { kept_.push_back(std::move(reply)); });
    dispatcher_.add_method("drop", [](const Json&, Reply) {});
    dispatcher_.add_method("twice", [](const Json&, Reply reply) {
      reply.result(1);
      reply.result(2);
      reply.error(kRefused, "late", nullptr);
    });
    dispatcher_.add_method("speed", [](const Json& params, Reply reply) {
      reply.result(params.at("rad_s").get<double>());
    });
    dispatcher_.add_method("bug", [](const Json&, Reply) { throw std::logic_error("a bug"); });
    dispatcher_.add_method("bytes", [](const Json&, Reply reply) { reply.result("\xff\xfe"); });
    dispatcher_.add_method("count", [this](const Json&, Reply reply) {
      ++counted_;
      reply.result(counted_);
    });
    dispatcher_.add_method(
        "light", [](const Json&, Reply reply) { reply.result(1); }, 0.25);
    dispatcher_.add_topic("status");
  }
  /// Weight of the calls of a line.
  double weight_of(std::string_view line) {
    peer_->weight = 0;
    handle(line);
    return peer_->weight;
  }

  std::vector<std::string> handle(std::string_view line) {
    peer_->lines.clear();
    dispatcher_.handle(line, peer_);
    return peer_->lines;
  }
  Json answer(std::string_view line) {
    const std::vector<std::string> lines = handle(line);
    EXPECT_EQ(lines.size(), 1U) << line;
    return lines.empty() ? Json() : Json::parse(lines[0]);
  }

  Dispatcher dispatcher_;
  std::vector<Reply> kept_;
  int counted_ = 0;
  std::shared_ptr<FakePeer> peer_ = std::make_shared<FakePeer>();
};

TEST_F(DispatcherTest, CallsAMethodForItsOwnProcess) {
  std::vector<Json> results;
  std::vector<int> errors;
  const Reply reply{.result = [&](const Json& result) { results.push_back(result); },
                    .error = [&](int code, auto&&...) { errors.push_back(code); }};
  dispatcher_.set_token("secret");
  dispatcher_.call("echo", {{"x", 1.5}}, reply);
  EXPECT_EQ(results, std::vector<Json>({Json{{"x", 1.5}}}));
  dispatcher_.call("speed", Json::object(), reply);
  dispatcher_.call("subscribe", Json::object(), reply);
  EXPECT_EQ(errors, std::vector<int>({kInvalidParams, kMethodNotFound}));
  dispatcher_.call("keep", Json::object(), reply);
  kept_.back().result(true);
  EXPECT_EQ(results.back(), true);
}

TEST_F(DispatcherTest, AnnouncesEachLineBeforeItsCalls) {
  int announced = 0;
  dispatcher_.before_calls([&] {
    EXPECT_EQ(counted_, announced);
    ++announced;
  });
  handle(R"({"jsonrpc":"2.0","id":1,"method":"count"})");
  handle(R"({"jsonrpc":"2.0","id":2,"method":"count"})");
  handle("  ");
  EXPECT_EQ(announced, 2);
  EXPECT_EQ(counted_, 2);
}

TEST_F(DispatcherTest, ACallThatLacksMemoryIsAnError) {
  dispatcher_.add_method("lacking", [](const Json&, Reply) { throw std::bad_alloc(); });
  const Json reply = answer(R"({"jsonrpc":"2.0","id":7,"method":"lacking"})");
  EXPECT_EQ(reply["id"], 7);
  EXPECT_EQ(reply["error"]["code"], kInternalError);
}

TEST_F(DispatcherTest, ALineThatLacksMemoryIsAnErrorAndTheLast) {
  dispatcher_.before_calls([] { throw std::bad_alloc(); });
  const Json reply = answer(R"({"jsonrpc":"2.0","id":7,"method":"count"})");
  EXPECT_EQ(reply["error"]["code"], kInternalError);
  EXPECT_TRUE(peer_->refused);
  EXPECT_EQ(counted_, 0);
}

TEST_F(DispatcherTest, WeighsALineByTheHeaviestOfItsCalls) {
  EXPECT_EQ(weight_of(R"({"jsonrpc":"2.0","id":1,"method":"light"})"), 0.25);
  EXPECT_EQ(weight_of(R"({"jsonrpc":"2.0","id":1,"method":"echo"})"), 1);
  EXPECT_EQ(weight_of(R"({"jsonrpc":"2.0","id":1,"method":"methods"})"), 1);
  EXPECT_EQ(weight_of(R"({"jsonrpc":"2.0","id":1,"method":"nothing"})"), 1);
  EXPECT_EQ(weight_of(R"([{"jsonrpc":"2.0","id":1,"method":"light"},)"
                      R"({"jsonrpc":"2.0","id":2,"method":"echo"}])"),
            1);
}

TEST_F(DispatcherTest, AResultCarriesTheIdOfItsRequest) {
  for (const Json& id : {Json(1), Json("a"), Json(nullptr), Json(1.5), Json(-7)}) {
    const Json request{{"jsonrpc", "2.0"}, {"id", id}, {"method", "echo"}, {"params", {1, 2}}};
    const Json expected{{"jsonrpc", "2.0"}, {"id", id}, {"result", {1, 2}}};
    EXPECT_EQ(answer(request.dump()), expected);
  }
}

TEST_F(DispatcherTest, AbsentParametersAreNull) {
  EXPECT_TRUE(answer(R"({"jsonrpc":"2.0","id":1,"method":"echo"})")["result"].is_null());
  EXPECT_TRUE(
      answer(R"({"jsonrpc":"2.0","id":1,"method":"echo","params":null})")["result"].is_null());
}

TEST_F(DispatcherTest, ANotificationIsCalledAndNotAnswered) {
  EXPECT_TRUE(handle(R"({"jsonrpc":"2.0","method":"count"})").empty());
  EXPECT_EQ(counted_, 1);
  EXPECT_TRUE(handle(R"({"jsonrpc":"2.0","method":"no_such"})").empty());
  EXPECT_TRUE(handle(R"({"jsonrpc":"2.0","method":"bug"})").empty());
  EXPECT_EQ(peer_->calls, 0U);
}

TEST_F(DispatcherTest, ABlankLineIsIgnored) {
  EXPECT_TRUE(handle("").empty());
  EXPECT_TRUE(handle(" \t\r\n").empty());
}

struct FaultCase {
  const char* name;
  std::string line;
  int code;
  Json id;
};

class DispatcherFault : public DispatcherTest, public testing::WithParamInterface<FaultCase> {};

TEST_P(DispatcherFault, IsAnsweredWithItsCode) {
  const Json response = answer(GetParam().line);
  EXPECT_EQ(response["error"]["code"], GetParam().code) << response;
  EXPECT_EQ(response["id"], GetParam().id);
  EXPECT_EQ(response["jsonrpc"], "2.0");
  EXPECT_FALSE(response["error"]["message"].get<std::string>().empty());
  EXPECT_FALSE(response.contains("result"));
  EXPECT_EQ(peer_->calls, 0U);
  // An invalid request ends the connection; a failed call does not.
  const int code = GetParam().code;
  EXPECT_EQ(peer_->refused, code == kParseError || code == kInvalidRequest);
}

INSTANTIATE_TEST_SUITE_P(
    Lines, DispatcherFault,
    testing::Values(
        FaultCase{"Garbage", "garbage", kParseError, nullptr},
        FaultCase{"HalfAnObject", R"({"jsonrpc":"2.0","id":1,)", kParseError, nullptr},
        FaultCase{"TwoObjects", R"({"a":1}{"b":2})", kParseError, nullptr},
        FaultCase{"NotUtf8", "{\"jsonrpc\":\"2.0\",\"id\":1,\"method\":\"\xff\"}", kParseError,
                  nullptr},
        FaultCase{"NulByte", std::string("{\"id\":\0 1}", 10), kParseError, nullptr},
        FaultCase{"TooDeep", std::string(65, '['), kParseError, nullptr},
        FaultCase{"AbysmallyDeep", std::string(60'000, '['), kParseError, nullptr},
        FaultCase{"Number", "42", kInvalidRequest, nullptr},
        FaultCase{"EmptyBatch", "[]", kInvalidRequest, nullptr},
        FaultCase{"NoVersion", R"({"id":1,"method":"echo"})", kInvalidRequest, 1},
        FaultCase{"OldVersion", R"({"jsonrpc":"1.0","id":1,"method":"echo"})", kInvalidRequest, 1},
        FaultCase{"NoMethod", R"({"jsonrpc":"2.0","id":2})", kInvalidRequest, 2},
        FaultCase{"MethodNoString", R"({"jsonrpc":"2.0","id":3,"method":1})", kInvalidRequest, 3},
        FaultCase{"ParamsNumber", R"({"jsonrpc":"2.0","id":"x","method":"echo","params":1})",
                  kInvalidRequest, "x"},
        FaultCase{"IdObject", R"({"jsonrpc":"2.0","id":{},"method":"echo"})", kInvalidRequest,
                  nullptr},
        FaultCase{"IdBool", R"({"jsonrpc":"2.0","id":true,"method":"echo"})", kInvalidRequest,
                  nullptr},
        FaultCase{"UnknownMethod", R"({"jsonrpc":"2.0","id":4,"method":"none"})", kMethodNotFound,
                  4},
        FaultCase{"MissingParameter", R"({"jsonrpc":"2.0","id":5,"method":"speed","params":{}})",
                  kInvalidParams, 5},
        FaultCase{"WrongType",
                  R"({"jsonrpc":"2.0","id":6,"method":"speed","params":{"rad_s":"fast"}})",
                  kInvalidParams, 6},
        FaultCase{"NoParameters", R"({"jsonrpc":"2.0","id":6,"method":"speed"})", kInvalidParams,
                  6},
        FaultCase{"Throws", R"({"jsonrpc":"2.0","id":7,"method":"bug"})", kInternalError, 7},
        FaultCase{"ForgetsItsReply", R"({"jsonrpc":"2.0","id":8,"method":"drop"})", kInternalError,
                  8},
        FaultCase{"UnknownTopic",
                  R"({"jsonrpc":"2.0","id":9,"method":"subscribe","params":{"topic":"x"}})",
                  kInvalidParams, 9}),
    [](const auto& test) { return test.param.name; });

TEST_F(DispatcherTest, ItsOwnMethodsRefuseUnknownParametersToo) {
  for (const char* method :
       {"methods", "rpc.discover", "subscribe", "unsubscribe", "introduce", "authorise"}) {
    const Json request{{"jsonrpc", "2.0"},
                       {"id", 1},
                       {"method", method},
                       {"params", {{"topic", "status"}, {"name", "x"}, {"tokn", "x"}}}};
    const Json error = answer(request.dump()).at("error");
    EXPECT_EQ(error.at("code"), kInvalidParams) << method;
    EXPECT_NE(error.at("message").get<std::string>().find("is no parameter"), std::string::npos)
        << error;
  }
}

TEST_F(DispatcherTest, KnowsAClientByTheNameThatItGaveItself) {
  peer_->name = "unix:uid 1000";
  dispatcher_.add_method("who",
                         [](const Json&, const Reply& reply) { reply.result(reply.client); });
  const auto introduce = [this](const Json& name) {
    return answer(
        Json{{"jsonrpc", "2.0"}, {"id", 1}, {"method", "introduce"}, {"params", {{"name", name}}}}
            .dump());
  };
  const std::string who = R"({"jsonrpc":"2.0","id":2,"method":"who"})";
  for (const Json& name :
       {Json(""), Json("a name"), Json("n\n"), Json(std::string(33, 'n')), Json(1)}) {
    EXPECT_EQ(introduce(name).at("error").at("code"), kInvalidParams) << name;
  }
  EXPECT_EQ(answer(who)["result"], "unix:uid 1000");
  EXPECT_EQ(introduce("hils-4711")["result"], "unix:uid 1000 (hils-4711)");
  EXPECT_EQ(introduce("hils-4711")["result"], "unix:uid 1000 (hils-4711)") << "again";
  EXPECT_EQ(introduce("casweb").at("error").at("code"), kInvalidParams) << "another";
  EXPECT_EQ(answer(who)["result"], "unix:uid 1000 (hils-4711)");
}

TEST_F(DispatcherTest, AnswersWhatAMethodThrows) {
  dispatcher_.add_method("refuse", [](const Json& params, const Reply&) {
    if (params.is_null()) throw CallError(kInterlock, "not in HIL", R"({"result":4})");
    if (params.is_array()) throw BadParams("parameters are named");
    if (params.contains("a")) static_cast<void>(params.at("a").get<std::string>());
    throw ConfigError("line 3");
  });
  const auto error = [this](const char* params) {
    return answer(std::string(R"({"jsonrpc":"2.0","id":1,"method":"refuse")") + params + "}")
        .at("error");
  };
  EXPECT_EQ(error(""),
            (Json{{"code", kInterlock}, {"message", "not in HIL"}, {"data", {{"result", 4}}}}));
  EXPECT_EQ(error(R"(,"params":[])"),
            (Json{{"code", kInvalidParams}, {"message", "parameters are named"}}));
  EXPECT_EQ(error(R"(,"params":{})"), (Json{{"code", kRefused}, {"message", "line 3"}}));
  EXPECT_EQ(error(R"(,"params":{"a":1})"),
            (Json{{"code", kInvalidParams},
                  {"message", "a parameter is missing, or is of another type"}}));
}

TEST_F(DispatcherTest, TheFirstAnswerCounts) {
  EXPECT_EQ(answer(R"({"jsonrpc":"2.0","id":1,"method":"twice"})")["result"], 1);
}

TEST_F(DispatcherTest, BytesThatAreNoUtf8AreReplacedInAnswers) {
  EXPECT_EQ(answer(R"({"jsonrpc":"2.0","id":1,"method":"bytes"})")["result"], "\uFFFD\uFFFD");
}

TEST_F(DispatcherTest, BracketsInStringsAreNoNesting) {
  const Json request{{"jsonrpc", "2.0"},
                     {"id", 1},
                     {"method", "echo"},
                     {"params", {std::string(200, '[') + "\\\""}}};
  EXPECT_EQ(answer(request.dump())["result"], request["params"]);
}

TEST_F(DispatcherTest, ALateAnswerIsDelivered) {
  EXPECT_TRUE(handle(R"({"jsonrpc":"2.0","id":1,"method":"keep"})").empty());
  EXPECT_EQ(peer_->calls, 1U);
  kept_[0].error(kTimeout, "no acknowledgement", Json{{"waited_s", 3}});
  EXPECT_EQ(peer_->calls, 0U);
  const Json response = Json::parse(peer_->lines.at(0));
  EXPECT_EQ(response["error"]["code"], kTimeout);
  EXPECT_EQ(response["error"]["data"]["waited_s"], 3);
}

TEST_F(DispatcherTest, AnAnswerToAPeerThatIsGoneIsDropped) {
  handle(R"({"jsonrpc":"2.0","id":1,"method":"keep"})");
  handle(R"([{"jsonrpc":"2.0","id":1,"method":"keep"},{"jsonrpc":"2.0","method":"keep"}])");
  ASSERT_EQ(kept_.size(), 3U);
  peer_.reset();
  for (const Reply& reply : kept_) reply.result(true);
}

TEST_F(DispatcherTest, ABatchIsAnsweredInItsOrderWhenTheLastIsIn) {
  EXPECT_TRUE(handle(R"([{"jsonrpc":"2.0","id":1,"method":"keep"},
                         {"jsonrpc":"2.0","method":"count"},
                         {"jsonrpc":"2.0","id":2,"method":"echo","params":[5]},
                         7,
                         {"jsonrpc":"2.0","id":3,"method":"keep"}])")
                  .empty());
  kept_[1].result("second");
  EXPECT_TRUE(peer_->lines.empty());
  kept_[0].result("first");
  ASSERT_EQ(peer_->lines.size(), 1U);
  const Json batch = Json::parse(peer_->lines[0]);
  ASSERT_EQ(batch.size(), 4U);
  EXPECT_EQ(batch[0]["result"], "first");
  EXPECT_EQ(batch[1]["result"], Json({5}));
  EXPECT_EQ(batch[2]["error"]["code"], kInvalidRequest);
  EXPECT_EQ(batch[3]["result"], "second");
  EXPECT_EQ(counted_, 1);
  EXPECT_TRUE(peer_->refused) << "7 is no request";
}

TEST_F(DispatcherTest, ALongAnswerIsAnErrorAnswer) {
  peer_->most_bytes = 1000;
  const auto ask = [this](std::size_t bytes) {
    const Json request{
        {"jsonrpc", "2.0"}, {"id", 5}, {"method", "echo"}, {"params", {std::string(bytes, 'x')}}};
    return answer(request.dump());
  };
  EXPECT_TRUE(ask(800).contains("result"));
  const Json refused = ask(1200);
  EXPECT_EQ(refused["id"], 5);
  EXPECT_EQ(refused["error"]["code"], kInternalError);
  EXPECT_NE(refused["error"]["message"].get<std::string>().find("the answer is larger than"),
            std::string::npos);
}

TEST_F(DispatcherTest, TheAnswersOfAnUnfinishedBatchAreBounded) {
  peer_->most_bytes = 200'000;
  Json requests = Json::array({{{"jsonrpc", "2.0"}, {"id", 0}, {"method", "keep"}}});
  for (int id = 1; id <= 12; ++id) {
    requests.push_back({{"jsonrpc", "2.0"},
                        {"id", id},
                        {"method", "echo"},
                        {"params", {std::string(10'000, 'x')}}});
  }
  EXPECT_TRUE(handle(requests.dump()).empty());
  EXPECT_GT(peer_->held_bytes, 60'000U);
  EXPECT_LE(peer_->held_bytes, peer_->most_bytes);
  kept_[0].result("last");
  ASSERT_EQ(peer_->lines.size(), 1U);
  const Json answers = Json::parse(peer_->lines[0]);
  ASSERT_EQ(answers.size(), 13U);
  EXPECT_EQ(answers[0]["result"], "last");
  EXPECT_TRUE(answers[1].contains("result"));
  EXPECT_TRUE(answers[12].contains("error"));
  EXPECT_EQ(peer_->held_bytes, 0U);
  EXPECT_TRUE(peer_->batches.empty());
}

TEST_F(DispatcherTest, AnUnfinishedBatchEndsWithItsClient) {
  handle(R"([{"jsonrpc":"2.0","id":1,"method":"echo"},{"jsonrpc":"2.0","id":2,"method":"keep"}])");
  ASSERT_EQ(peer_->batches.size(), 1U);
  const std::weak_ptr<AnswerBatch> batch = peer_->batches[0];
  peer_.reset();
  EXPECT_TRUE(batch.expired());
  kept_[0].result(true);
}

TEST_F(DispatcherTest, AnIdIsShort) {
  for (const auto& [bytes, code] : {std::pair{1024U, 0}, {1025U, int{kInvalidRequest}}}) {
    const Json request{{"jsonrpc", "2.0"}, {"id", std::string(bytes, 'x')}, {"method", "echo"}};
    EXPECT_EQ(answer(request.dump()).value(Json::json_pointer("/error/code"), 0), code) << bytes;
  }
}

TEST_F(DispatcherTest, TheDescriptionIsMadeAnewAfterAnotherMethod) {
  const std::string discover = R"({"jsonrpc":"2.0","id":1,"method":"rpc.discover"})";
  const Json before = answer(discover)["result"];
  EXPECT_EQ(answer(discover)["result"], before);
  dispatcher_.add_method("another", [](const Json&, Reply reply) { reply.result(1); });
  EXPECT_EQ(answer(discover)["result"]["methods"].size(), before["methods"].size() + 1);
}

TEST_F(DispatcherTest, OnlyRequestsCountAsRequests) {
  const auto is_request = [this](std::string_view line) { return dispatcher_.handle(line, peer_); };
  EXPECT_TRUE(is_request(R"({"jsonrpc":"2.0","id":1,"method":"none"})"));
  EXPECT_TRUE(is_request(R"({"jsonrpc":"2.0","method":"count"})"));
  EXPECT_TRUE(is_request(R"([{"jsonrpc":"2.0","id":1,"method":"count"}])"));
  EXPECT_FALSE(is_request(" \t\r\n"));
  EXPECT_FALSE(peer_->refused) << "a blank line";
  EXPECT_FALSE(is_request("POST / HTTP/1.1\r\n"));
  EXPECT_EQ(peer_->refusal, Refusal::kNotJsonRpc);
}

TEST_F(DispatcherTest, ABatchOfNotificationsIsNotAnswered) {
  EXPECT_TRUE(
      handle(R"([{"jsonrpc":"2.0","method":"count"},{"jsonrpc":"2.0","method":"drop"}])").empty());
  EXPECT_EQ(counted_, 1);
}

TEST_F(DispatcherTest, ABatchHasABound) {
  Json batch = Json::array();
  for (int i = 0; i < 257; ++i) batch.push_back({{"jsonrpc", "2.0"}, {"method", "count"}});
  EXPECT_EQ(answer(batch.dump())["error"]["code"], kInvalidRequest);
  EXPECT_EQ(counted_, 0);
}

TEST_F(DispatcherTest, CallsUnderWayHaveABound) {
  for (int i = 0; i < 256; ++i) {
    EXPECT_TRUE(handle(R"({"jsonrpc":"2.0","id":1,"method":"keep"})").empty());
  }
  EXPECT_EQ(answer(R"({"jsonrpc":"2.0","id":2,"method":"keep"})")["error"]["code"], kInternalError);
  EXPECT_EQ(kept_.size(), 256U);
  kept_.pop_back();
  EXPECT_EQ(answer(R"({"jsonrpc":"2.0","id":3,"method":"echo"})")["id"], 3);
}

TEST_F(DispatcherTest, SubscriptionsArePerPeer) {
  const auto other = std::make_shared<FakePeer>();
  const auto subscribe =
      R"({"jsonrpc":"2.0","id":1,"method":"subscribe","params":{"topic":"status"}})";
  const auto unsubscribe =
      R"({"jsonrpc":"2.0","id":2,"method":"unsubscribe","params":{"topic":"status"}})";
  EXPECT_EQ(answer(subscribe)["result"], true);
  EXPECT_TRUE(peer_->topics.contains("status"));
  EXPECT_TRUE(other->topics.empty());
  EXPECT_EQ(answer(unsubscribe)["result"], true);
  EXPECT_EQ(answer(unsubscribe)["result"], false);
  EXPECT_TRUE(peer_->topics.empty());
}

TEST_F(DispatcherTest, WithoutTheTokenNothingIsCalled) {
  dispatcher_.set_token("0123456789abcdef");
  peer_->authorised = false;
  for (const char* method : {"count", "subscribe", "none"}) {
    const Json request{{"jsonrpc", "2.0"}, {"id", 1}, {"method", method}};
    EXPECT_EQ(answer(request.dump())["error"]["code"], kNotAuthorised) << method;
  }
  handle(R"({"jsonrpc":"2.0","method":"count"})");
  EXPECT_EQ(counted_, 0);
  EXPECT_EQ(answer(R"({"jsonrpc":"2.0","id":1,"method":"authorise",
                       "params":{"token":"0123456789abcdef"}})")["result"],
            true);
  EXPECT_EQ(answer(R"({"jsonrpc":"2.0","id":1,"method":"count"})")["result"], 1);
}

TEST_F(DispatcherTest, AWrongTokenEndsThePeer) {
  dispatcher_.set_token("0123456789abcdef");
  peer_->authorised = false;
  EXPECT_EQ(answer(R"({"jsonrpc":"2.0","id":1,"method":"authorise",
                       "params":{"token":"0123456789abcdeg"}})")["error"]["code"],
            kNotAuthorised);
  EXPECT_TRUE(peer_->refused);
  EXPECT_EQ(peer_->refusal, Refusal::kWrongToken);
  EXPECT_FALSE(peer_->authorised);
}

TEST_F(DispatcherTest, ABatchMayTryOneTokenOnly) {
  dispatcher_.set_token("0123456789abcdef");
  peer_->authorised = false;
  const Json answers = answer(
      R"([{"jsonrpc":"2.0","id":1,"method":"authorise","params":{"token":"0123456789abcdeg"}},
          {"jsonrpc":"2.0","id":2,"method":"authorise","params":{"token":"0123456789abcdef"}},
          {"jsonrpc":"2.0","id":3,"method":"count"}])");
  ASSERT_EQ(answers.size(), 3U);
  for (const Json& each : answers) EXPECT_EQ(each["error"]["code"], kNotAuthorised);
  EXPECT_TRUE(peer_->refused);
  EXPECT_EQ(counted_, 0);
}

TEST_F(DispatcherTest, AnElementThatIsNoRequestGivesABatchNoSecondToken) {
  dispatcher_.set_token("0123456789abcdef");
  peer_->authorised = false;
  const Json answers = answer(
      R"([{"jsonrpc":"2.0","id":1,"method":"authorise","params":{"token":"0123456789abcdeg"}},
          1,
          {"jsonrpc":"2.0","id":2,"method":"authorise","params":{"token":"0123456789abcdef"}},
          {"jsonrpc":"2.0","id":3,"method":"count"}])");
  ASSERT_EQ(answers.size(), 4U);
  for (const std::size_t at : {0U, 2U, 3U}) {
    EXPECT_EQ(answers[at]["error"]["code"], kNotAuthorised);
  }
  EXPECT_EQ(answers[1]["error"]["code"], kInvalidRequest);
  EXPECT_EQ(counted_, 0);
}

TEST_F(DispatcherTest, AMethodOfOneNameIsAddedOnce) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");
  EXPECT_DEATH(dispatcher_.add_method("echo", [](const Json&, Reply) {}), "check failed");
  EXPECT_DEATH(dispatcher_.add_method("subscribe", [](const Json&, Reply) {}), "check failed");
}

}  // namespace
}  // namespace cas::base::rpc
