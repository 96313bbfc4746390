// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>

#include "casd/tlog/tlog_files.hpp"
#include "mavlink_gen/runtime/packet_parser.hpp"

namespace cas::casd {

/// Hands each intact packet of a telemetry log to `use(unix_us, packet)`; a damaged record costs no
/// other one. @return false when the log cannot be read
template <class Use>
bool for_each_tlog_packet(const std::filesystem::path& file, const mav::MessageTable& table,
                          Use&& use) {
  TlogReader log;
  if (!log.open(file)) return false;
  mav::PacketParser parser(table);
  while (const auto record = log.next()) {
    parser.reset();
    parser.feed(record->packet,
                [&](const mav::PacketView& packet) { use(record->unix_us, packet); });
  }
  return true;
}

}  // namespace cas::casd
