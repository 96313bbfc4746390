// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <string_view>

#include "base/export.hpp"

/// One logger for the whole process, plugins included. `info` for changes of state, `warn` for
/// degraded, `error` for lost function; never per packet or step.
namespace cas::base::log {

/// The least level that is written; kOff writes nothing.
enum class Level { kDebug, kInfo, kWarn, kError, kOff };

/// Sets the program's name and level; lines go to standard error (journald priorities under
/// systemd).
CAS_BASE_EXPORT void init(const std::string& program, Level level = Level::kInfo);
/// "debug", "info", "warn", "error", "off". @throws ConfigError for another word
CAS_BASE_EXPORT Level parse_level(std::string_view word);

/// Each writes one line, from any thread.
CAS_BASE_EXPORT void debug(std::string_view line);
CAS_BASE_EXPORT void info(std::string_view line);
CAS_BASE_EXPORT void warn(std::string_view line);
CAS_BASE_EXPORT void error(std::string_view line);

}  // namespace cas::base::log
