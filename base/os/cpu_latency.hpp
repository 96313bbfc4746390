// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <optional>

#include "base/export.hpp"
#include "base/os/descriptor.hpp"

namespace cas::base {

/// Asks the kernel that no idle processor sleeps deeper than it can wake from in time (PM QoS:
/// Linux, Documentation/power/pm_qos_interface.rst). Without it the processor that a packet wakes
/// may first have to leave a power-saving state, at each hop. In force as long as the object lives.
class CAS_BASE_EXPORT CpuLatencyRequest {
 public:
  static constexpr const char* kDevice = "/dev/cpu_dma_latency";
  static constexpr int kLongest_us = 10'000;

  /// @param most_us  longest time to wake, microseconds; 0: the lightest idle state, which is to
  ///                 poll where the processor's driver has that (x86); nullopt: no request
  /// Without the right to the device there is a warning, and the request is not in force.
  explicit CpuLatencyRequest(std::optional<int> most_us,
                             const std::filesystem::path& device = kDevice);

  bool in_force() const { return static_cast<bool>(device_); }

 private:
  Descriptor device_;
};

}  // namespace cas::base
