// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_setup.hpp"

#include <fmt/format.h>

#include <chrono>
#include <sstream>

#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "base/read_file.hpp"
#include "base/time/clock.hpp"
#include "hils/boards/board_device.hpp"
#include "hils/boards/board_error.hpp"
#include "hils/boards/board_session.hpp"
#include "hils/report/document.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

constexpr base::Duration kSetupPatience = std::chrono::seconds(10);
constexpr base::Duration kSetupLook = std::chrono::milliseconds(200);

/// @throws BoardError, RunStopped
BoardFacts wait_until_heard(Supervisor& supervisor, BoardSession& session, const Board& board) {
  const base::RunTime deadline = base::steady_now() + kSetupPatience;
  for (BoardFacts facts = session.look();; facts = session.look()) {
    if (facts.heard) return facts;
    if (base::steady_now() > deadline)
      throw BoardError(kExitNoBoot, judge_boot(facts, board).sentence);
    supervisor.wait(kSetupLook);
  }
}

std::string table_of(const std::vector<ParamChange>& changes) {
  Rows rows{{"PARAMETER", "OLD", "NEW", ""}};
  for (const ParamChange& change : changes) {
    rows.push_back({change.name, fmt::format("{:g}", change.before),
                    fmt::format("{:g}", change.after), change.meaning});
  }
  return aligned_table(rows, Align::kLeft);
}

/// ArduPilot shows the parameters of External AHRS once it is on.
bool is_hidden(const std::string& name, const casd::ParamValues& now) {
  return name.starts_with("EAHRS_") && now.at("EAHRS_TYPE") == 0;
}

/// A file that is there holds older values, which would be lost. @throws base::ConfigError
void save(const std::vector<ParamChange>& changes, const fs::path& file) {
  if (fs::exists(file)) {
    throw base::ConfigError(file.string() +
                            ": is there already, with parameters from before; give them back by "
                            "--restore, or name another by --save");
  }
  std::string text;
  for (const ParamChange& change : changes) {
    text += fmt::format("{} {:.9g}\n", change.name, change.before);
  }
  base::write_result({file.parent_path(), file.filename()}, text);
}

}  // namespace

std::vector<ParamChange> external_ahrs_changes(const casd::ParamValues& now, int port) {
  if (!now.contains("EAHRS_TYPE")) {
    throw base::ConfigError(
        "the board has no parameter EAHRS_TYPE: it is no ArduPilot, or its firmware is without "
        "External AHRS (4.7: the custom build server has it)");
  }
  std::vector<ParamChange> changes;
  for (const casd::ExternalAhrsParam& param : casd::external_ahrs_lacks(now, port)) {
    const auto found = now.find(param.name);
    if (found == now.end() && is_hidden(param.name, now)) continue;
    if (found == now.end()) {
      throw base::ConfigError(fmt::format("the board has no parameter {}", param.name));
    }
    changes.push_back({param.name, found->second, param.value, param.meaning});
  }
  return changes;
}

std::vector<ParamChange> restoring_changes(std::string_view text, const std::string& file,
                                           const casd::ParamValues& now) {
  std::vector<ParamChange> changes;
  std::istringstream lines{std::string(text)};
  std::string line;
  for (int number = 1; std::getline(lines, line); ++number) {
    std::istringstream words(line);
    std::string name, rest;
    double value = 0;
    if (!(words >> name >> value) || words >> rest) {
      throw base::ConfigError(fmt::format("{}:{}: is not NAME VALUE", file, number));
    }
    const auto found = now.find(name);
    if (found == now.end()) {
      throw base::ConfigError(
          fmt::format("{}:{}: the board has no parameter {}", file, number, name));
    }
    if (found->second != value) changes.push_back({name, found->second, value});
  }
  return changes;
}

void set_up_board(Supervisor& supervisor, const Board& board, const fs::path& by_id,
                  const BoardSetup& setup) {
  const auto device = find_device(board, by_id);
  if (!device) throw BoardError(kExitBoardAbsent, judge_boot({}, board).sentence);
  BoardSession session(supervisor, board, *device);
  if (wait_until_heard(supervisor, session, board).armed) {
    throw BoardError(kExitBoardFailed,
                     fmt::format("board '{}' is armed: nothing is set", board.name));
  }
  const bool restores = !setup.restore.empty();
  const casd::ParamValues now = session.params();
  std::vector<ParamChange> changes;
  if (restores) {
    const auto text = base::read_file(setup.restore);
    if (!text) throw base::ConfigError(setup.restore.string() + ": cannot be read");
    changes = restoring_changes(*text, setup.restore.string(), now);
  } else {
    changes = external_ahrs_changes(now, setup.port);
  }
  if (changes.empty()) {
    fmt::print("board '{}': all parameters are so already\n", board.name);
    return;
  }
  fmt::print("{}", table_of(changes));
  if (!setup.writes) {
    fmt::print("board '{}': nothing was set; --yes sets these\n", board.name);
    return;
  }
  if (!restores) {
    save(changes, setup.saved);
    fmt::print("board '{}': the old values are in {}\n", board.name, setup.saved.string());
  }
  for (const ParamChange& change : changes) session.set_param(change.name, change.after);
  std::size_t set = changes.size();
  if (!restores) {
    for (const ParamChange& shown : external_ahrs_changes(session.params(), setup.port)) {
      session.set_param(shown.name, shown.after);
      ++set;
    }
  }
  fmt::print("board '{}': {} parameters set; they hold after `hils board reboot {}`\n", board.name,
             set, board.name);
}

}  // namespace cas::hils
