// SPDX-License-Identifier: BSD-3-Clause
#include "casd/casctl/session/port_owner.hpp"

#include <gtest/gtest.h>

namespace cas::casctl {
namespace {

constexpr const char* kTable =
    "  sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout\n"
    "   0: 0100007F:169E 00000000:0000 0A 00000000:00000000 00:00000000 00000000  1000        0 1\n"
    "   1: 0100007F:169E 0100007F:C001 01 00000000:00000000 00:00000000 00000000    33        0 2\n"
    "   2: 00000000:169E 00000000:0000 0A 00000000:00000000 00:00000000 00000000  1001        0 3\n"
    "   3: 0100007F:1F90 00000000:0000 0A 00000000:00000000 00:00000000 00000000    33        0 "
    "4\n";

TEST(PortOwner, IsEachUserWhoListensAtThePort) {
  EXPECT_EQ(listeners(kTable, 5790), (std::set<uid_t>{1000, 1001}));
  EXPECT_EQ(listeners(kTable, 8080), (std::set<uid_t>{33}));
  EXPECT_TRUE(listeners(kTable, 5791).empty());
  EXPECT_TRUE(listeners("", 5790).empty());
}

TEST(PortOwner, IsNobodyWhereNothingListens) {
  EXPECT_FALSE(is_own_port("1"));
  EXPECT_FALSE(is_own_port("no port"));
}

}  // namespace
}  // namespace cas::casctl
