// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "hils/boards/board_list.hpp"
#include "hils/programs/supervisor.hpp"

namespace cas::hils {

/// Names and values.
using HookVariables = std::vector<std::pair<std::string, std::string>>;

/// Variables of a hook: CAS_BOARD, CAS_BOARD_SERIAL, CAS_BOARD_DEVICE (empty while the board is not
/// there), CAS_BOARD_BAUD, CAS_BOARD_KIND, CAS_BOARD_FIRMWARE, CAS_BOARD_FILE. Pure.
/// @param file  of `hils board flash`; else empty
HookVariables hook_variables(const Board& board, const std::filesystem::path& device,
                             const std::filesystem::path& file);

/// `command` with the value of a variable for each ${NAME}. Pure. @throws base::ConfigError for a
/// name that is none of `variables`, and for one without a value
std::vector<std::string> fill_in(const std::vector<std::string>& command,
                                 const HookVariables& variables);

/// A hook's command as it is started.
struct HookCommand {
  std::string name;  ///< for messages: "hook flash of board 'bench1'"
  std::vector<std::string> arguments;
  std::vector<std::string> environment;  ///< "NAME=VALUE"
  base::Duration timeout{};
};

/// @param folder  of boards.yaml: a program with a slash in its name counts from there, another one
/// is looked for in PATH
/// @throws base::ConfigError
HookCommand hook_command(const Board& board, HookKind kind, const std::filesystem::path& folder,
                         const HookVariables& variables);

/// Runs a hook in the folder of boards.yaml; its output goes to a file. After its time-out it is
/// ended with its whole process group.
/// @throws BoardError (kExitBoardFailed), RunStopped when interrupted
void run_hook(Supervisor& supervisor, const HookCommand& command,
              const std::filesystem::path& folder, const std::filesystem::path& log_file);

}  // namespace cas::hils
