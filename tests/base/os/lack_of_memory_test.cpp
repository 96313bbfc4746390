// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/lack_of_memory.hpp"

#include <gtest/gtest.h>

#include <new>
#include <stdexcept>
#include <string>

namespace cas::base::test {
namespace {

TEST(LackOfMemory, EndsTheWorkAloneAndIsSaid) {
  testing::internal::CaptureStderr();
  EXPECT_TRUE(outlive_lack_of_memory("fixture", [] {}));
  EXPECT_FALSE(outlive_lack_of_memory("fixture", [] { throw std::bad_alloc(); }));
  EXPECT_FALSE(outlive_lack_of_memory("fixture", [] { throw std::bad_alloc(); }));
  const std::string said = testing::internal::GetCapturedStderr();
  const std::size_t first = said.find("fixture: no memory");
  ASSERT_NE(first, std::string::npos) << said;
  EXPECT_EQ(said.find("no memory", first + 20), std::string::npos) << "once a second: " << said;
}

TEST(LackOfMemory, LetsOtherFaultsPass) {
  EXPECT_THROW(outlive_lack_of_memory("fixture", [] { throw std::runtime_error("a bug"); }),
               std::runtime_error);
}

TEST(LackOfMemory, TheReserveServesOneRefusal) {
  const std::new_handler before = std::get_new_handler();
  keep_memory_reserve();
  const std::uint64_t refusals = memory_refusals();
  const std::new_handler handler = std::get_new_handler();
  ASSERT_NE(handler, nullptr);
  handler();  // `new` would try again now
  EXPECT_THROW(handler(), std::bad_alloc) << "more is wanted than there is";
  EXPECT_EQ(memory_refusals(), refusals + 2);
  std::set_new_handler(before);
}

}  // namespace
}  // namespace cas::base::test
