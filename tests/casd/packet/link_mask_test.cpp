// SPDX-License-Identifier: BSD-3-Clause
#include "casd/packet/link_mask.hpp"

#include <gtest/gtest.h>

#include <vector>

namespace cas::casd::test {
namespace {

std::vector<LinkId> links_of(const LinkMask& mask) {
  std::vector<LinkId> links;
  mask.for_each([&](LinkId link) { links.push_back(link); });
  return links;
}

TEST(LinkMask, HoldsLinksOfEveryWordInTheirOrder) {
  const LinkMask mask = bit(kMaxLinks) | bit(64) | bit(0) | bit(kLocalLink) | bit(128);
  EXPECT_EQ(links_of(mask), (std::vector<LinkId>{0, kLocalLink, 64, 128, kMaxLinks}));
  EXPECT_EQ(mask.count(), 5U);
  EXPECT_TRUE(mask.has(128));
  EXPECT_FALSE(mask.has(129));
  EXPECT_TRUE((mask - mask).empty());
  EXPECT_EQ(links_of(mask - bit(0) - bit(64)), (std::vector<LinkId>{kLocalLink, 128, kMaxLinks}));
}

TEST(LinkMask, EveryLinkFindsASlotBesideTheStation) {
  LinkMask taken = bit(kLocalLink);
  for (int link = 0; link < kMaxLinks; ++link) taken.add(taken.first_missing());
  EXPECT_EQ(taken.count(), static_cast<unsigned>(kLinkSlots));
  EXPECT_TRUE(taken.has(kLinkSlots - 1));
}

}  // namespace
}  // namespace cas::casd::test
