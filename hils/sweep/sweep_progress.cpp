// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/sweep_progress.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace cas::hils {

namespace {

constexpr std::size_t kBar = 20;

std::string clock_text(double seconds) {
  const long whole = std::lround(seconds);
  if (whole >= 3600)
    return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
  return fmt::format("{}:{:02}", whole / 60, whole % 60);
}

}  // namespace

std::string sweep_line(const SweepState& state) {
  const std::size_t full = state.all > 0 ? state.done * kBar / state.all : kBar;
  std::string line = fmt::format("{}: [{}{}] {} of {}", state.verb, std::string(full, '#'),
                                 std::string(kBar - full, '-'), state.done, state.all);
  const double elapsed_s = base::to_seconds(state.elapsed);
  if (state.flown > 0 && elapsed_s > 0) {
    const double rate = static_cast<double>(state.flown) / elapsed_s;
    line += fmt::format(", {:.1f} runs/s", rate);
    if (state.done < state.all && (state.flown >= 10 || state.flown * 20 >= state.all)) {
      line += ", " + clock_text(static_cast<double>(state.all - state.done) / rate) + " left";
    }
  }
  if (state.unjudged > 0) line += fmt::format(", {} without a verdict", state.unjudged);
  return line;
}

SweepProgress::SweepProgress() : terminal_(::isatty(STDERR_FILENO) == 1) {}

SweepProgress::~SweepProgress() { clear(); }

void SweepProgress::show(const SweepState& state) {
  if (terminal_) {
    fmt::print(stderr, "\r\x1b[K{}", sweep_line(state));
    std::fflush(stderr);
    drawn_ = true;
    return;
  }
  const std::size_t tenth = state.all > 0 ? state.done * 10 / state.all : 10;
  if (tenth == tenth_) return;
  tenth_ = tenth;
  fmt::print(stderr, "{}\n", sweep_line(state));
}

void SweepProgress::clear() {
  if (drawn_) fmt::print(stderr, "\r\x1b[K");
  drawn_ = false;
}

}  // namespace cas::hils
