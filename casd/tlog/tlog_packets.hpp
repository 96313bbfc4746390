// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <utility>

#include "casd/tlog/tlog_files.hpp"
#include "mavlink_gen/runtime/message_table.hpp"

namespace cas::casd {

/// Hands each intact packet of a telemetry log to `use(unix_us, packet)`; a damaged record costs no
/// other one. @return false when the log cannot be read
template <class Use>
bool for_each_tlog_packet(const std::filesystem::path& file, const mav::MessageTable& table,
                          Use&& use) {
  TlogReader log;
  if (!log.open(file)) return false;
  mav::services::for_each_tlog_packet([&log] { return log.next(); }, table, std::forward<Use>(use));
  return true;
}

}  // namespace cas::casd
