// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string_view>

#include "base/time/clock.hpp"

namespace cas::hils {

/// Time for which some task of the machine has waited for a processor, since boot, out of the text
/// of /proc/pressure/cpu. nullopt when the text is another.
std::optional<base::Duration> parse_cpu_pressure(std::string_view text);

/// Measures the share of time in which a task on this machine waited for a processor: near zero on
/// a quiet machine, near one on a busy one.
class CpuPressure {
 public:
  void start();
  void stop();
  /// Between start() and stop(); nullopt where the kernel does not tell.
  std::optional<double> share() const { return share_; }

 private:
  std::optional<base::Duration> waited_before_;
  base::RunTime began_{};
  std::optional<double> share_;
};

}  // namespace cas::hils
