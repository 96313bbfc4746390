// SPDX-License-Identifier: BSD-3-Clause
#include "casd/packet/packet_ring.hpp"

#include <gtest/gtest.h>

#include <deque>
#include <random>

#include "tests/casd/packets.hpp"

namespace cas::casd::test {
namespace {

TEST(PacketRing, BehavesLikeAQueueWhateverComes) {
  std::mt19937 random(1);
  PacketRing ring(4096);
  std::deque<std::vector<std::uint8_t>> model;
  std::size_t most = 0;
  for (int i = 0; i < 200'000; ++i) {
    if (random() % 100 < 52) {
      const auto packet = bytes(8 + random() % 273, static_cast<std::uint8_t>(random()));
      if (ring.push(PacketInfo{}, packet)) model.push_back(packet);
    } else if (!model.empty()) {
      const auto front = ring.front().bytes;
      ASSERT_EQ(std::vector<std::uint8_t>(front.begin(), front.end()), model.front());
      ring.pop();
      model.pop_front();
    }
    ASSERT_EQ(ring.count(), model.size());
    ASSERT_EQ(ring.empty(), model.empty());
    most = std::max(most, model.size());
  }
  EXPECT_GT(most, 10U);
}

TEST(PacketRing, RefusesWhatDoesNotFit) {
  PacketRing ring(256);
  EXPECT_FALSE(ring.push(PacketInfo{}, bytes(280)));
  EXPECT_TRUE(ring.push(PacketInfo{}, bytes(100)));
  EXPECT_FALSE(ring.push(PacketInfo{}, bytes(150)));
  ring.clear();
  EXPECT_TRUE(ring.push(PacketInfo{}, bytes(150)));
}

}  // namespace
}  // namespace cas::casd::test
