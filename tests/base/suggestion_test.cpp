// SPDX-License-Identifier: BSD-3-Clause
#include "base/suggestion.hpp"

#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <vector>

namespace cas::base {
namespace {

TEST(Suggestion, CountsWhatMustBeEdited) {
  EXPECT_EQ(edit_distance("", ""), 0U);
  EXPECT_EQ(edit_distance("", "arm"), 3U);
  EXPECT_EQ(edit_distance("arm", "arm"), 0U);
  EXPECT_EQ(edit_distance("arms", "arm"), 1U);
  EXPECT_EQ(edit_distance("stauts", "status"), 1U);  // two neighbours swapped
  EXPECT_EQ(edit_distance("land", "hold"), 3U);
}

TEST(Suggestion, NamesTheNearestWordAndNoneThatIsFar) {
  const std::vector<std::string> verbs{"arm",     "disarm",  "status",
                                       "takeoff", "message", "message-interval"};
  EXPECT_EQ(nearest_word("amr", verbs), "arm");
  EXPECT_EQ(nearest_word("disam", verbs), "disarm");
  EXPECT_EQ(nearest_word("take-off", verbs), "takeoff");
  EXPECT_EQ(nearest_word("stat", verbs), "status");
  EXPECT_EQ(nearest_word("massage", verbs), "message");
  EXPECT_EQ(nearest_word("mess", verbs), "");  // two begin so
  EXPECT_EQ(nearest_word("xyz", verbs), "");
  EXPECT_EQ(did_you_mean("amr", verbs), "; did you mean 'arm'?");
  EXPECT_EQ(did_you_mean("xyz", verbs), "");
  EXPECT_EQ(did_you_mean("arm", verbs), "") << "it is known";
  EXPECT_EQ(nearest_word("arm", std::vector<std::string>()), "");
}

TEST(Suggestion, ComparesNoMoreThanItCanBear) {
  const std::vector<std::string> long_word{std::string(65, 'a')};
  EXPECT_EQ(nearest_word(std::string(65, 'a'), long_word), "");
  EXPECT_EQ(nearest_word(std::string(100'000, 'a'), long_word), "");
  std::vector<std::string> many(4096, "something else");
  many.emplace_back("status");
  EXPECT_EQ(nearest_word("stauts", many), "");
  many.front() = "status";
  EXPECT_EQ(nearest_word("stauts", many), "status");
}

TEST(Suggestion, TakesViewsAndLeavesShortWordsAlone) {
  constexpr std::string_view kWords[] = {"p", "i", "d"};
  EXPECT_EQ(nearest_word("x", kWords), "") << "every letter would have to change";
}

TEST(Suggestion, KnowsAWordByItsPartBeforeOrBehindAnUnderscore) {
  EXPECT_EQ(nearest_word("z", std::vector<std::string>{"x_m", "y_m", "z_m", "yaw_rad"}), "z_m");
  EXPECT_EQ(nearest_word("share", std::vector<std::string>{"number", "stop", "thrust_share"}),
            "thrust_share");
  EXPECT_EQ(nearest_word("m", std::vector<std::string>{"x_m", "y_m"}), "") << "it may be either";
}

}  // namespace
}  // namespace cas::base
