// SPDX-License-Identifier: BSD-3-Clause
#include "casd/tlog/log_room.hpp"

#include <algorithm>
#include <chrono>

namespace cas::casd {
namespace {

constexpr base::Duration kFreePeriod = std::chrono::milliseconds(200);
constexpr base::Duration kUsedPeriod = std::chrono::seconds(1);

}  // namespace

std::optional<std::string> LogRoom::lack(const LogFolder& folder, std::uint64_t more,
                                         const std::string& current, base::RunTime now) {
  const bool counts = limits_.max_bytes > 0U;
  if (!counts && limits_.free_space_min_bytes == 0) return std::nullopt;
  if (!free_read_at_ || now - *free_read_at_ >= kFreePeriod) {
    free_read_at_ = now;
    space_.free_bytes = folder.look(false).free_bytes;
  }
  if (counts && (!used_counted_at_ || now - *used_counted_at_ >= kUsedPeriod)) {
    used_counted_at_ = now;
    space_.used_bytes = folder.look(true).used_bytes;
  }
  const auto why = lack_of_room(limits_, space_, more);
  if (!why || !limits_.delete_oldest || folder.make_room(limits_, more, current).empty()) {
    return why;
  }
  space_ = folder.look(counts);
  return lack_of_room(limits_, space_, more);
}

void LogRoom::wrote(std::uint64_t bytes) {
  space_.used_bytes += bytes;
  space_.free_bytes -= std::min(bytes, space_.free_bytes);
}

void LogRoom::look_again() {
  free_read_at_.reset();
  used_counted_at_.reset();
}

}  // namespace cas::casd
