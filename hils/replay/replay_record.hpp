// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>

#include "hils/measure/run_result.hpp"
#include "hils/run/run_request.hpp"

namespace cas::hils {

/// A finished run as the page replays it (docs/use/web.md, "The record"), as JSON text: of each
/// vehicle its shape, truth, estimate, reference, messages, hops, stages, faults and checks, and a
/// list of events. The same run gives the same bytes. @throws base::ConfigError when its files
/// cannot be read
std::string replay_record(const RunRequest& request, const RunResult& run);

/// The record of a flight log alone: no truth, no hops, no verdict. @throws base::ConfigError when
/// it cannot be read, or no autopilot is in it
std::string tlog_record(const std::filesystem::path& tlog);
/// The same of a vehicle's own log, in PX4's ULog format; losses are named in a line on standard
/// error. @throws base::ConfigError
std::string ulog_record(const std::filesystem::path& ulog);
/// The same of an MCAP file, as mcap_contents() has it. @throws base::ConfigError
std::string mcap_record(const std::filesystem::path& mcap);

}  // namespace cas::hils
