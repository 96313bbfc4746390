// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <utility>

#include "base/config/config.hpp"
#include "hils/flight/flight_step.hpp"

namespace cas::hils {

/// Walks through the steps of a flight as they are read and refuses one that the state before it
/// does not allow: no takeoff before arm, nothing measured on the ground, no end in the air.
class FlightRehearsal {
 public:
  /// @param who  the vehicle, where errors must name it; else empty
  explicit FlightRehearsal(std::string who) : who_(std::move(who)) {}

  /// @throws base::ConfigError at `node`
  void play(const FlightStep& step, const base::ConfigNode& node);
  /// @throws base::ConfigError at `steps`
  void finish(const base::ConfigNode& steps) const;

 private:
  void play_measure(const FlightStep& step, const base::ConfigNode& node);

  [[noreturn]] void refuse(const base::ConfigNode& node, const std::string& sentence) const;

  std::string who_;
  bool armed_ = false;
  bool airborne_ = false;
  bool measured_ = false;
};

}  // namespace cas::hils
