// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "base/config/config.hpp"
#include "base/time/clock.hpp"

namespace cas::fcu {

/// What a serial line does to the bytes of one direction. Everything that is zero is switched off.
struct LineConfig {
  std::string preset = "ideal";  ///< ideal | usb | baud_921600 | baud_460800 | baud_115200
  double baud = 0;               ///< byte clock, 10 bits a byte; 0 = no byte clock
  double clock_drift_ppm = 0;    ///< sender's clock against its nominal rate; positive is slow
  base::Duration extra_delay{};  ///< added to every byte
  base::Duration jitter{};       ///< uniform 0..jitter added per write, order is kept
  base::Duration batch{};  ///< bytes arrive in batches, one each time this has passed (USB: 1 ms)
  base::Duration stall_every{};       ///< mean time between stalls (exponential)
  base::Duration stall_length{};      ///< how long nothing moves in a stall
  double bit_error_rate = 0;          ///< probability that one bit is flipped
  double burst_begin = 0;             ///< Gilbert-Elliott: probability per byte, good -> bad
  double burst_end = 1;               ///< Gilbert-Elliott: probability per byte, bad -> good
  double burst_loss = 1;              ///< probability that a byte is lost while bad
  double packet_loss = 0;             ///< probability that one write is lost as a whole
  std::size_t send_buffer_bytes = 0;  ///< room before the writer is held back; 0 = endless
  std::size_t receive_fifo_bytes =
      0;  ///< bytes that may wait to be read; more overrun; 0 = endless
  /// A receiver is woken after this many bytes of a longer write: the trigger level of its FIFO.
  std::size_t receive_trigger_bytes = 128;

  /// The figures behind a preset's name. @throws base::ConfigError for an unknown name
  static LineConfig from_preset(const std::string& name);
  /// Reads a `line:` block: a preset and the keys that override it (durations as *_us).
  static LineConfig parse(const base::ConfigNode& node);
};

}  // namespace cas::fcu
