// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "hils/boards/board_list.hpp"
#include "hils/programs/supervisor.hpp"
#include "mavlink_gen/services/ftp_payload.hpp"

namespace cas::hils {

/// The folders and logs (.ulg) of a folder of logs, the newest first, by their names: a date or a
/// time goes before "sess012" and "log003.ulg", which a board without a clock writes. Hidden ones
/// are left out. Pure.
std::vector<mav::services::FtpEntry> newest_first(std::vector<mav::services::FtpEntry> entries);

/// Result of fetching a log.
struct FetchedLog {
  bool done = false;
  std::string sentence;  ///< the fetched log, or the error
};

/// Fetches a board's newest log by MAVLink FTP into `file`, within the size and the time that its
/// `log` allows; a board has one. @throws RunStopped
FetchedLog fetch_newest_log(Supervisor& supervisor, const Board& board,
                            const std::filesystem::path& by_id, const std::filesystem::path& file);

}  // namespace cas::hils
