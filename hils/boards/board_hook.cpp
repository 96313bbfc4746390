// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_hook.hpp"

#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <string_view>
#include <system_error>

#include "base/error.hpp"
#include "base/os/trusted_file.hpp"
#include "base/time/clock.hpp"
#include "hils/boards/board_error.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

constexpr base::Duration kHookLook = std::chrono::milliseconds(100);
constexpr base::Duration kLastPatience = std::chrono::seconds(3);  ///< from SIGTERM to SIGKILL
constexpr std::size_t kToldLines = 10;

const std::string& value_of(std::string_view name, const HookVariables& variables) {
  const auto found =
      std::ranges::find(variables, name, &std::pair<std::string, std::string>::first);
  if (found == variables.end()) {
    throw base::ConfigError("a hook knows no variable " + std::string(name));
  }
  if (found->second.empty()) {
    throw base::ConfigError(std::string(name) +
                            " has no value here, and the hook's command asks for it");
  }
  return found->second;
}

std::string fill_in_word(std::string_view word, const HookVariables& variables) {
  std::string filled;
  while (true) {
    const std::size_t begin = word.find("${");
    const std::size_t end = word.find('}', std::min(begin, word.size()));
    filled += word.substr(0, begin);
    if (begin == std::string_view::npos) return filled;
    if (end == std::string_view::npos) {
      throw base::ConfigError("'" + std::string(word) + "' has no closing brace");
    }
    filled += value_of(word.substr(begin + 2, end - begin - 2), variables);
    word.remove_prefix(end + 1);
  }
}

bool is_program(const fs::path& file) {
  std::error_code error;
  return fs::is_regular_file(file, error) && ::access(file.c_str(), X_OK) == 0;
}

/// @throws base::ConfigError when the program may be another user's work
void refuse_foreign(const fs::path& program) {
  struct stat status {};
  if (::stat(program.c_str(), &status) != 0) return;  // starting it reports the error
  const std::string why = base::why_untrusted(status);
  if (!why.empty()) throw base::ConfigError(program.string() + ": " + why + "; it is not started");
}

fs::path find_program(const std::string& word, const fs::path& folder) {
  if (word.find('/') != std::string::npos) {
    if (is_program(folder / word)) return folder / word;
    throw base::ConfigError((folder / word).string() + " is no program that can be started");
  }
  const char* variable = std::getenv("PATH");
  std::string_view path = variable == nullptr ? "" : variable;
  while (!path.empty()) {
    const std::size_t end = std::min(path.find(':'), path.size());
    const fs::path file = fs::path(path.substr(0, end)) / word;
    if (file.is_absolute() && is_program(file)) return file;
    path.remove_prefix(std::min(end + 1, path.size()));
  }
  throw base::ConfigError("there is no program " + word + " in PATH");
}

}  // namespace

HookVariables hook_variables(const Board& board, const fs::path& device, const fs::path& file) {
  return {{"CAS_BOARD", board.name},
          {"CAS_BOARD_SERIAL", board.serial},
          {"CAS_BOARD_DEVICE", device.string()},
          {"CAS_BOARD_BAUD", std::to_string(board.baud)},
          {"CAS_BOARD_KIND", board.kind},
          {"CAS_BOARD_FIRMWARE", board.firmware},
          {"CAS_BOARD_FILE", file.string()}};
}

std::vector<std::string> fill_in(const std::vector<std::string>& command,
                                 const HookVariables& variables) {
  std::vector<std::string> filled;
  filled.reserve(command.size());
  for (const std::string& word : command) filled.push_back(fill_in_word(word, variables));
  return filled;
}

HookCommand hook_command(const Board& board, HookKind kind, const fs::path& folder,
                         const HookVariables& variables) {
  const auto hook = board.hooks.find(kind);
  if (hook == board.hooks.end()) {
    throw base::ConfigError(
        fmt::format("board '{}' has no hook `{}`", board.name, to_string(kind)));
  }
  HookCommand command{.name = fmt::format("hook {} of board '{}'", to_string(kind), board.name),
                      .arguments = {},
                      .environment = {},
                      .timeout = hook->second.timeout};
  try {
    command.arguments = fill_in(hook->second.command, variables);
    const fs::path program = find_program(command.arguments.front(), folder);
    refuse_foreign(program);
    command.arguments.front() = program.string();
  } catch (const base::ConfigError& error) {
    throw base::ConfigError(command.name + ": " + error.what());
  }
  for (const auto& [name, value] : variables) command.environment.push_back(name + "=" + value);
  return command;
}

void run_hook(Supervisor& supervisor, const HookCommand& command, const fs::path& folder,
              const fs::path& log_file) {
  ChildProcess hook({.name = command.name,
                     .arguments = command.arguments,
                     .log_file = log_file,
                     .cwd = folder,
                     .environment = command.environment});
  while (!hook.poll_exit()) {
    supervisor.check();
    const base::Duration passed = base::steady_now() - hook.begin();
    if (passed >= command.timeout) break;
    hook.wait_exit(std::min(passed + kHookLook, command.timeout));
  }
  const bool ended = hook.poll_exit().has_value();
  if (!ended) {
    hook.terminate();
    hook.wait_exit(base::steady_now() - hook.begin() + kLastPatience);
  }
  if (ended && hook.poll_exit()->code == 0) return;
  throw BoardError(kExitBoardFailed,
                   command.name +
                       (ended ? " " + hook.poll_exit()->words
                              : fmt::format(" was not done within {:g} s and was ended",
                                            base::to_seconds(command.timeout))) +
                       "; its last lines:" + hook.log_tail(kToldLines));
}

}  // namespace cas::hils
