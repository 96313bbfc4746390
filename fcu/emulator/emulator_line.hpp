// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "base/time/clock.hpp"
#include "fcu/line/line_model.hpp"

namespace cas::fcu {

/// Both directions of the emulated controller's serial line. Downwards only whole packets enter: a
/// packet without room in the send buffer is dropped and counted, as a controller's driver does.
class EmulatorLine {
 public:
  EmulatorLine(const LineConfig& config, std::uint64_t seed);

  // Towards the controller.
  std::size_t up_room(base::RunTime now) const;
  void receive(std::span<const std::uint8_t> bytes, base::RunTime now) { up_.write(bytes, now); }
  std::size_t up(std::span<std::uint8_t> out, base::RunTime now) { return up_.read(out, now); }

  // From the controller.
  void send(std::span<const std::uint8_t> packet, base::RunTime now);
  std::size_t down(std::span<std::uint8_t> out, base::RunTime now) { return down_.read(out, now); }
  /// Nobody takes what comes out: nothing more goes in.
  void hold(bool held) { held_ = held; }

  /// When something arrives at either end, or room appears for what waits to come up.
  std::optional<base::RunTime> next_event(base::RunTime now) const;

  void configure(const LineConfig& config);
  const LineConfig& config() const { return up_.config(); }
  void hang_up();
  void restore();

  const LineModel::Stats& up_stats() const { return up_.stats(); }
  const LineModel::Stats& down_stats() const { return down_.stats(); }
  std::uint64_t dropped_packets() const { return dropped_packets_; }

 private:
  LineModel up_;
  LineModel down_;
  bool held_ = false;
  std::uint64_t dropped_packets_ = 0;
};

}  // namespace cas::fcu
