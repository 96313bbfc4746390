// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/lock_holder.hpp"

#include <gtest/gtest.h>

namespace cas::hils {
namespace {

const LockHolder kHolder{.pid = 12,
                         .user = "ann",
                         .since = "2026-03-01T12:00:00Z",
                         .purpose = "hils run hover.yaml",
                         .token = "ab12",
                         .in_background = true};

TEST(LockHolder, IsReadAsItWasWritten) {
  const auto read = LockHolder::parse(kHolder.text());
  ASSERT_TRUE(read);
  EXPECT_EQ(to_words(*read), "process 12 of ann since 2026-03-01T12:00:00Z: hils run hover.yaml");
  EXPECT_EQ(read->token, "ab12");
  EXPECT_TRUE(read->in_background);
}

TEST(LockHolder, KeepsToItsLine) {
  LockHolder holder = kHolder;
  holder.purpose = "night\npid 1";
  const auto read = LockHolder::parse(holder.text());
  ASSERT_TRUE(read);
  EXPECT_EQ(read->pid, 12);
  EXPECT_EQ(read->purpose, "night pid 1");
}

TEST(LockHolder, IsNoneWhileItIsBeingWritten) {
  const std::string text = kHolder.text();
  for (std::size_t size = 0; size < text.size(); ++size) {
    EXPECT_FALSE(LockHolder::parse(text.substr(0, size))) << size;
  }
}

TEST(LockHolder, IsKnownByItsWholeToken) {
  EXPECT_FALSE(names_token(nullptr, proof_of("ab12")));
  EXPECT_FALSE(names_token("ab1,ab123", proof_of("ab12")));
  EXPECT_FALSE(names_token(",,", "")) << "of a file without a token";
  EXPECT_TRUE(names_token("cd34,ab12", proof_of("ab12")));
  EXPECT_FALSE(names_token(proof_of("ab12").c_str(), proof_of("ab12")))
      << "who reads the lock file does not become a guest";
}

TEST(LockQueue, IsInTheOrderOfComing) {
  const std::string first = ticket_name(999, 50);
  const std::string second = ticket_name(1000, 4);
  const std::vector<std::string> alive{second, first};
  EXPECT_EQ(places_before(alive, first), 0U);
  EXPECT_EQ(places_before(alive, second), 1U);
}

}  // namespace
}  // namespace cas::hils
