// SPDX-License-Identifier: BSD-3-Clause
#include "base/cli/whole_number.hpp"

#include <gtest/gtest.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>

namespace cas::base::cli {
namespace {

TEST(WholeNumber, IsNothingButDigits) {
  EXPECT_EQ(whole_number("0"), "");
  EXPECT_EQ(whole_number("18446744073709551615"), "");
  EXPECT_EQ(whole_number("-1"), "'-1' is not a whole number, 0 or above, in range");
  for (const char* text : {"", "+1", "1.5", "1e3", "0x10", "010", "one"}) {
    EXPECT_NE(whole_number(text), "") << text;
  }
}

TEST(WholeNumber, KeepsAnOptionFromWrappingRound) {
  CLI::App app;
  std::uint64_t seed = 1;
  app.add_option("--seed", seed)->check(whole_number);
  EXPECT_THROW(app.parse("--seed -1"), CLI::ParseError);
  EXPECT_THROW(app.parse("--seed 18446744073709551616"), CLI::ParseError);
  app.parse("--seed 18446744073709551615");
  EXPECT_EQ(seed, std::numeric_limits<std::uint64_t>::max());
}

}  // namespace
}  // namespace cas::base::cli
