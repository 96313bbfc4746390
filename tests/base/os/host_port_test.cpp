// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/host_port.hpp"

#include <gtest/gtest.h>

namespace cas::base {
namespace {

TEST(HostPortText, IsTakenApart) {
  struct HostPortCase {
    const char* name;
    const char* text;
    const char* host;  ///< nullptr: no HOST:PORT
    const char* port;
  };
  const HostPortCase rows[] = {{"V4", "127.0.0.1:14560", "127.0.0.1", "14560"},
                               {"Name", "localhost:0", "localhost", "0"},
                               {"V6", "[::1]:14560", "::1", "14560"},
                               {"BareV6", "::1:14560", "::1", "14560"},
                               {"NoColon", "localhost", nullptr, nullptr},
                               {"NoHost", ":14560", nullptr, nullptr},
                               {"NoPort", "localhost:", nullptr, nullptr},
                               {"EmptyBrackets", "[]:14560", nullptr, nullptr},
                               {"OpenBracket", "[::1:14560", nullptr, nullptr},
                               {"NoPortAfterBracket", "[::1]", nullptr, nullptr},
                               {"Nothing", "", nullptr, nullptr}};
  for (const auto& [name, text, host, port] : rows) {
    SCOPED_TRACE(name);
    const std::optional<HostPort> parts = parse_host_port(text);
    ASSERT_EQ(parts.has_value(), host != nullptr);
    if (!parts) continue;
    EXPECT_EQ(parts->host, host);
    EXPECT_EQ(parts->port, port);
  }
}

}  // namespace
}  // namespace cas::base
