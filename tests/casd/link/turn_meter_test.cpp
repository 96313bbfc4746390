// SPDX-License-Identifier: BSD-3-Clause
#include "casd/link/turn_meter.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <poll.h>
#include <unistd.h>

#include <ctime>
#include <vector>

namespace cas::casd {
namespace {

using std::chrono::milliseconds;

TEST(TurnExcess, IsASentenceBeyondABound) {
  struct ExcessCase {
    const char* name;
    TurnUse use;
    bool exceeds;
  };
  const ExcessCase rows[] = {
      {"Usual", {.processor = milliseconds(1), .read_bytes = 65536, .waits = 3}, false},
      {"Processor", {.processor = milliseconds(211)}, true},
      {"Bytes", {.read_bytes = 3 * 65536 + 1}, true},
      {"Waits", {.waits = 145}, true}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.name);
    EXPECT_EQ(excess(row.use, 2).has_value(), row.exceeds);
  }
}

TEST(TurnMeter, CountsBytesThatWereRead) {
  TurnMeter meter;
  const base::Descriptor zero(::open("/dev/zero", O_RDONLY | O_CLOEXEC));
  std::vector<char> bytes(1U << 20U);
  meter.begin();
  ASSERT_EQ(::read(zero.get(), bytes.data(), bytes.size()), static_cast<ssize_t>(bytes.size()));
  const TurnUse use = meter.end();
  if (::access("/proc/thread-self/io", R_OK) != 0) GTEST_SKIP() << "this kernel counts no bytes";
  EXPECT_GE(use.read_bytes, bytes.size());
}

TEST(TurnMeter, CountsWaits) {
  TurnMeter meter;
  meter.begin();
  for (int i = 0; i < 5; ++i) ::poll(nullptr, 0, 1);
  EXPECT_GE(meter.end().waits, 1U);
}

TEST(TurnMeter, LeavesOutWaitsThatAreWanted) {
  TurnMeter meter;
  for (int i = 0; i < 5; ++i) {  // a reserve, in case a poll below does not sleep
    count_wanted_wait();
    ::poll(nullptr, 0, 1);
  }
  meter.begin();
  for (int i = 0; i < 100; ++i) {
    count_wanted_wait();
    ::poll(nullptr, 0, 1);
  }
  EXPECT_LT(meter.end().waits, 50U);
}

TEST(TurnMeter, CountsProcessorTime) {
  TurnMeter meter;
  meter.begin();
  const std::clock_t begin = std::clock();
  volatile unsigned sum = 0;
  while (std::clock() - begin < CLOCKS_PER_SEC / 200) sum = sum + 1;
  EXPECT_GE(meter.end().processor, milliseconds(4));  // 5, by a coarser clock
}

}  // namespace
}  // namespace cas::casd
