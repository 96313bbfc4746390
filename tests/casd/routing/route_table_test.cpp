// SPDX-License-Identifier: BSD-3-Clause
#include "casd/routing/route_table.hpp"

#include <gtest/gtest.h>

#include "tests/casd/packets.hpp"

namespace cas::casd::test {
namespace {

using std::chrono::seconds;

TEST(RouteTable, ReachesWhoWasHeard) {
  RouteTable routes(seconds(60));
  routes.learn(1, {1, 1}, at({}));
  routes.learn(2, {1, 100}, at({}));
  routes.learn(3, {2, 1}, at({}));
  EXPECT_EQ(routes.links_to({1, 1}), slot_bit(1));
  EXPECT_EQ(routes.links_to({1, 100}), slot_bit(2));
  EXPECT_EQ(routes.links_to({2, 1}), slot_bit(3));
}

TEST(RouteTable, ComponentZeroIsEveryComponentOfTheSystem) {
  RouteTable routes(seconds(60));
  routes.learn(1, {1, 1}, at({}));
  routes.learn(2, {1, 100}, at({}));
  EXPECT_EQ(routes.links_to({1, 0}), slot_bit(1) | slot_bit(2));
}

TEST(RouteTable, SystemZeroIsEverybody) {
  EXPECT_EQ(RouteTable(seconds(60)).links_to({0, 0}), ~SlotMask{0});
}

TEST(RouteTable, UnknownTargetIsNowhere) {
  RouteTable routes(seconds(60));
  routes.learn(1, {1, 1}, at({}));
  EXPECT_EQ(routes.links_to({9, 0}), 0U);
  EXPECT_EQ(routes.links_to({1, 2}), 0U);
}

TEST(RouteTable, SimulatorAndControllerMayShareAnId) {
  RouteTable routes(seconds(60));
  routes.learn(0, {1, 1}, at({}));
  routes.learn(1, {1, 1}, at({}));
  EXPECT_EQ(routes.links_to({1, 1}), slot_bit(0) | slot_bit(1));
}

TEST(RouteTable, ForgetsWhoFallsSilent) {
  RouteTable routes(seconds(60));
  routes.learn(1, {1, 1}, at({}));
  routes.learn(1, {1, 100}, at({}));
  routes.learn(1, {1, 1}, at(seconds(50)));
  EXPECT_EQ(routes.expire(1, at(seconds(61))), 1);
  EXPECT_EQ(routes.links_to({1, 100}), 0U);
  EXPECT_EQ(routes.links_to({1, 1}), slot_bit(1));
  EXPECT_EQ(routes.links_to({1, 0}), slot_bit(1));
  EXPECT_EQ(routes.expire(1, at(seconds(111))), 1);
  EXPECT_EQ(routes.links_to({1, 0}), 0U);
}

TEST(RouteTable, KeepsWhoSpeaksOverASatelliteAsLongAsCasdsStationDoes) {
  RouteTable routes(seconds(60));
  routes.learn(1, {1, 1}, at({}), comes_rarely(235));
  routes.learn(1, {2, 1}, at({}), comes_rarely(0));
  EXPECT_EQ(routes.expire(1, at(seconds(199))), 1);
  EXPECT_EQ(routes.links_to({1, 1}), slot_bit(1));
  EXPECT_EQ(routes.expire(1, at(seconds(201))), 1);
}

TEST(RouteTable, ForgettingALinkLeavesTheOthers) {
  RouteTable routes(seconds(60));
  routes.learn(1, {1, 1}, at({}));
  routes.learn(2, {1, 1}, at({}));
  routes.forget(1);
  EXPECT_EQ(routes.links_to({1, 1}), slot_bit(2));
}

TEST(RouteTable, BoundsWhatOneLinkMayAnnounce) {
  RouteTable routes(seconds(60));
  std::size_t learnt = 0;
  for (int system = 1; system < 256; ++system) {
    for (int component = 1; component < 10; ++component) {
      const mav::Source source{static_cast<std::uint8_t>(system),
                               static_cast<std::uint8_t>(component)};
      learnt += routes.learn(5, source, at({})) ? 1 : 0;
    }
  }
  EXPECT_EQ(learnt, RouteTable::kMaxIdsPerLink);
  EXPECT_TRUE(routes.learn(6, {255, 9}, at({})));  // others are not affected
}

}  // namespace
}  // namespace cas::casd::test
