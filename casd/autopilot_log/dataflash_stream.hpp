// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <vector>

#include "base/time/clock.hpp"
#include "mavlink_gen/services/remote_log.hpp"

namespace cas::casd {

using mav::services::RemoteLogBlockStatus;
using mav::services::RemoteLogDataBlock;

/// Puts the blocks of ArduPilot's dataflash log into their order. Block n lies at n * 200 of the
/// file; one that never comes leaves zeros, which readers skip. Pure.
class DataflashStream {
 public:
  using Block = std::array<std::uint8_t, RemoteLogDataBlock::kBlockBytes>;

  /// ArduPilot holds less than this until it is acknowledged.
  static constexpr std::uint32_t kWindow = 1024;
  /// How long a block is missing before it is asked for, how often that is repeated, and for how
  /// long: ArduPilot sends by itself what is not acknowledged.
  static constexpr base::Duration kAskAfter = std::chrono::milliseconds(100);
  static constexpr base::Duration kAskPeriod = std::chrono::milliseconds(500);
  static constexpr base::Duration kGiveUpAfter = std::chrono::seconds(5);

  /// What goes to the file.
  struct Part {
    std::uint64_t at = 0;             ///< place of the first byte
    std::vector<std::uint8_t> bytes;  ///< may be empty
  };
  enum class Verdict : std::uint8_t {
    kTaken,  ///< or had been before: to be acknowledged
    kStale,  ///< of a log whose beginning is not here
  };

  /// Whether a block is of another log.
  bool begins(std::uint32_t number) const {
    return number < kWindow && (!began_ || (another_ && number < next_));
  }
  Verdict take(std::uint32_t number, const Block& block, Part& part, base::RunTime now);
  /// @param part  what a block that was given up had kept back
  /// @return blocks to ask for
  std::vector<std::uint32_t> tick(Part& part, base::RunTime now);
  /// From now on a block from the beginning is of another log.
  void expect_another() { another_ = true; }
  bool began() const { return began_; }
  /// Blocks of this log that never came.
  std::uint64_t lost() const { return lost_; }
  void reset() { *this = {}; }

 private:
  void take_in_order(Part& part, base::RunTime now);

  bool began_ = false;
  bool another_ = false;
  std::uint32_t next_ = 0;                ///< the block that is expected
  std::map<std::uint32_t, Block> early_;  ///< beyond it; fewer than kWindow
  base::RunTime missing_since_{};         ///< with `early_`: `next_`
  base::RunTime ask_at_{};
  std::uint64_t lost_ = 0;
};

}  // namespace cas::casd
