// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <utility>

#include "casd/tlog/tlog_files.hpp"
#include "mavlink_gen/runtime/message_table.hpp"

namespace cas::casd {

/// What a log lost.
struct TlogLoss {
  std::uint64_t skipped_bytes = 0;    ///< that are no record
  std::uint64_t wrong_checksums = 0;  ///< records
};

/// Hands each intact packet of a telemetry log to `use(unix_us, packet)`; a damaged record costs no
/// other one. @param loss  bytes and records that were left out
/// @return false if the log cannot be opened, or not read to its end
template <class Use>
bool for_each_tlog_packet(const std::filesystem::path& file, const mav::MessageTable& table,
                          Use&& use, TlogLoss* loss = nullptr) {
  TlogReader log;
  if (!log.open(file)) return false;
  // A message that the table lacks may hold what looks like the start of one that it has.
  const auto next_known = [&log, &table] {
    auto record = log.next();
    while (record && table.find(mav::view_packet(record->packet).message_id) == nullptr) {
      record = log.next();
    }
    return record;
  };
  const auto stats = mav::services::for_each_tlog_packet(next_known, table, std::forward<Use>(use));
  if (loss != nullptr) *loss = {log.skipped_bytes(), stats.crc_errors};
  return !log.failed();
}

}  // namespace cas::casd
