// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/progress.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdio>

#include "base/printable.hpp"

namespace cas::hils {

namespace {

constexpr const char* kEraseLine = "\r\x1b[K";
constexpr std::size_t kUsualColumns = 80;
constexpr base::Duration kFirstPlain = std::chrono::seconds(2);
constexpr base::Duration kPlainPeriod = std::chrono::seconds(10);

/// A line that reaches the last column would wrap, and the terminal would keep half of it.
std::size_t usable_columns() {
  winsize size{};
  const bool known = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 1;
  return (known ? size.ws_col : kUsualColumns) - 1;
}

std::string step_text(base::SimTime now, const FlightPlan& plan) {
  const FlightStep* step = plan.current();
  if (step == nullptr) return "done";
  const double elapsed = base::to_seconds(plan.elapsed_in_step(now));
  if (step->kind == StepKind::kHold) {
    return fmt::format("{} {:4.1f} of {:.1f} s", step->measure ? "measured" : "hold", elapsed,
                       base::to_seconds(step->duration));
  }
  return fmt::format("{} {:4.1f} s", phase_of(*step), elapsed);
}

}  // namespace

std::string pace_words(double real_time_factor, std::optional<std::uint64_t> late_steps) {
  const std::string factor = fmt::format("{:.2f}x", real_time_factor);
  return late_steps.value_or(0) > 0 ? fmt::format("{}, {} late", factor, *late_steps) : factor;
}

std::string progress_line(base::SimTime now, const FlightPlan& plan, const VehicleReport& vehicle,
                          const std::string& pace, const std::string& stream, std::size_t columns) {
  std::string line = fmt::format("{:6.1f} s  {:<24}", base::to_seconds(now), step_text(now, plan));
  const std::string parts[] = {" " + pace,
                               fmt::format("  estimate x {:+.2f} y {:+.2f} z {:.2f} m",
                                           vehicle.p_N.x(), vehicle.p_N.y(), -vehicle.p_N.z()),
                               stream.empty() ? "" : "  " + stream};
  for (const std::string& part : parts) {
    if (line.size() + part.size() > columns) break;
    line += part;
  }
  if (line.size() > columns) line.resize(columns);
  return line;
}

std::string plain_progress_line(base::SimTime now, const FlightPlan& plan,
                                const VehicleReport& vehicle, const std::string& pace) {
  constexpr std::size_t kNoEdge = 160;
  return fmt::format("hils: step {} of {}, {}", std::min(plan.completed() + 1, plan.size()),
                     plan.size(), progress_line(now, plan, vehicle, pace, {}, kNoEdge));
}

Progress::Progress()
    : terminal_(::isatty(STDERR_FILENO) == 1), next_plain_(base::steady_now() + kFirstPlain) {}

Progress::~Progress() { clear(); }

void Progress::show(base::SimTime now, const FlightPlan& plan, const VehicleReport& vehicle,
                    const std::string& pace, const std::string& stream) {
  if (!terminal_) {
    if (!shows()) return;
    next_plain_ = base::steady_now() + kPlainPeriod;
    fmt::print(stderr, "{}\n", base::printable(plain_progress_line(now, plan, vehicle, pace)));
    return;
  }
  const std::string line =
      base::printable(progress_line(now, plan, vehicle, pace, stream, usable_columns()));
  if (line == shown_) return;
  shown_ = line;
  fmt::print(stderr, "{}{}", kEraseLine, line);
  std::fflush(stderr);
}

void Progress::clear() {
  if (!shown_.empty()) fmt::print(stderr, "{}", kEraseLine);
  shown_.clear();
}

}  // namespace cas::hils
