// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_list.hpp"

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <system_error>

#include "base/config/config_keys.hpp"
#include "base/enum_words.hpp"
#include "base/os/trusted_file.hpp"
#include "base/suggestion.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;
using base::key;
using base::Range;
using base::required;
using base::Text;
using base::Whole;
using base::Words;

constexpr std::size_t kLongestName = 40;  ///< it is a part of file names
constexpr double kLongestHook_s = 3600;
constexpr double kFlashTimeout_s = 180;
constexpr double kHookTimeout_s = 30;

bool is_plain(std::string_view name) {
  return !name.empty() && name.size() <= kLongestName &&
         std::ranges::all_of(name, [](unsigned char c) {
           return std::isalnum(c) != 0 || c == '_' || c == '-' || c == '.';
         });
}

BoardHook parse_hook(HookKind kind, const base::ConfigNode& node) {
  BoardHook hook;
  // A list alone is the command; a map has a time-out of its own.
  const base::ConfigNode command = node.is_map() ? node.at("command") : node;
  if (!command.is_list()) {
    command.fail("is a list, the program first and each argument by itself: no shell reads it");
  }
  hook.command = command.as<std::vector<std::string>>();
  if (hook.command.empty() || hook.command.front().empty()) command.fail("names no program");
  const double fallback = kind == HookKind::kFlash ? kFlashTimeout_s : kHookTimeout_s;
  hook.timeout = base::from_seconds(
      node.is_map() ? node.get_in("timeout_s", fallback, 0.1, kLongestHook_s) : fallback);
  return hook;
}

std::map<HookKind, BoardHook> parse_hooks(const base::ConfigNode& node) {
  std::map<HookKind, BoardHook> hooks;
  for (const HookKind kind : kHookKinds) {
    if (const auto hook = node.find(to_string(kind))) hooks[kind] = parse_hook(kind, *hook);
  }
  return hooks;
}

constexpr Words<Calibration, 3> kCalibrations{{{{"unknown", Calibration::kUnknown},
                                                {"done", Calibration::kDone},
                                                {"missing", Calibration::kMissing}}}};

/// A folder on the board.
struct BoardFolder : Text {
  static void read(const base::ConfigNode& node, std::string& folder) {
    Text::read(node, folder);
    while (folder.ends_with('/')) folder.pop_back();
    if (folder.empty()) node.fail("names a folder below the board's root");
  }
};

constexpr std::tuple kLogKeys{
    required(key<&BoardLog::folder>("folder", BoardFolder{}, "")),
    key<&BoardLog::largest_mib>("largest_mib", Range{0.001, 1024}, ""),
    key<&BoardLog::timeout>("timeout_s", Range{1, 3600}, ""),
};

constexpr std::tuple kBoardKeys{
    key<&Board::serial>("serial", Text{}, ""),
    key<&Board::device>("device", base::PathBeside{}, ""),
    key<&Board::interface>("interface", Whole{0, 255}, ""),
    key<&Board::baud>("baud", Whole{0, 12'000'000}, ""),
    key<&Board::sensors_device>("sensors_device", base::PathBeside{}, ""),
    key<&Board::outputs_disconnected>("outputs_disconnected", base::Flag{}, ""),
    key<&Board::kind>("kind", Text{}, ""),
    key<&Board::firmware>("firmware", Text{}, ""),
    key<&Board::commit>("commit", Text{}, ""),
    key<&Board::calibration>("calibration", kCalibrations, ""),
    key<&Board::boot_timeout>("boot_timeout_s", Range{1, 600}, ""),
    key<&Board::off_time>("off_time_s", Range{0, 60}, ""),
    key<&Board::log>("log", base::block<BoardLog>(kLogKeys), ""),
};

Board parse_board(const std::string& name, const base::ConfigNode& node) {
  Board board{.name = name};
  if (!is_plain(name)) {
    node.fail("a board's name is made of up to 40 letters, digits, and _ - .");
  }
  base::read_keys(node, kBoardKeys, board);
  if (board.serial.empty() == board.device.empty()) {
    node.fail("has a `serial` (its USB serial number) or a `device` (a path), one of them");
  }
  if (!is_hexadecimal(board.commit)) {
    node.at("commit").fail("is hexadecimal, in small letters");
  }
  if (const auto hooks = node.find("hooks")) board.hooks = parse_hooks(*hooks);
  return board;
}

fs::path user_config() {
  const char* folder = std::getenv("XDG_CONFIG_HOME");
  if (folder != nullptr && *folder != 0) return fs::path(folder) / "cas/boards.yaml";
  const char* home = std::getenv("HOME");
  return home == nullptr ? fs::path() : fs::path(home) / ".config/cas/boards.yaml";
}

}  // namespace

std::string_view to_string(HookKind kind) {
  static constexpr base::EnumWords<HookKind::kConsole> kWords{"flash", "power_on", "power_off",
                                                              "reset", "console"};
  return kWords[kind];
}

std::string_view to_string(Calibration state) { return kCalibrations.word(state); }

bool is_hexadecimal(std::string_view commit) {
  return commit.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

BoardList BoardList::load(const fs::path& file) {
  base::require_trusted(fs::absolute(file));  // its hooks are commands
  return parse(base::ConfigNode::load(fs::absolute(file)));
}

BoardList BoardList::parse(const base::ConfigNode& root) {
  constexpr int kSchema = 1;
  if (root.require<int>("schema") != kSchema) root.at("schema").fail("is 1");
  BoardList list;
  list.file = root.file();
  if (const auto folder = root.find("lock_folder")) {
    list.lock_folder = root.resolve(folder->as<std::string>());
  }
  if (const auto folder = root.find("by_id")) list.by_id = root.resolve(folder->as<std::string>());
  const base::ConfigNode boards = root.at("boards");
  for (const auto& [name, node] : boards.entries()) {
    Board board = parse_board(name, node);
    const auto same = std::ranges::find(list.boards, board.identity(), &Board::identity);
    if (same != list.boards.end()) {
      node.fail("is the same board as '" + same->name + "'");
    }
    list.boards.push_back(std::move(board));
  }
  if (list.boards.empty()) boards.fail("names no board");
  root.reject_unused();
  return list;
}

const Board* BoardList::find(std::string_view name) const {
  const auto found = std::ranges::find(boards, name, &Board::name);
  return found == boards.end() ? nullptr : &*found;
}

const Board& BoardList::board(std::string_view name) const {
  if (const Board* found = find(name)) return *found;
  std::vector<std::string> names;
  for (const Board& board : boards) names.push_back(board.name);
  throw base::ConfigError(file.string() + ": there is no board '" + std::string(name) + "'" +
                          base::did_you_mean(name, names));
}

fs::path find_board_list(const fs::path& given) {
  if (!given.empty()) return given;
  const char* named = std::getenv("CAS_BOARDS");
  if (named != nullptr && *named != 0) return named;
  for (const fs::path& file : {user_config(), fs::path("/etc/cas/boards.yaml")}) {
    std::error_code error;
    if (!file.empty() && fs::is_regular_file(file, error)) return file;
  }
  return {};
}

std::string no_board_list() {
  const fs::path user = user_config();
  return "there is no boards.yaml: neither --boards nor CAS_BOARDS names one, and there is no " +
         (user.empty() ? "" : user.string() + " or ") +
         "/etc/cas/boards.yaml (docs/use/ci_with_boards.md)";
}

}  // namespace cas::hils
