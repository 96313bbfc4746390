// SPDX-License-Identifier: BSD-3-Clause
#include "base/mailbox.hpp"

#include <gtest/gtest.h>

#include <thread>

namespace cas::base {
namespace {

TEST(Mailbox, GivesTheNewestValueOnce) {
  Mailbox<int> box;
  EXPECT_FALSE(box.take());
  box.put(1);
  box.put(2);
  EXPECT_EQ(box.take(), 2);
  EXPECT_FALSE(box.take());
  EXPECT_EQ(box.overwritten(), 1U);
}

TEST(Mailbox, AccountsForEachValueAcrossThreads) {
  constexpr int kValues = 100'000;
  Mailbox<int> box;
  std::uint64_t taken = 0;
  int last = 0;
  std::thread writer([&box] {
    for (int i = 1; i <= kValues; ++i) box.put(i);
  });
  while (last < kValues) {
    if (const auto value = box.take()) {
      EXPECT_GT(*value, last);
      last = *value;
      ++taken;
    }
  }
  writer.join();
  EXPECT_EQ(taken + box.overwritten(), static_cast<std::uint64_t>(kValues));
}

}  // namespace
}  // namespace cas::base
