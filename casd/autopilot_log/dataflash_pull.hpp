// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/autopilot_log/dataflash_stream.hpp"
#include "casd/autopilot_log/log_pull.hpp"

namespace cas::casd {

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
