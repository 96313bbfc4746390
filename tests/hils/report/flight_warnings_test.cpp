// SPDX-License-Identifier: BSD-3-Clause
#include "hils/report/flight_warnings.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace cas::hils {
namespace {

TEST(FlightWarnings, AreSaidOnceWithTheNumberOfFlightsThatHadThem) {
  FlightWarnings warnings;
  warnings.add({"a", "b", "b"});
  warnings.add({});
  warnings.add({"b"});
  EXPECT_EQ(warnings.sentences(), (std::vector<std::string>{"warning in 2 of 3 flights: b",
                                                            "warning in 1 of 3 flights: a"}));
  EXPECT_EQ(
      warnings_json<nlohmann::json>(warnings),
      nlohmann::json::parse(R"([{"warning": "a", "flights": 1}, {"warning": "b", "flights": 2}])"));
}

TEST(FlightWarnings, ThatDifferInEachFlightAreCountedBeyondTwenty) {
  FlightWarnings warnings;
  for (int i = 0; i < 23; ++i) warnings.add({std::to_string(i)});
  const std::vector<std::string> sentences = warnings.sentences();
  ASSERT_EQ(sentences.size(), 21U);
  EXPECT_EQ(sentences.back(), "further warnings, not shown: 3");
  EXPECT_EQ(warnings.all().size(), 23U);
}

}  // namespace
}  // namespace cas::hils
