// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_command.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <charconv>
#include <chrono>
#include <exception>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "base/cli/whole_number.hpp"
#include "base/error.hpp"
#include "hils/boards/board_actions.hpp"
#include "hils/boards/board_device.hpp"
#include "hils/boards/board_error.hpp"
#include "hils/boards/board_hook.hpp"
#include "hils/boards/board_list.hpp"
#include "hils/boards/board_lock.hpp"
#include "hils/boards/board_log.hpp"
#include "hils/boards/foreground.hpp"
#include "hils/report/aligned_table.hpp"

namespace cas::hils {

namespace fs = std::filesystem;
using Json = nlohmann::json;

struct BoardCommand::Flags {
  CLI::App* board = nullptr;
  CLI::App* list = nullptr;
  CLI::App* lock = nullptr;
  CLI::App* unlock = nullptr;
  CLI::App* flash = nullptr;
  CLI::App* reboot = nullptr;
  CLI::App* power = nullptr;
  CLI::App* log = nullptr;
  CLI::App* console = nullptr;

  std::string boards;
  std::string name;
  std::string wait;
  bool json = false;
  bool names = false;
  std::string purpose;
  unsigned at_most_s = 4 * 3600;
  std::vector<std::string> command;
  bool force = false;
  std::string file;
  std::string firmware;
  std::string commit;
  bool hard = false;
  std::string power_state;
};

namespace {

constexpr const char* kForever = "forever";
constexpr double kForever_s = 3e9;

BoardList load_list(const std::string& given) {
  const fs::path file = find_board_list(given);
  if (file.empty()) throw base::ConfigError(no_board_list());
  return BoardList::load(file);
}

Json board_json(const Board& board, const std::optional<fs::path>& device, const LockState& lock) {
  Json entry{{"name", board.name},
             {"kind", board.kind},
             {"serial", board.serial},
             {"present", device.has_value()},
             {"device", device ? device->string() : ""},
             {"firmware", board.firmware},
             {"commit", board.commit},
             {"calibration", to_string(board.calibration)},
             {"held", lock.held},
             {"guests", lock.has_guests},
             {"waiting", lock.waiting}};
  if (lock.holder) {
    entry["holder"] = {{"pid", lock.holder->pid},
                       {"user", lock.holder->user},
                       {"since", lock.holder->since},
                       {"for", lock.holder->purpose}};
  }
  return entry;
}

int show_list(const BoardList& list, bool as_json) {
  const fs::path folder = lock_folder(list);
  const auto or_dash = [](const std::string& text) { return text.empty() ? "-" : text; };
  Json all = Json::array();
  std::vector<std::vector<std::string>> rows{
      {"BOARD", "KIND", "DEVICE", "FIRMWARE", "CALIBRATION", "LOCK"}};
  for (const Board& board : list.boards) {
    const auto device = find_device(board, list.by_id);
    const LockState lock = look_at_lock(board, folder);
    all.push_back(board_json(board, device, lock));
    rows.push_back({board.name, or_dash(board.kind), device ? device->string() : "absent",
                    or_dash(board.firmware), std::string(to_string(board.calibration)),
                    to_words(lock)});
  }
  fmt::print("{}", as_json ? all.dump(2) + "\n" : aligned_table(rows, Cells::kLeft));
  return kExitPassed;
}

int show_names(const BoardList& list) {
  for (const Board& board : list.boards) fmt::print("{}\n", board.name);
  return kExitPassed;
}

/// Holds the board while a command runs, or in the background.
int hold(BoardLock lock, const Board& board, const std::vector<std::string>& command,
         base::Duration at_most) {
  if (lock.is_guest()) {
    throw BoardError(kExitBoardBusy, fmt::format("board '{}' is held already by a lock that is "
                                                 "named in CAS_BOARD_HOLDER",
                                                 board.name));
  }
  if (!command.empty()) {
    lock.leave_to_heirs();
    return run_in_foreground({.arguments = command, .kept = lock.descriptor()});
  }
  const pid_t holder = go_to_background();
  if (holder == 0) {
    wait_to_be_ended(at_most);
    return kExitPassed;
  }
  lock.hand_over(holder);
  fmt::print("{}\n", holder_setting());
  return kExitPassed;
}

/// Behind a sentence: the processes that hold the board, as far as they can be seen.
std::string seen_holders(const Board& board, const fs::path& folder) {
  const std::vector<std::string> seen = who_has_locked(board, folder);
  if (seen.empty()) return ": what holds the board is another user's or another container's";
  return fmt::format("; what holds the board is {}", fmt::join(seen, ", "));
}

/// Refuses to end a process that the lock's file names and that does not hold it, as far as can be
/// seen: others may write to the file, and numbers of processes are used again.
void refuse_wrong_process(const Board& board, const fs::path& folder, const LockState& state) {
  if (!state.heirs.empty()) {
    throw BoardError(kExitBoardBusy,
                     fmt::format("board '{}': {}; end that", board.name, to_words(state)));
  }
  const fs::path file = lock_file(folder, board);
  if (!descriptors_of(state.holder->pid, file).empty()) return;
  throw BoardError(
      kExitBoardBusy,
      fmt::format("board '{}': process {} does not have {} open, as far as can be seen{}",
                  board.name, state.holder->pid, file.string(), seen_holders(board, folder)));
}

/// Waits until this lock has ended. @throws BoardError
LockState wait_for_end(const Board& board, const fs::path& folder, const LockHolder& holder) {
  constexpr base::Duration kPatience = std::chrono::seconds(10);
  constexpr int kLookMs = 20;
  const base::RunTime begin = base::steady_now();
  while (true) {
    LockState state = look_at_lock(board, folder);
    if (!state.held || (state.holder && state.holder->token != holder.token)) return state;
    if (!state.holder && state.has_guests) return state;
    if (base::steady_now() - begin > kPatience) {
      throw BoardError(kExitBoardBusy, fmt::format("board '{}': process {} was told to end, and "
                                                   "it or what it started still holds the board",
                                                   board.name, holder.pid));
    }
    ::poll(nullptr, 0, kLookMs);
  }
}

/// Ends who holds the board. @throws BoardError
int release(const Board& board, const fs::path& folder, bool force) {
  LockState state = look_at_lock(board, folder);
  if (state.held) {
    if (!state.holder) {
      throw BoardError(kExitBoardBusy, fmt::format("board '{}' is at work: {}{}", board.name,
                                                   to_words(state), seen_holders(board, folder)));
    }
    if (!force && !state.holder->in_background && state.heirs.empty()) {
      throw BoardError(kExitBoardBusy,
                       fmt::format("board '{}' is at work: {}; --force ends that program",
                                   board.name, to_words(state)));
    }
    const LockHolder holder = *state.holder;
    refuse_wrong_process(board, folder, state);
    if (::kill(holder.pid, SIGTERM) != 0) {
      throw BoardError(kExitBoardBusy, fmt::format("board '{}': process {} is not yours to end: {}",
                                                   board.name, holder.pid, to_words(state)));
    }
    state = wait_for_end(board, folder, holder);
  }
  fmt::print("board '{}' is {}\n", board.name,
             state.has_guests ? "free once the program ends that uses it below the lock" : "free");
  return kExitPassed;
}

/// @throws base::ConfigError where a file is named that is none
fs::path firmware_file(const std::string& given) {
  if (given.empty()) return {};
  std::error_code error;
  if (!fs::is_regular_file(given, error)) throw base::ConfigError(given + ": is no file");
  return fs::absolute(given);
}

/// @param given  file; empty: named after the board @throws BoardError, base::ConfigError
void fetch_log(Supervisor& supervisor, const BoardList& list, const Board& board,
               const std::string& given) {
  if (!board.log) {
    throw base::ConfigError(
        fmt::format("{}: board '{}' has no `log`, which says where its logs are",
                    list.file.string(), board.name));
  }
  const fs::path file = fs::absolute(given.empty() ? board.name + ".ulg" : given);
  const FetchedLog fetched = fetch_newest_log(supervisor, board, list.by_id, file);
  if (!fetched.done) throw BoardError(kExitBoardFailed, fetched.sentence);
  fmt::print("{}\n", fetched.sentence);
}

void power(BoardActions& actions, const std::string& state, bool force) {
  if (state == "on") actions.power_on();
  if (state == "off") actions.power_off();
  if (state == "cycle") actions.power_cycle(force);
}

}  // namespace

std::optional<base::Duration> parse_wait(const std::string& text) {
  if (text.empty()) return std::nullopt;
  if (text == kForever) return base::from_seconds(kForever_s);
  double seconds = 0;
  const char* const end = text.data() + text.size();
  const auto result = std::from_chars(text.data(), end, seconds);
  if (result.ec != std::errc() || result.ptr != end || !(seconds >= 0 && seconds <= kForever_s)) {
    throw base::ConfigError("--wait=" + text + ": is no number of seconds");
  }
  return base::from_seconds(seconds);
}

void add_wait(CLI::App& command, std::string& text) {
  command.add_flag(std::string("--wait{") + kForever + "}", text,
                   "Stand in the queue for a board that somebody else holds; --wait=SECONDS: no "
                   "longer than that");
}

std::optional<std::string> misread_wait(std::span<const std::string_view> words) {
  for (std::size_t i = 0; i + 1 < words.size() && words[i] != "--"; ++i) {
    const std::string_view next = words[i + 1];
    if (words[i] != "--wait" || next.empty()) continue;
    if (next.find_first_not_of("0123456789.") != std::string_view::npos) continue;
    return fmt::format("--wait has its seconds behind a '=': --wait={}", next);
  }
  return std::nullopt;
}

base::cli::WordsByCommand board_words() {
  const base::cli::ArgumentWords names{.command = "hils board list --names"};
  return {{"board lock", names},
          {"board unlock", names},
          {"board flash", names},
          {"board reboot", names},
          {"board console", names},
          {"board log", names},
          {"board power", {.known = {"on", "off", "cycle"}}}};
}

BoardCommand::BoardCommand(CLI::App& app) : flags_(std::make_unique<Flags>()) {
  Flags& flags = *flags_;
  flags.board = app.add_subcommand("board", "Flight controllers of the bench, by name");
  flags.board->require_subcommand(1);
  flags.board->add_option(
      "--boards", flags.boards,
      "The list of boards (CAS_BOARDS, ./boards.yaml, ~/.config/cas/boards.yaml, "
      "/etc/cas/boards.yaml)");
  const auto verb = [&flags](const char* name, const char* description) {
    CLI::App* command = flags.board->add_subcommand(name, description);
    command->fallthrough();  // --boards may stand behind the verb
    return command;
  };
  const auto verb_of_one = [&](const char* name, const char* description) {
    CLI::App* command = verb(name, description);
    command->add_option("NAME", flags.name, "Board")->required();
    return command;
  };
  flags.list = verb("list", "Show the boards, whether they are there, and who holds them");
  flags.list->add_flag("--json", flags.json, "As JSON");
  flags.list->add_flag("--names", flags.names, "The names alone, one a line");

  flags.lock = verb_of_one("lock", "Hold a board while a command runs, or until it is unlocked");
  flags.lock->add_option("COMMAND", flags.command,
                         "Program and arguments, behind --; without it the board is held in the "
                         "background, and the line to put into the environment is printed");
  flags.lock->add_option("--for", flags.purpose, "What for: others are told");
  flags.lock
      ->add_option("--at-most", flags.at_most_s,
                   "Seconds that it is held in the background (14400)")
      ->check(base::cli::whole_number)
      ->check(CLI::Range(1, 7 * 24 * 3600));
  add_wait(*flags.lock, flags.wait);

  flags.unlock = verb_of_one("unlock", "End a lock of `hils board lock`");
  flags.unlock->add_flag("--force", flags.force, "End whatever program holds the board");

  flags.flash = verb_of_one("flash", "Run the hook `flash`, and wait for the firmware to boot");
  flags.flash->add_option("FILE", flags.file, "Firmware, for the hook");
  flags.flash->add_option("--firmware", flags.firmware,
                          "Version that must boot, instead of the list's");
  flags.flash->add_option("--commit", flags.commit,
                          "Commit that must boot (its beginning), instead of the list's");
  add_wait(*flags.flash, flags.wait);

  flags.reboot = verb_of_one("reboot", "Restart a board that is not armed, and wait for it");
  flags.reboot->add_flag("--hard", flags.hard, "By the hook `reset`, not by a command");
  add_wait(*flags.reboot, flags.wait);

  flags.power = verb("power", "Switch a board on, off, or off and on; on waits for it to boot");
  flags.power->add_option("STATE", flags.power_state, "on, off or cycle")
      ->required()
      ->check(CLI::IsMember({"on", "off", "cycle"}));
  flags.power->add_option("NAME", flags.name, "Board")->required();
  flags.power->add_flag("--force", flags.force,
                        "cycle: also a board that is armed, or whose port another program has");
  add_wait(*flags.power, flags.wait);

  flags.log = verb_of_one("log", "Fetch the newest log of a board, as key `log` of its entry says");
  flags.log->add_option("FILE", flags.file, "Where to (NAME.ulg)");
  add_wait(*flags.log, flags.wait);

  flags.console = verb_of_one("console", "Run the hook `console` on this terminal");
  add_wait(*flags.console, flags.wait);
}

BoardCommand::~BoardCommand() = default;

bool BoardCommand::parsed() const { return flags_->board->parsed(); }

int BoardCommand::run() const {
  const Flags& flags = *flags_;
  const BoardList list = load_list(flags.boards);
  if (flags.list->parsed()) {
    return flags.names ? show_names(list) : show_list(list, flags.json);
  }
  Board board = list.board(flags.name);
  if (flags.unlock->parsed()) return release(board, lock_folder(list), flags.force);

  const std::string verb = "hils board " + flags.board->get_subcommands().front()->get_name();
  const std::string command = fmt::format("{}", fmt::join(flags.command, " "));
  const std::string purpose = flags.purpose.empty() ? command : flags.purpose;
  const bool emergency = flags.power->parsed() && flags.power_state == "off";
  if (emergency && !flags.wait.empty()) {
    throw base::ConfigError("power off waits for nobody: it takes no --wait");
  }
  fs::path folder;  // none where the emergency stop has to do without
  std::optional<BoardLock> lock;
  try {
    folder = lock_folder(list);
    lock.emplace(board, folder, purpose.empty() ? verb : verb + ": " + purpose,
                 parse_wait(flags.wait));
  } catch (const std::exception& error) {
    if (!emergency) throw;
    fmt::print(stderr, "hils: {}; its power is cut all the same\n", error.what());
  }
  if (flags.lock->parsed()) {
    return hold(std::move(*lock), board, flags.command, std::chrono::seconds(flags.at_most_s));
  }
  if (flags.console->parsed()) {
    const auto device = find_device(board, list.by_id).value_or(fs::path());
    const HookCommand hook = hook_command(board, HookKind::kConsole, list.file.parent_path(),
                                          hook_variables(board, device, {}));
    lock->leave_to_heirs();
    return run_in_foreground({.arguments = hook.arguments,
                              .environment = hook.environment,
                              .folder = list.file.parent_path(),
                              .kept = lock->descriptor()});
  }
  if (!is_hexadecimal(flags.commit)) {
    throw base::ConfigError("--commit " + flags.commit + ": is hexadecimal, in small letters");
  }
  if (!flags.firmware.empty() || !flags.commit.empty()) {
    board.firmware = flags.firmware;
    board.commit = flags.commit;
  }
  Supervisor supervisor;
  BoardActions actions(supervisor, list, board, folder);
  if (flags.flash->parsed()) {
    actions.flash(firmware_file(flags.file));
  } else if (flags.log->parsed()) {
    fetch_log(supervisor, list, board, flags.file);
  } else if (flags.reboot->parsed()) {
    actions.reboot(flags.hard);
  } else {
    power(actions, flags.power_state, flags.force);
  }
  return kExitPassed;
}

}  // namespace cas::hils
