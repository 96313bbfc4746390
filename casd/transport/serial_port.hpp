// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <string>

#include "base/os/descriptor.hpp"

namespace cas::casd {

struct SerialOptions {
  unsigned baud = 0;  ///< any rate; 0 leaves the driver's
  bool flow_control = false;
};

/// Opens a serial device: raw, exclusive (flock), its old input and output thrown away, low latency
/// where the driver knows the word. @return nothing, with the reason in `error`
base::Descriptor open_serial(const std::string& device, const SerialOptions& options,
                             std::string& error);

/// Bytes that the driver has not yet put on the line; 0 where it cannot tell.
std::size_t unsent_bytes(int fd);
/// A pseudo-terminal has no line, and its count of unsent bytes no meaning.
bool is_pseudo_terminal(int fd);

}  // namespace cas::casd
