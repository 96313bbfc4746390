// SPDX-License-Identifier: BSD-3-Clause
#include "base/measure/ledger.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

#include "base/error.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

constexpr const char* kHeader = "direction,message_id,time_usec,at_ns\n";

class Ledger : public testing::Test {
 protected:
  std::string text() const {
    std::ostringstream whole;
    whole << std::ifstream(file_).rdbuf();
    return whole.str();
  }
  std::string error_of(const std::string& written) const {
    std::ofstream(file_) << written;
    return test::refusal([&] { PacketLedger::read(file_); });
  }

  test::TemporaryFolder folder_;
  std::filesystem::path file_ = folder_.path() / "ledger.csv";
};

TEST_F(Ledger, IsReadAsItWasWritten) {
  PacketLedger ledger(4);
  ledger.sent(107, 2000, RunTime(std::chrono::nanoseconds(5)));
  ledger.received(91, std::numeric_limits<std::uint64_t>::max(),
                  RunTime(std::chrono::nanoseconds(-7)));
  ledger.write(file_);
  EXPECT_EQ(text(), std::string(kHeader) + "s,107,2000,5\nr,91,18446744073709551615,-7\n");
  const auto entries = PacketLedger::read(file_);
  ASSERT_EQ(entries.size(), 2U);
  EXPECT_EQ(entries[0].direction, LedgerEntry::Direction::kSent);
  EXPECT_EQ(entries[0].message_id, 107U);
  EXPECT_EQ(entries[0].time_usec, 2000U);
  EXPECT_EQ(entries[0].at_ns, 5);
  EXPECT_EQ(entries[1].direction, LedgerEntry::Direction::kReceived);
  EXPECT_EQ(entries[1].time_usec, std::numeric_limits<std::uint64_t>::max());
  EXPECT_EQ(entries[1].at_ns, -7);
}

TEST_F(Ledger, ReadsAnEmptyOneAndALastLineWithoutItsEnd) {
  EXPECT_EQ(error_of(kHeader), "");
  EXPECT_EQ(error_of(std::string(kHeader) + "s,1,2,3"), "");
}

TEST_F(Ledger, SaysWhichLineIsWrong) {
  EXPECT_NE(error_of("").find("is no packet ledger"), std::string::npos);
  for (const char* row : {"x,1,2,3", "s,1,2", "s,1,2,3,4", "s,-1,2,3", "s,1,2,", "s1,2,3", ""}) {
    const std::string error = error_of(std::string(kHeader) + "s,1,2,3\n" + row + "\n");
    EXPECT_NE(error.find("ledger.csv:3: is no ledger line"), std::string::npos) << row << error;
  }
}

TEST_F(Ledger, OfMoreThanAGibibyteIsRefused) {
  std::ofstream(file_) << kHeader;
  std::filesystem::resize_file(file_, (std::uintmax_t{1} << 30U) + 1);  // no byte is written
  EXPECT_EQ(test::refusal([&] { PacketLedger::read(file_); }),
            file_.string() + ": packet ledger is larger than the 1024 MiB that are read");
}

TEST_F(Ledger, OfAFileThatIsNotThereIsAnError) {
  EXPECT_THROW(PacketLedger::read(folder_.path() / "none.csv"), ConfigError);
}

}  // namespace
}  // namespace cas::base
