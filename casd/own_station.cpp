// SPDX-License-Identifier: BSD-3-Clause
#include "casd/own_station.hpp"

#include <algorithm>

namespace cas::casd {

void OwnStation::take_logs(const TlogConfig& config, mav::Source self) {
  if (!config.autopilot) return;
  log_taking_.emplace(config, self, commander_);
}

void OwnStation::end_logs(base::RunTime now) {
  if (log_taking_) log_taking_->logs.end(now);
}

std::optional<AutopilotLogsStatus> OwnStation::logs(base::RunTime now) const {
  if (!log_taking_) return std::nullopt;
  return log_taking_->logs.status(now);
}

void OwnStation::on_packet(const Origin& from, const mav::PacketView& packet, base::RunTime now) {
  const auto verdict = failures_.on_packet(from, packet, base::steady_now());
  if (verdict != FailureInjector::Verdict::kRefused) commander_.on_packet(from, packet, now);
  if (log_taking_) log_taking_->logs.on_packet(from, packet, now);
}

void OwnStation::tick(base::RunTime now) {
  commander_.tick(now);
  if (log_taking_) log_taking_->logs.tick(now);
}

void OwnStation::wall_tick(base::RunTime wall) {
  commander_.wall_tick(wall);
  tick_failures(wall);
}

base::RunTime OwnStation::next_tick(base::RunTime now) const {
  const base::RunTime due = std::min(commander_.next_tick(now), failures_.due());
  return log_taking_ ? std::min(due, now + kStationTick) : due;
}

}  // namespace cas::casd
