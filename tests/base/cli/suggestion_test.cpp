// SPDX-License-Identifier: BSD-3-Clause
#include "base/cli/suggestion.hpp"

#include <gtest/gtest.h>

namespace cas::base::cli {
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
  EXPECT_EQ(nearest_word("arm", {}), "");
}

}  // namespace
}  // namespace cas::base::cli
