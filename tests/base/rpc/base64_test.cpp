// SPDX-License-Identifier: BSD-3-Clause
#include "base/rpc/base64.hpp"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace cas::base::rpc {
namespace {

TEST(Base64, IsThatOfTheStandard) {  // RFC 4648, Sect. 10
  const std::vector<std::pair<std::string, std::string>> texts{
      {"", ""},         {"f", "Zg=="},        {"fo", "Zm8="},
      {"foo", "Zm9v"},  {"foob", "Zm9vYg=="}, {"foobar", "Zm9vYmFy"},
      {"\xff", "/w=="}, {"\xfb\xf0", "+/A="}, {"foob\xff", "Zm9vYv8="}};
  for (const auto& [bytes, text] : texts) {
    EXPECT_EQ(to_base64(bytes), text);
    EXPECT_EQ(from_base64(text), bytes);
  }
}

TEST(Base64, IsReadAsFarAsItGoes) {
  EXPECT_EQ(from_base64("Zm9v!YmFy"), "foo");
  EXPECT_EQ(from_base64("Z"), "");
}

}  // namespace
}  // namespace cas::base::rpc
