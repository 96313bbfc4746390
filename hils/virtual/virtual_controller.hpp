// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "base/measure/ledger.hpp"
#include "base/time/clock.hpp"
#include "fcu/core/fcu_config.hpp"
#include "fcu/flight_controller.hpp"
#include "fcu/line/line_model.hpp"

namespace cas::hils {

/// The emulated controller behind its serial line, moved by the virtual clock: fcu_emulator without
/// the pseudo-terminal.
///
///   write() --> line up --> FlightController --> line down --> on_bytes
class VirtualController {
 public:
  using OnBytes = std::function<void(std::span<const std::uint8_t>, base::RunTime)>;

  /// @param on_bytes  called with the bytes that leave the line
  VirtualController(const fcu::FcuConfig& config, OnBytes on_bytes);
  VirtualController(const VirtualController&) = delete;
  VirtualController& operator=(const VirtualController&) = delete;

  /// Bytes into the line. @return how many it took
  std::size_t write(std::span<const std::uint8_t> bytes, base::RunTime now);
  /// Hands over bytes that have arrived at either end, and runs ticks that are due.
  void run(base::RunTime now);
  base::RunTime next_event(base::RunTime now) const;

  fcu::FlightController& controller() { return controller_; }
  const fcu::FlightController& controller() const { return controller_; }
  const fcu::EmulatorLine& line() const { return line_; }
  /// For faults.
  fcu::EmulatorLine& line() { return line_; }
  const std::vector<base::LedgerEntry>& ledger() const { return ledger_.entries(); }

 private:
  fcu::EmulatorLine line_;
  fcu::FlightController controller_;
  base::PacketLedger ledger_;
  OnBytes on_bytes_;
  std::vector<std::uint8_t> buffer_;
  base::RunTime now_{};
  base::RunTime next_tick_{};
};

}  // namespace cas::hils
