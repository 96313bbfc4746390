// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/takeoff_height.hpp"

#include <string>
#include <utility>

namespace cas::casd {

std::string TakeoffHeight::parameter() const {
  return state_.autopilot() == Autopilot::kArduPilot ? "TKOFF_ALT" : "MIS_TAKEOFF_ALT";
}

void TakeoffHeight::write(double altitude_m, std::function<base::RunTime()> clock, Done done) {
  const base::RunTime now = clock();
  params_.set(parameter(), altitude_m, now,
              [this, clock = std::move(clock), done = std::move(done)](const Outcome& set) {
                if (!set.ok()) return done(set);
                const auto before = set.before.find(parameter());
                if (before != set.before.end() && !before_) before_ = before->second;
                written_ = clock();
                done(set);
              });
}

void TakeoffHeight::put_back(base::RunTime now) {
  const std::optional<double> before = std::exchange(before_, std::nullopt);
  if (!before) return;
  putting_back_ = true;
  params_.set(parameter(), *before, now, [this](const Outcome& put) {
    putting_back_ = false;
    for (const Done& takeoff : std::exchange(then_, {})) takeoff(put);
  });
}

}  // namespace cas::casd
