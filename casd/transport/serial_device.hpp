// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "base/os/descriptor.hpp"

namespace cas::casd {

/// How a serial device is opened.
struct SerialOptions {
  unsigned baud = 0;  ///< any rate; 0 leaves the driver's
  bool flow_control = false;
  bool unlocked_pty = false;  ///< a pseudo-terminal needs no lock
};

/// Why a device was not opened.
struct SerialRefusal {
  std::string sentence;  ///< begins with the device
  bool in_use = false;   ///< another program has it
};

/// Opens a serial device: raw, exclusive (flock), old input and output dropped, low latency where
/// the driver supports it. A pseudo-terminal that is not ours to use is left untouched.
/// @return nothing, with the reason in `refusal`
base::Descriptor open_serial(const std::string& device, const SerialOptions& options,
                             SerialRefusal& refusal);

}  // namespace cas::casd
