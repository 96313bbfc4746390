// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/config_whole.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "tests/support/refusal.hpp"

namespace cas::base {
namespace {

TEST(WrongWholeNumber, IsRefusedWithFileLineAndKeyPath) {
  struct Case {
    const char* name;
    const char* value;
    const char* error;
  };
  const Case rows[] = {{"Fraction", "1.7", "'1.7' must be a whole number"},
                       {"WholeFraction", "2.0", "'2.0' must be a whole number"},
                       {"Power", "1e1", "'1e1' must be a whole number"},
                       {"Word", "two", "'two' is not a whole number in range"},
                       {"Dots", "1.2.3", "'1.2.3' is not a whole number in range"},
                       {"TooLow", "0", "0 must lie in [1, 64]"},
                       {"TooHigh", "65", "65 must lie in [1, 64]"},
                       {"Negative", "-3", "-3 must lie in [1, 64]"}};
  for (const auto& [name, value, error] : rows) {
    SCOPED_TRACE(name);
    const ConfigNode root =
        ConfigNode::parse("link:\n  max_peers: " + std::string(value) + "\n", "t.yaml");
    EXPECT_EQ(test::refusal([&] { get_whole_in<int>(root.at("link"), "max_peers", 8, 1, 64); }),
              "t.yaml:2: link.max_peers: " + std::string(error));
  }
}

TEST(WholeNumber, IsReadAndMayBeLeftOut) {
  const ConfigNode root = ConfigNode::parse("id: 255\n");
  EXPECT_EQ(get_whole_in<std::uint8_t>(root, "id", 1, 1, 255), 255);
  EXPECT_EQ(require_whole_in<unsigned>(root, "id", 0, 1000), 255U);
  EXPECT_EQ(get_whole_in<std::uint16_t>(root, "port", 5790, 0, 65535), 5790);
  EXPECT_THROW(require_whole_in<int>(root, "port", 0, 65535), ConfigError);
}

}  // namespace
}  // namespace cas::base
