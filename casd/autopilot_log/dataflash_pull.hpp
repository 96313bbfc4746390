// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <map>
#include <vector>

#include "base/time/clock.hpp"
#include "casd/autopilot_log/log_pull.hpp"
#include "mavlink_gen/services/remote_log.hpp"

namespace cas::casd {

using mav::services::RemoteLogBlockStatus;
using mav::services::RemoteLogDataBlock;

/// Puts the blocks of ArduPilot's dataflash log in order. Block n begins at byte 200 n of the file;
/// a lost block leaves zeros, which readers skip. Pure.
class DataflashStream {
 public:
  using Block = std::array<std::uint8_t, RemoteLogDataBlock::kBlockBytes>;

  /// ArduPilot keeps fewer unacknowledged blocks than this.
  static constexpr std::uint32_t kWindow = 1024;
  /// A missing block is requested after the first time, again after the second, and given up after
  /// the third. ArduPilot also repeats unacknowledged blocks by itself.
  static constexpr base::Duration kAskAfter = std::chrono::milliseconds(100);
  static constexpr base::Duration kAskPeriod = std::chrono::milliseconds(500);
  static constexpr base::Duration kGiveUpAfter = std::chrono::seconds(5);

  /// Bytes for the file.
  struct Part {
    std::uint64_t at = 0;             ///< offset of the first byte
    std::vector<std::uint8_t> bytes;  ///< may be empty
  };
  enum class Verdict : std::uint8_t {
    kTaken,  ///< new, or a repetition: to be acknowledged
    kStale,  ///< of a log whose beginning casd does not have
  };

  /// Whether a block begins a new log.
  bool begins(std::uint32_t number) const {
    return number < kWindow && (!began_ || (another_ && number < next_));
  }
  Verdict take(std::uint32_t number, const Block& block, Part& part, base::RunTime now);
  /// @param part  gets the blocks behind one that is given up
  /// @return blocks to request
  std::vector<std::uint32_t> tick(Part& part, base::RunTime now);
  /// The vehicle may begin a new log: from now on a lower block number is one of it.
  void expect_another() { another_ = true; }
  bool began() const { return began_; }
  void reset() { *this = {}; }

 private:
  void take_in_order(Part& part, base::RunTime now);

  bool began_ = false;
  bool another_ = false;
  std::uint32_t next_ = 0;                ///< the next block of the file
  std::map<std::uint32_t, Block> early_;  ///< blocks behind it; fewer than kWindow
  base::RunTime missing_since_{};         ///< while there are early blocks: when next_ was missed
  base::RunTime ask_at_{};
};

/// ArduPilot's log: REMOTE_LOG_BLOCK_STATUS with the order to start until blocks come, then an
/// acknowledgement of each block. ArduPilot does not answer an order, and unless LOG_DISARMED is
/// set it sends nothing before it is armed.
class DataflashPull final : public LogPull {
 public:
  using LogPull::LogPull;

 private:
  void take(const mav::PacketView& packet) override;
  void ask() override;
  void ask_to_end() override;
  void forget() override;
  void take(const RemoteLogDataBlock& block);
  void order_start();
  void say(std::uint32_t number, std::uint8_t status);

  DataflashStream stream_;
  bool ordered_ = false;  ///< since the vehicle's last restart
};

}  // namespace cas::casd
