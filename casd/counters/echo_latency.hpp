// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <vector>

#include "base/measure/histogram.hpp"
#include "base/os/mutex.hpp"
#include "base/time/clock.hpp"
#include "casd/packet/packet_info.hpp"

namespace cas::casd {

/// How long controllers take, as casd sees it: from a HIL_SENSOR read on one link to the controls
/// that echo its time_usec read on another. Line, controller and line back are in it. A stock
/// autopilot echoes its own clock: then nothing matches.
///
/// Any thread. Memory is taken with a vehicle's first message, for 250 of them at most: a table of
/// its newest stamps, and a histogram.
class EchoLatency {
 public:
  struct Figures {
    std::uint8_t system = 0;
    std::uint64_t matched = 0;
    std::uint64_t unmatched = 0;  ///< controls whose stamp no sensor message had
    base::Duration p50{}, p99{}, max{};
  };

  /// From a link's thread, for each packet that it received.
  void on_packet(const PacketInfo& packet, base::RunTime now);
  /// By system id.
  std::vector<Figures> figures() const;

  static constexpr std::size_t kMaxVehicles = 250;

 private:
  struct Sent {
    std::atomic<std::uint64_t> key{0};
    std::atomic<std::int64_t> at_ns{0};
  };
  struct Vehicle {
    base::Histogram times;
    std::uint64_t unmatched = 0;
  };
  static constexpr std::size_t kStamps = 1024;  // two seconds of 500 Hz
  using Stamps = std::array<Sent, kStamps>;

  void on_sensor(std::uint64_t key, std::uint8_t system, base::RunTime now);
  void on_controls(std::uint64_t key, std::uint8_t system, base::RunTime now);
  bool matches(std::uint64_t key, std::uint8_t system, std::int64_t& at_ns) const;
  Stamps* stamps_of(std::uint8_t system);
  static std::size_t place_of(std::uint64_t key);

  /// What simulators sent by system id, which keeps vehicles apart; nullptr: nothing yet.
  std::array<std::atomic<Stamps*>, 256> sent_{};
  mutable base::Mutex mutex_;
  std::vector<std::unique_ptr<Stamps>> owned_ CAS_GUARDED_BY(mutex_);
  std::map<std::uint8_t, Vehicle> vehicles_ CAS_GUARDED_BY(mutex_);
};

}  // namespace cas::casd
