// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/host_port.hpp"

#include <gtest/gtest.h>

namespace cas::base {
namespace {

struct HostPortCase {
  const char* name;
  const char* text;
  const char* host;  ///< nullptr: no HOST:PORT
  const char* port;
};

class HostPortText : public testing::TestWithParam<HostPortCase> {};

TEST_P(HostPortText, IsTakenApart) {
  const auto& [name, text, host, port] = GetParam();
  const std::optional<HostPort> parts = parse_host_port(text);
  ASSERT_EQ(parts.has_value(), host != nullptr);
  if (!parts) return;
  EXPECT_EQ(parts->host, host);
  EXPECT_EQ(parts->port, port);
}

INSTANTIATE_TEST_SUITE_P(
    Texts, HostPortText,
    testing::Values(HostPortCase{"V4", "127.0.0.1:14560", "127.0.0.1", "14560"},
                    HostPortCase{"Name", "localhost:0", "localhost", "0"},
                    HostPortCase{"V6", "[::1]:14560", "::1", "14560"},
                    HostPortCase{"BareV6", "::1:14560", "::1", "14560"},
                    HostPortCase{"NoColon", "localhost", nullptr, nullptr},
                    HostPortCase{"NoHost", ":14560", nullptr, nullptr},
                    HostPortCase{"NoPort", "localhost:", nullptr, nullptr},
                    HostPortCase{"EmptyBrackets", "[]:14560", nullptr, nullptr},
                    HostPortCase{"OpenBracket", "[::1:14560", nullptr, nullptr},
                    HostPortCase{"NoPortAfterBracket", "[::1]", nullptr, nullptr},
                    HostPortCase{"Nothing", "", nullptr, nullptr}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace cas::base
