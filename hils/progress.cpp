// SPDX-License-Identifier: BSD-3-Clause
#include "hils/progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>

namespace cas::hils {

namespace {

constexpr const char* kEraseLine = "\r\x1b[K";

std::string step_text(base::SimTime now, const FlightPlan& plan) {
  const FlightStep* step = plan.current();
  if (step == nullptr) return "done";
  const double elapsed = base::to_seconds(plan.elapsed_in_step(now));
  if (step->kind == StepKind::kHold) {
    return fmt::format("{}hold {:4.1f} of {:.1f} s", step->measure ? "measured " : "", elapsed,
                       base::to_seconds(step->duration));
  }
  return fmt::format("{} {:4.1f} s", phase_of(*step), elapsed);
}

}  // namespace

Progress::Progress() : terminal_(::isatty(STDERR_FILENO) == 1) {}

Progress::~Progress() { clear(); }

void Progress::show(base::SimTime now, const FlightPlan& plan, const VehicleReport& vehicle,
                    double real_time_factor, const std::string& stream) {
  if (!terminal_) return;
  shown_ = true;
  fmt::print(
      stderr, "{}{:6.1f} s  {:<28} x {:+6.2f} y {:+6.2f} z {:6.2f} m  {:.2f} x real time{}{}",
      kEraseLine, base::to_seconds(now), step_text(now, plan), vehicle.p_N.x(), vehicle.p_N.y(),
      -vehicle.p_N.z(), real_time_factor, stream.empty() ? "" : "  ", stream);
  std::fflush(stderr);
}

void Progress::clear() {
  if (shown_) fmt::print(stderr, "{}", kEraseLine);
  shown_ = false;
}

}  // namespace cas::hils
