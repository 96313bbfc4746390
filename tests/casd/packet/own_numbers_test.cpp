// SPDX-License-Identifier: BSD-3-Clause
#include "casd/packet/own_numbers.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

#include "mavlink_gen/runtime/packet_parser.hpp"
#include "mavlink_gen/runtime/public_table.hpp"
#include "tests/casd/packets.hpp"

namespace cas::casd::test {
namespace {

constexpr mav::Source kSelf{254, 190};

/// The sequence number of each packet, as a receiver finds it; 999: no whole packet.
std::vector<unsigned> seen(std::span<const PacketRef> packets) {
  std::vector<unsigned> numbers;
  for (const PacketRef& packet : packets) {
    mav::PacketParser parser(mav::public_table());
    numbers.push_back(999);
    parser.feed(packet.bytes, [&](const mav::PacketView& view) { numbers.back() = view.sequence; });
  }
  return numbers;
}

class OwnNumbersTest : public testing::Test {
 protected:
  PacketRef own(std::uint8_t sequence) { return add(kLocalLink, kSelf, sequence); }
  PacketRef of_others(std::uint8_t sequence) { return add(3, {1, 1}, sequence); }

  OwnNumbers numbers_;

 private:
  PacketRef add(LinkId from, mav::Source source, std::uint8_t sequence) {
    const std::size_t i = count_++;
    bytes_[i] = packet(mavlink::common::Heartbeat{}, source, sequence);
    infos_[i] = inspect(view(bytes_[i]), mav::public_table());
    infos_[i].from = from;
    return {&infos_[i], bytes_[i].view()};
  }

  std::size_t count_ = 0;
  std::array<mav::PacketBuffer, 16> bytes_;
  std::array<PacketInfo, 16> infos_;
};

TEST_F(OwnNumbersTest, LeaveNoGapWhateverWentElsewhere) {
  const std::array packets{own(10), own(20), own(30)};
  const auto given = numbers_.number(packets);
  EXPECT_EQ(seen(given), (std::vector<unsigned>{0, 1, 2}));
  numbers_.sent(given);
  const std::array next{own(99)};
  EXPECT_EQ(seen(numbers_.number(next)), std::vector<unsigned>{3});
}

TEST_F(OwnNumbersTest, AreUsedOnceTheyHaveLeft) {
  const std::array packets{own(10), own(20)};
  numbers_.sent(numbers_.number(packets).first(1));
  EXPECT_EQ(seen(numbers_.number(std::span(packets).subspan(1))), std::vector<unsigned>{1});
}

TEST_F(OwnNumbersTest, AreNotThoseOfOthers) {
  const std::array packets{of_others(77), own(10), of_others(78)};
  EXPECT_EQ(seen(numbers_.number(packets)), (std::vector<unsigned>{77, 0, 78}));
  EXPECT_EQ(numbers_.number(std::span(packets).first(1)).data(), packets.data());
}

TEST_F(OwnNumbersTest, BeginAgainAfter255) {
  const std::array packets{own(10)};
  for (int i = 0; i < 256; ++i) numbers_.sent(packets);
  EXPECT_EQ(seen(numbers_.number(packets)), std::vector<unsigned>{0});
}

}  // namespace
}  // namespace cas::casd::test
