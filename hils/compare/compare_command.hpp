// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace cas::hils {

/// Flags of `hils compare`.
struct CompareFlags {
  std::string scenario;
  std::vector<std::string> architectures{"direct", "sitl", "ts", "loop", "tcas"};
  std::vector<unsigned> bauds{460800, 921600};
  std::size_t seeds = 5;
  std::uint64_t first_seed = 1;
  double warm_up_s = 10;
  double hold_s = 60;
  bool on_virtual_clock = false;
  bool keep = false;
  std::string out;
};

/// Flies and reports a comparison. @return exit code: 0, or 3 when no run of some variant is valid
/// @throws RunStopped, base::ConfigError
int compare(const CompareFlags& flags);

}  // namespace cas::hils
