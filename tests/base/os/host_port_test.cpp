// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/host_port.hpp"

#include <gtest/gtest.h>

namespace cas::base {
namespace {

struct Case {
  const char* name;
  const char* text;
  const char* host;  ///< nullptr: no HOST:PORT
  const char* port;
};

class HostPortText : public testing::TestWithParam<Case> {};

TEST_P(HostPortText, IsTakenApart) {
  const auto& [name, text, host, port] = GetParam();
  const std::optional<HostPort> parts = parse_host_port(text);
  ASSERT_EQ(parts.has_value(), host != nullptr);
  if (!parts) return;
  EXPECT_EQ(parts->host, host);
  EXPECT_EQ(parts->port, port);
}

INSTANTIATE_TEST_SUITE_P(Texts, HostPortText,
                         testing::Values(Case{"V4", "127.0.0.1:14560", "127.0.0.1", "14560"},
                                         Case{"Name", "localhost:0", "localhost", "0"},
                                         Case{"V6", "[::1]:14560", "::1", "14560"},
                                         Case{"BareV6", "::1:14560", "::1", "14560"},
                                         Case{"NoColon", "localhost", nullptr, nullptr},
                                         Case{"NoHost", ":14560", nullptr, nullptr},
                                         Case{"NoPort", "localhost:", nullptr, nullptr},
                                         Case{"EmptyBrackets", "[]:14560", nullptr, nullptr},
                                         Case{"OpenBracket", "[::1:14560", nullptr, nullptr},
                                         Case{"NoPortAfterBracket", "[::1]", nullptr, nullptr},
                                         Case{"Nothing", "", nullptr, nullptr}),
                         [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace cas::base
