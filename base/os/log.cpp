// SPDX-License-Identifier: BSD-3-Clause
#include "base/os/log.hpp"

#include <spdlog/logger.h>
#include <spdlog/sinks/stdout_sinks.h>
#include <sys/stat.h>

#include <array>
#include <atomic>
#include <cstdlib>
#include <memory>

#include "base/error.hpp"
#include "base/printable.hpp"

namespace cas::base::log {
namespace {

/// True when standard error is journald's stream: JOURNAL_STREAM names its device and inode.
bool stderr_is_journal() {
  const char* const variable = std::getenv("JOURNAL_STREAM");
  if (variable == nullptr) return false;
  struct stat status {};
  if (::fstat(2, &status) != 0) return false;
  return variable == std::to_string(status.st_dev) + ":" + std::to_string(status.st_ino);
}

struct Sink {
  // Never destroyed: threads and plugins may log while the process ends.
  spdlog::logger logger{program_invocation_short_name,
                        std::make_shared<spdlog::sinks::stderr_sink_mt>()};
  std::atomic<bool> journal{false};

  Sink() { configure(program_invocation_short_name, Level::kInfo); }

  void configure(const std::string& program, Level level);
  void write(spdlog::level::level_enum level, std::string_view line);
};

spdlog::level::level_enum to_spdlog(Level level) {
  switch (level) {
    case Level::kDebug:
      return spdlog::level::debug;
    case Level::kInfo:
      return spdlog::level::info;
    case Level::kWarn:
      return spdlog::level::warn;
    case Level::kError:
      return spdlog::level::err;
    case Level::kOff:
      break;
  }
  return spdlog::level::off;
}

void Sink::configure(const std::string& program, Level level) {
  journal = stderr_is_journal();
  std::string name;
  for (const char c : program) name += c == '%' ? "%%" : std::string(1, c);
  // journald adds time and program itself and reads the priority from the line's start.
  logger.set_pattern(journal ? "%v" : "%Y-%m-%d %H:%M:%S.%e " + name + " %l: %v");
  logger.set_level(to_spdlog(level));
  logger.flush_on(spdlog::level::debug);
}

/// syslog's priority as sd-daemon(3) spells it.
const char* priority_prefix(spdlog::level::level_enum level) {
  switch (level) {
    case spdlog::level::debug:
      return "<7>";
    case spdlog::level::info:
      return "<6>";
    case spdlog::level::warn:
      return "<4>";
    default:
      return "<3>";
  }
}

void Sink::write(spdlog::level::level_enum level, std::string_view line) {
  if (!logger.should_log(level)) return;
  // Text from the wire must not forge lines or move the cursor.
  const std::string text = (journal ? priority_prefix(level) : "") + printable(line);
  logger.log(level, spdlog::string_view_t(text.data(), text.size()));
}

Sink& sink() {
  static Sink* const instance = new Sink;
  return *instance;
}

}  // namespace

void init(const std::string& program, Level level) { sink().configure(program, level); }

Level parse_level(std::string_view word) {
  constexpr std::array<std::pair<std::string_view, Level>, 5> kWords{{{"debug", Level::kDebug},
                                                                      {"info", Level::kInfo},
                                                                      {"warn", Level::kWarn},
                                                                      {"error", Level::kError},
                                                                      {"off", Level::kOff}}};
  for (const auto& [name, level] : kWords) {
    if (word == name) return level;
  }
  throw ConfigError("log level '" + std::string(word) +
                    "' is none of debug, info, warn, error, off");
}

void debug(std::string_view line) { sink().write(spdlog::level::debug, line); }
void info(std::string_view line) { sink().write(spdlog::level::info, line); }
void warn(std::string_view line) { sink().write(spdlog::level::warn, line); }
void error(std::string_view line) { sink().write(spdlog::level::err, line); }

}  // namespace cas::base::log
