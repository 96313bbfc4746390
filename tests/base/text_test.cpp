// SPDX-License-Identifier: BSD-3-Clause
#include "base/text.hpp"

#include <gtest/gtest.h>

#include <map>
#include <string>
#include <vector>

namespace cas::base::test {
namespace {

struct Named {
  std::string name;
};

TEST(Joined, PutsTheSeparatorBetweenElementsOnly) {
  EXPECT_EQ(joined(std::vector<std::string>{}, ", "), "");
  EXPECT_EQ(joined(std::vector<std::string>{"a"}, ", "), "a");
  EXPECT_EQ(joined(std::vector<std::string>{"a", "", "c"}, ", "), "a, , c");
  EXPECT_EQ(joined(std::vector<std::string>{"", "b"}, ", "), ", b");
}

TEST(Joined, TakesAMemberOrAFunctionForTheText) {
  EXPECT_EQ(joined(std::vector<Named>{{"p"}, {"q"}}, " ", &Named::name), "p q");
  const std::map<int, int> pairs{{1, 2}, {3, 4}};
  const auto text = [](const auto& pair) {
    return std::to_string(pair.first) + "/" + std::to_string(pair.second);
  };
  EXPECT_EQ(joined(pairs, ";", text), "1/2;3/4");
}

TEST(Letters, ChangeInAsciiOnly) {
  EXPECT_EQ(lower("AZ[`az{ \xC3\x84"), "az[`az{ \xC3\x84");
  EXPECT_EQ(upper("AZ[`az{ \xC3\xA4"), "AZ[`AZ{ \xC3\xA4");
}

TEST(Trimmed, KeepsBlanksBetweenWords) {
  EXPECT_EQ(trimmed(" \t a b\r"), "a b");
  EXPECT_EQ(trimmed(" \t\r"), "");
}

TEST(Numbers, AreDigitsAndNothingElse) {
  EXPECT_TRUE(is_number("0123456789"));
  for (const char* text : {"", "-1", "1.5", "1 ", "0x1"}) EXPECT_FALSE(is_number(text)) << text;
}

}  // namespace
}  // namespace cas::base::test
