// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "base/time/clock.hpp"
#include "plugins/fault/fault_spec.hpp"

namespace cas::sim {

/// The beginning or the end of a fault, as it is logged.
struct FaultEvent {
  base::SimTime time;
  std::size_t fault = 0;  ///< index in the list
  bool begins = false;
};

/// Decides which faults begin and end. Each happens once in a run.
class FaultSchedule {
 public:
  FaultSchedule() = default;
  explicit FaultSchedule(std::vector<FaultSpec> faults);

  /// Calls on_event(FaultEvent) for each fault that begins or ends at `now`.
  template <class OnEvent>
  void update(base::SimTime now, const Facts& facts, OnEvent&& on_event) {
    for (std::size_t i = 0; i < faults_.size(); ++i) {
      if (states_[i] == State::kWaiting && begins(faults_[i], now, facts)) {
        states_[i] = State::kActive;
        since_[i] = now;
        on_event(FaultEvent{now, i, true});
      } else if (states_[i] == State::kActive && ends(i, now, facts)) {
        states_[i] = State::kOver;
        on_event(FaultEvent{now, i, false});
      }
    }
  }
  void reset();

  const std::vector<FaultSpec>& faults() const { return faults_; }
  bool is_active(std::size_t fault) const { return states_[fault] == State::kActive; }

 private:
  enum class State : std::uint8_t { kWaiting, kActive, kOver };

  static bool begins(const FaultSpec& fault, base::SimTime now, const Facts& facts);
  bool ends(std::size_t fault, base::SimTime now, const Facts& facts) const;

  std::vector<FaultSpec> faults_;
  std::vector<State> states_;
  std::vector<base::SimTime> since_;
};

}  // namespace cas::sim
