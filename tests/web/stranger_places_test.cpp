// SPDX-License-Identifier: BSD-3-Clause
#include "web/server/stranger_places.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

namespace cas::web {
namespace {

TEST(StrangerPlaces, TheOldestGivesWayWhenAllAreTaken) {
  StrangerPlaces places(2);
  std::vector<int> gone;
  const auto take = [&](int number) {
    return places.take([&gone, number] { gone.push_back(number); });
  };
  auto first = take(1);
  const auto second = take(2);
  EXPECT_TRUE(gone.empty());
  const auto third = take(3);
  EXPECT_EQ(gone, std::vector{1});
  first.reset();
  const auto fourth = take(4);
  EXPECT_EQ(gone, (std::vector{1, 2}));
}

TEST(StrangerPlaces, ASilentOneGivesWayBeforeOneThatIsAnswered) {
  StrangerPlaces places(2);
  std::vector<int> gone;
  const auto take = [&](int number) {
    return places.take([&gone, number] { gone.push_back(number); });
  };
  const auto first = take(1);
  first->spoke = true;
  const auto second = take(2);
  const auto third = take(3);
  EXPECT_EQ(gone, std::vector{2});
  third->spoke = true;
  const auto fourth = take(4);
  EXPECT_EQ(gone, (std::vector{2, 1})) << "both are answered: the oldest";
}

TEST(StrangerPlaces, APlaceThatWasGivenBackIsFree) {
  StrangerPlaces places(1);
  bool is_gone = false;
  places.take([&is_gone] { is_gone = true; }).reset();
  const auto next = places.take([] {});
  EXPECT_FALSE(is_gone);
}

}  // namespace
}  // namespace cas::web
