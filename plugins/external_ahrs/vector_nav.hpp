// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/time/clock.hpp"
#include "base/time/rate_gate.hpp"
#include "plugins/external_ahrs/line_budget.hpp"
#include "plugins/external_ahrs/unit_registers.hpp"

namespace cas::sim {

/// Models of the unit, by what a driver tells apart.
enum class UnitModel : std::uint8_t { kVn100, kVn200, kVn300 };

/// The samples that came since the last packet with such a sample.
struct FreshSamples {
  bool inertial = false;
  bool fix = false;
};

/// The whole unit without its line: bytes in, answers and packets out. Pure; time is an argument.
///
///   receive() --> answers()           a user's driver asks for packets
///   advance(now) --> next(now, ...)   the packet to send now, until there is none
///
/// A packet is built when the line has room for it, from the readings of that moment, so that none
/// is ever old. The fastest output goes first; another one is sent when it fits between two of the
/// fastest, or, where none does, when half of its period is over. An output whose packet did not
/// leave before the next one was due has lost it, which is counted.
class VectorNav {
 public:
  /// More than this a packet does not wait for the line.
  static constexpr base::Duration kMostWait = std::chrono::milliseconds(5);

  struct Counts {
    std::array<std::uint64_t, UnitRegisters::kOutputs> sent{};  ///< of registers 75, 76 and 77
    std::uint64_t bytes = 0;                                    ///< packets and answers
    std::uint64_t dropped = 0;                                  ///< for lack of room on the line
    std::uint64_t without_sample = 0;  ///< due, and there was no new sample
    std::uint64_t late = 0;            ///< sent, but waited for the line for 1 ms or longer
    base::Duration longest_wait{};     ///< for the line
  };

  /// @param baud  of the line; 0: it has no rate of its own
  VectorNav(UnitModel model, unsigned baud);

  void receive(std::span<const std::uint8_t> bytes) { registers_.feed(bytes, answers_); }
  /// Takes the answers that wait, for the line. Call before next().
  std::string take_answers(base::SimTime now);
  /// Bytes that the driver of the line holds unsent.
  void on_unsent(base::SimTime now, std::size_t bytes) { line_.add_unsent(now, bytes); }

  /// Notes which outputs are due. Once for each step.
  void advance(base::SimTime now);
  /// The next packet to send now; empty: none. It lives until the next call.
  std::span<const std::uint8_t> next(base::SimTime now, const UnitReadings& readings,
                                     FreshSamples& fresh);

  /// Back to time zero. The user's driver goes on: registers are kept.
  void reset();

  const UnitRegisters& registers() const { return registers_; }
  /// Present rate of one output; 0: it is off.
  double rate_hz(std::size_t output) const;
  const Counts& counts() const { return counts_; }

 private:
  /// An output that flows.
  struct Stream {
    std::size_t output = 0;
    base::RateGate gate;
    base::Duration period{};
    std::size_t bytes = 0;
    std::optional<base::SimTime> due;  ///< since then a packet is due
    bool lacked_sample = false;        ///< since it is due, at the last look
  };

  void rebuild(base::SimTime now);
  bool may_go(const Stream& stream, base::SimTime now) const;

  double base_hz_;
  UnitRegisters registers_;
  LineBudget line_;
  std::string answers_;
  unsigned revision_ = 0;
  std::vector<Stream> streams_;  ///< the fastest first
  std::vector<std::uint8_t> packet_;
  Counts counts_;
};

}  // namespace cas::sim
