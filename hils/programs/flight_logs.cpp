// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/flight_logs.hpp"

#include <fmt/format.h>

#include <fstream>

#include "hils/programs/supervisor.hpp"

namespace cas::hils {

void FlightLogs::set_aside() {
  earlier_.push_back(folder_ / fmt::format("flight_{}.tlog", earlier_.size() + 1));
  std::filesystem::rename(log_, earlier_.back());
}

void FlightLogs::join() {
  if (earlier_.empty()) return;
  const std::filesystem::path last = folder_ / "flight_last.tlog";
  std::filesystem::rename(log_, last);
  earlier_.push_back(last);
  std::ofstream whole(log_, std::ios::binary);
  for (const std::filesystem::path& part : earlier_) {
    if (std::filesystem::is_empty(part)) continue;  // << of an empty buffer sets failbit
    whole << std::ifstream(part, std::ios::binary).rdbuf();
  }
  if (!whole.flush()) throw RunStopped(log_.string() + " cannot be written", false);
}

}  // namespace cas::hils
