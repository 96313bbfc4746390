// SPDX-License-Identifier: BSD-3-Clause
#include "casd/autopilot_log/log_pull.hpp"

#include <algorithm>

namespace cas::casd {

void LogPull::on_packet(const mav::PacketView& packet, base::RunTime now) {
  now_ = now;
  if (wanted_) take(packet);
}

void LogPull::tick(base::RunTime now) {
  now_ = now;
  wanted_ = true;
  ask();
}

void LogPull::stop(base::RunTime now) {
  ask_to_end();
  restart(now);
  wanted_ = false;
}

void LogPull::restart(base::RunTime now) {
  now_ = now;
  next_ask_ = now;
  hooks_.end();
  forget();
}

bool LogPull::begin_file(std::string_view extension) {
  if (now_ < next_file_) return false;
  next_file_ = now_ + kFilePeriod;
  hooks_.end();
  hooks_.begin(extension);
  return true;
}

void LogPull::hear() {
  await_data();
  retry_ = kFirstRetry;
}

void LogPull::ask_later(base::Duration at_least, base::Duration longest) {
  next_ask_ = now_ + std::max(at_least, retry_);
  retry_ = std::min(2 * retry_, longest);
}

void LogPull::write(LogPart part) {
  if (part.bytes.empty() || hooks_.write(std::move(part))) return;
  stop(now_);
  next_ask_ = now_ + kSilence;
}

}  // namespace cas::casd
