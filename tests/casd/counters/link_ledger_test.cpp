// SPDX-License-Identifier: BSD-3-Clause
#include "casd/counters/link_ledger.hpp"

#include <gtest/gtest.h>

#include <fstream>

#include "base/error.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::casd {
namespace {

PacketInfo info(std::uint32_t message_id, std::uint64_t stamp, std::int64_t received_ns) {
  PacketInfo info;
  info.message_id = message_id;
  info.hil_time_usec = stamp;
  info.received = base::RunTime(base::Duration(received_ns));
  return info;
}

TEST(LinkLedger, KeepsOnlyStampedPackets) {
  LinkLedger ledger;
  ledger.received(info(0, 0, 5));
  ledger.received(info(107, 2000, 5));
  ASSERT_EQ(ledger.received().size(), 1U);
  EXPECT_EQ(ledger.received()[0].time_usec, 2000U);
}

TEST(LinkLedger, ComesBackFromAFileAsItWas) {
  const cas::test::TemporaryFolder folder;
  LinkLedger ledger;
  ledger.received(info(107, 2000, 5));
  ledger.sent(info(91, 2000, 6), base::RunTime(base::Duration(9)));
  ledger.dropped(info(113, 4000, 7), DropCause::kAge, base::RunTime(base::Duration(11)));
  write_link_ledgers(folder / "ledger.csv", {{"fcu", &ledger}});
  const auto ledgers = read_link_ledgers(folder / "ledger.csv");
  ASSERT_EQ(ledgers.size(), 1U);
  const LinkLedger& back = ledgers.at("fcu");
  ASSERT_EQ(back.received().size(), 1U);
  ASSERT_EQ(back.sent().size(), 1U);
  ASSERT_EQ(back.dropped().size(), 1U);
  EXPECT_EQ(back.received()[0].at_ns, 5);
  EXPECT_EQ(back.sent()[0].message_id, 91U);
  EXPECT_EQ(back.sent()[0].at_ns, 9);
  EXPECT_EQ(back.dropped()[0].cause, DropCause::kAge);
}

TEST(LinkLedger, RefusesAFileThatIsNone) {
  const cas::test::TemporaryFolder folder;
  EXPECT_THROW(read_link_ledgers(folder / "missing.csv"), base::ConfigError);
  std::ofstream(folder / "bad.csv") << "link,event,message_id,time_usec,at_ns\nfcu,eaten,1,2,3\n";
  EXPECT_THROW(read_link_ledgers(folder / "bad.csv"), base::ConfigError);
}

}  // namespace
}  // namespace cas::casd
