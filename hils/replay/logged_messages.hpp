// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "hils/measure/tracking.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::hils {

/// What a flight log lacks.
struct LoggedLoss {
  std::uint64_t skipped_bytes = 0;
  std::uint64_t wrong_checksums = 0;
  std::uint64_t clock_steps = 0;  ///< of the recorder's clock

  /// For a person; empty: nothing.
  std::string sentence() const;
};

/// Collects a vehicle's messages for the page, in the order of time:
///
///   messages: name, packets in each second, and each number as a series of at most 20 Hz
///   texts:    STATUSTEXT, put together where it came in several packets
///   states:   the mode of the autopilot's HEARTBEAT and EXTENDED_SYS_STATE's landed state, when
///             one of them changed
///   duration_s: time of the last packet
class MessageCollector {
 public:
  MessageCollector();
  MessageCollector(MessageCollector&&) noexcept;
  ~MessageCollector();

  /// @param t_s  since the begin of the log
  void on_packet(double t_s, const mav::PacketView& packet);
  nlohmann::ordered_json json() const;

 private:
  class Collected;
  std::unique_ptr<Collected> collected_;
};

/// A vehicle's messages in a flight log, as MessageCollector gives them.
///
/// @param clock  leads from the log's clock to simulated time; an empty one counts from the log's
///               first packet, whatever the recorder's clock did (TlogClock)
/// @throws base::ConfigError when the log cannot be read
nlohmann::ordered_json logged_messages(const std::filesystem::path& tlog, std::uint8_t system,
                                       const ClockMap& clock, LoggedLoss* lost = nullptr);

/// System of the first autopilot in a flight log; 0: there is none. @throws base::ConfigError
std::uint8_t first_autopilot(const std::filesystem::path& tlog);

}  // namespace cas::hils
