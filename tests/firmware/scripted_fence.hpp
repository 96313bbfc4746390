// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>

#include "base/time/clock.hpp"
#include "mavlink_gen/runtime/packet.hpp"

namespace cas::test {

class Channel;

/// Whose fence is scripted.
enum class FenceStyle { kPx4_1_12, kPx4_1_16, kCopter_4_5 };

/// How a scripted autopilot takes its own fence.
enum class FenceManner { kKeeps, kNeverActs, kSaysNothing };

/// The fence of a scripted autopilot: its parameters by the parameter protocol, its breaches, and
/// the texts and actions on them. No I/O and no clock.
class ScriptedFence {
 public:
  enum class Action { kNone, kHold, kReturn, kLand };

  explicit ScriptedFence(FenceStyle style, FenceManner manner = FenceManner::kKeeps);

  /// Takes PARAM_REQUEST_READ and PARAM_SET of its parameters. @return whether it was one
  bool on_packet(const mav::PacketView& packet, Channel& ground);
  /// @param p_home_N  the vehicle's position from home, north, east, down in m @return action of a
  ///     new breach
  Action update(const Eigen::Vector3d& p_home_N, base::RunTime now);
  /// Texts on the newest breach, each once; empty: no more.
  std::string take_text();

  double param(const std::string& name) const { return params_.at(name).value; }

 private:
  struct Param {
    double value = 0;
    bool whole = false;
  };

  bool is_px4() const { return style_ != FenceStyle::kCopter_4_5; }
  bool is_outside(const Eigen::Vector3d& p_home_N) const;
  Action action() const;
  void say();
  void answer(const std::string& name, Channel& ground) const;

  FenceStyle style_;
  FenceManner manner_;
  std::map<std::string, Param> params_;
  std::optional<base::RunTime> checked_;
  bool outside_ = false;
  std::string texts_;  // a line each
};

}  // namespace cas::test
