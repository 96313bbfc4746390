// SPDX-License-Identifier: BSD-3-Clause
#include "hils/tune/eval_line.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace cas::hils {
namespace {

const std::vector<Parameter>& parameters() {
  static const std::vector<Parameter> known{{.name = "position_p", .keys = {"a", "b"}},
                                            {.name = "sensors", .keys = {"sensors"}}};
  return known;
}

TEST(EvalRequest, HasParametersBySeedAndGivesItsIdBack) {
  const EvalRequest request = EvalRequest::parse(
      R"({"id": "trial 7", "parameters": {"position_p": 1.25, "sensors": "rtk"}, "seed": 3})",
      parameters(), 1);
  EXPECT_EQ(request.error, std::nullopt);
  EXPECT_EQ(request.id, R"("trial 7")");
  EXPECT_EQ(request.seed, 3U);
  ASSERT_EQ(request.parameters.size(), 2U);
  EXPECT_EQ(request.parameters[0], (std::pair<std::string, std::string>{"position_p", "1.25"}));
  EXPECT_EQ(request.parameters[1], (std::pair<std::string, std::string>{"sensors", "\"rtk\""}));
  EXPECT_EQ(EvalRequest::parse("{}", parameters(), 9).seed, 9U);
}

TEST(EvalRequest, AnIdHasNoPartsAndEnds) {
  const std::string deep = std::string(1'000'000, '[') + std::string(1'000'000, ']');
  const std::string long_word(300, 'x');
  for (const std::string& id : {std::string("{}"), deep, fmt::format("\"{}\"", long_word)}) {
    const EvalRequest request =
        EvalRequest::parse(fmt::format(R"({{"id": {}}})", id), parameters(), 1);
    EXPECT_NE(request.error.value_or("").find("'id' is a number, a word"), std::string::npos)
        << id.size();
    EXPECT_EQ(request.id, "null");
  }
}

TEST(WrongLines, AreToldInASentence) {
  struct WrongLine {
    const char* line;
    const char* sentence;
  };
  const WrongLine rows[] = {
      {"position_p=1", "the line is no JSON map"},
      {"[1]", "the line is no JSON map"},
      {R"({"id": 1, "parameters": {)", "the line is no JSON map"},
      {"{\"id\": \"\xff\"}", "the line is no JSON map"},
      {R"({"params": {}})", "there is no key 'params'; there are id, parameters and seed"},
      {R"({"parameters": {"positon_p": 1}})",
       "the study has no parameter 'positon_p'; did you mean 'position_p'?"},
      {R"({"parameters": {"position_p": {"x": 1}}})",
       "'position_p' takes a number, a word, true or false"},
      {R"({"parameters": {"position_p": null}})",
       "'position_p' takes a number, a word, true or false"},
      {R"({"parameters": [1]})", "'parameters' is a map of names and values"},
      {R"({"seed": -1})", "'seed' is a whole number from 0"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.line);
    const EvalRequest request = EvalRequest::parse(row.line, parameters(), 1);
    EXPECT_EQ(request.error, row.sentence);
    const auto answer = nlohmann::json::parse(eval_error(request, request.error.value_or("")));
    EXPECT_EQ(answer.at("error"), row.sentence);
  }
}

TEST(EvalAnswer, IsOneLineOfFiguresByName) {
  const EvalRequest request = EvalRequest::parse(R"({"id": "a", "seed": 4})", parameters(), 1);
  RowResult result{.row = 1, .outcome = RowOutcome::kFailed, .cause = "x: 1\xff"};
  result.figures = {1, std::numeric_limits<double>::quiet_NaN()};
  result.warnings = {"a mass of 1 g"};
  const std::string line = eval_answer(request, result, {"up", "crash_s", "rms_x_m"});
  EXPECT_EQ(std::ranges::count(line, '\n'), 1);
  const auto answer = nlohmann::json::parse(line);
  EXPECT_EQ(answer.at("id"), "a");
  EXPECT_EQ(answer.at("outcome"), "failed");
  EXPECT_EQ(answer.at("up"), 1);
  EXPECT_EQ(answer.at("warnings"), nlohmann::json::array({"a mass of 1 g"}));
  EXPECT_EQ(answer.at("seed"), 4);
  EXPECT_EQ(answer.at("figures").at("up"), 1);
  EXPECT_TRUE(answer.at("figures").at("crash_s").is_null());
  EXPECT_TRUE(answer.at("figures").at("rms_x_m").is_null());
}

}  // namespace
}  // namespace cas::hils
