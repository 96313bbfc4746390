// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/export.hpp"

namespace cas::base {

/// Makes an open terminal a plain serial line: 8N1, bytes as they are, no echo, no modem control.
/// @param baud  any rate; 0 leaves the driver's
/// @return false with errno set
CAS_BASE_EXPORT bool make_serial_raw(int fd, unsigned baud, bool flow_control = false);

/// Asks the driver to hand received bytes over at once, where it knows how; USB adapters hold them
/// back for up to 16 ms otherwise.
CAS_BASE_EXPORT void ask_serial_low_latency(int fd);

/// Drops old input and output of a line.
CAS_BASE_EXPORT void flush_serial(int fd);

/// Gives an open line another rate and drops the input of the old one.
/// @return false with errno set
CAS_BASE_EXPORT bool set_serial_baud(int fd, unsigned baud);

}  // namespace cas::base
