// SPDX-License-Identifier: BSD-3-Clause
#include "web/server/access_rules.hpp"

#include <gtest/gtest.h>

namespace cas::web {
namespace {

TEST(AccessRules, ServeTheNamesOfThisMachineWithOurPortAlone) {
  const AccessRules rules(5791, {"bench.local"});
  for (const char* host :
       {"127.0.0.1:5791", "localhost:5791", "LOCALHOST:5791", "[::1]:5791", "bench.local:5791"}) {
    EXPECT_TRUE(rules.allows_host(host)) << host;
  }
  for (const char* host :
       {"", "127.0.0.1", "127.0.0.1:80", "localhost:57910", "evil.example:5791",
        "127.0.0.1:5791.evil.example", "user@127.0.0.1:5791", "127.0.0.1:5791 "}) {
    EXPECT_FALSE(rules.allows_host(host)) << host;
  }
}

TEST(AccessRules, LeaveOutThePortWhereBrowsersDo) {
  EXPECT_TRUE(AccessRules(80, {}).allows_host("localhost"));
}

TEST(AccessRules, TakeAWebSocketFromOurOwnPageAlone) {
  const AccessRules rules(5791, {});
  EXPECT_TRUE(rules.allows_origin("http://localhost:5791", "localhost:5791"));
  // Origins of a foreign page, another port, a file, and of a client that is no browser.
  for (const char* origin : {"http://evil.example", "http://localhost:8080",
                             "https://localhost:5791", "http://127.0.0.1:5791", "null", ""}) {
    EXPECT_FALSE(rules.allows_origin(origin, "localhost:5791")) << origin;
  }
  // A name that was made to lead here agrees with itself, and is not ours.
  EXPECT_FALSE(rules.allows_origin("http://evil.example:5791", "evil.example:5791"));
}

}  // namespace
}  // namespace cas::web
