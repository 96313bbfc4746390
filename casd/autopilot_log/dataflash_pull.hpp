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
  explicit DataflashPull(LogPullHooks hooks) : hooks_(std::move(hooks)) {}

  void on_packet(const mav::PacketView& packet, base::RunTime now) override;
  void tick(base::RunTime now) override;
  void stop(base::RunTime now) override;
  void restart(base::RunTime now) override;

 private:
  void take(const RemoteLogDataBlock& block, base::RunTime now);
  void write(DataflashStream::Part part, base::RunTime now);
  void ask(base::RunTime now);
  void say(std::uint32_t number, std::uint8_t status);

  LogPullHooks hooks_;
  DataflashStream stream_;
  bool wanted_ = false;
  bool ordered_ = false;  ///< since the vehicle's last restart
  base::RunTime next_ask_{};
  base::RunTime next_file_{};
  base::RunTime heard_at_{};
  base::Duration retry_ = kFirstRetry;
};

}  // namespace cas::casd
