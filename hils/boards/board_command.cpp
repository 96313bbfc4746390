// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_command.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <exception>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "base/cli/whole_number.hpp"
#include "base/error.hpp"
#include "hils/boards/board_actions.hpp"
#include "hils/boards/board_device.hpp"
#include "hils/boards/board_error.hpp"
#include "hils/boards/board_flags.hpp"
#include "hils/boards/board_hook.hpp"
#include "hils/boards/board_list.hpp"
#include "hils/boards/board_lock.hpp"
#include "hils/boards/board_log.hpp"
#include "hils/boards/board_setup.hpp"
#include "hils/boards/board_unlock.hpp"
#include "hils/boards/foreground.hpp"
#include "hils/report/document.hpp"

namespace cas::hils {

namespace fs = std::filesystem;
using Json = nlohmann::json;

namespace {

using base::cli::Verb;

struct Flags {
  std::string name;
  BoardFlags boards;
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
  bool ardupilot_hil = false;
  BoardSetup setup;
};

BoardList load_list(const Flags& flags) {
  const fs::path file = flags.boards.file();
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
  Rows rows{{"BOARD", "KIND", "DEVICE", "FIRMWARE", "CALIBRATION", "LOCK"}};
  for (const Board& board : list.boards) {
    const auto device = find_device(board, list.by_id);
    const LockState lock = look_at_lock(board, folder);
    all.push_back(board_json(board, device, lock));
    rows.push_back({board.name, or_dash(board.kind), device ? device->string() : "absent",
                    or_dash(board.firmware), std::string(to_string(board.calibration)),
                    to_words(lock)});
  }
  fmt::print("{}", as_json ? all.dump(2) + "\n" : aligned_table(rows, Align::kLeft));
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

/// @throws base::ConfigError where a file is named that is none
fs::path firmware_file(const std::string& given) {
  if (given.empty()) return {};
  std::error_code error;
  if (!fs::is_regular_file(given, error)) throw base::ConfigError(given + ": is no file");
  return fs::absolute(given);
}

/// @param given  file; empty: named after the board @throws BoardError, base::ConfigError
void fetch_log(const Board& board, const BoardList& list, const std::string& given) {
  if (!board.log) {
    throw base::ConfigError(
        fmt::format("{}: board '{}' has no `log`, which says where its logs are",
                    list.file.string(), board.name));
  }
  const fs::path file = fs::absolute(given.empty() ? board.name + ".ulg" : given);
  Supervisor supervisor;
  const FetchedLog fetched = fetch_newest_log(supervisor, board, list.by_id, file);
  if (!fetched.done) throw BoardError(kExitBoardFailed, fetched.sentence);
  fmt::print("{}\n", fetched.sentence);
}

/// A board that a verb holds.
struct HeldBoard {
  const BoardList& list;
  Board board;
  fs::path locks;  ///< none where an emergency stop has to do without
  std::optional<BoardLock> lock{};
};

/// Holds the board of the command line. @param verb  "flash" @param emergency  without a lock where
/// there is none to be had @throws BoardError, base::ConfigError
HeldBoard take(const BoardList& list, const Flags& flags, const std::string& verb,
               bool emergency = false) {
  HeldBoard held{.list = list, .board = list.board(flags.name), .locks = {}};
  const std::string command = fmt::format("{}", fmt::join(flags.command, " "));
  const std::string& purpose = flags.purpose.empty() ? command : flags.purpose;
  try {
    held.locks = lock_folder(list);
    held.lock.emplace(held.board, held.locks,
                      "hils board " + verb + (purpose.empty() ? "" : ": " + purpose),
                      flags.boards.patience());
  } catch (const std::exception& error) {
    if (!emergency) throw;
    fmt::print(stderr, "hils: {}; its power is cut all the same\n", error.what());
  }
  return held;
}

int open_console(HeldBoard held) {
  const fs::path folder = held.list.file.parent_path();
  const auto device = find_device(held.board, held.list.by_id).value_or(fs::path());
  const HookCommand hook =
      hook_command(held.board, HookKind::kConsole, folder, hook_variables(held.board, device, {}));
  held.lock->leave_to_heirs();
  return run_in_foreground({.arguments = hook.arguments,
                            .environment = hook.environment,
                            .folder = folder,
                            .kept = held.lock->descriptor()});
}

/// @throws base::ConfigError where --commit is none
void expect_given_firmware(const Flags& flags, Board& board) {
  if (!is_hexadecimal(flags.commit)) {
    throw base::ConfigError("--commit " + flags.commit + ": is hexadecimal, in small letters");
  }
  if (flags.firmware.empty() && flags.commit.empty()) return;
  board.firmware = flags.firmware;
  board.commit = flags.commit;
}

int switch_power(const BoardList& list, const Flags& flags) {
  const bool off = flags.power_state == "off";
  if (off && !flags.boards.wait.empty()) {
    throw base::ConfigError("power off does not wait for a held board: it takes no --wait");
  }
  const HeldBoard held = take(list, flags, "power", off);
  Supervisor supervisor;
  BoardActions actions(supervisor, list, held.board, held.locks);
  if (off) {
    actions.power_off();
  } else if (flags.power_state == "on") {
    actions.power_on();
  } else {
    actions.power_cycle(flags.force);
  }
  return kExitPassed;
}

int flash(HeldBoard held, const Flags& flags) {
  expect_given_firmware(flags, held.board);
  Supervisor supervisor;
  BoardActions(supervisor, held.list, held.board, held.locks).flash(firmware_file(flags.file));
  return kExitPassed;
}

int reboot(const HeldBoard& held, bool hard) {
  Supervisor supervisor;
  BoardActions(supervisor, held.list, held.board, held.locks).reboot(hard);
  return kExitPassed;
}

int set_up(const HeldBoard& held, const Flags& flags) {
  BoardSetup setup = flags.setup;
  if (setup.restore.empty() && setup.port < 0) {
    throw base::ConfigError(
        "setup: --ardupilot-hil needs --serial N, the board's port with the sensors' line (TELEM2 "
        "is SERIAL2 on most)");
  }
  if (setup.saved.empty()) setup.saved = held.board.name + "_before.params";
  setup.saved = fs::absolute(setup.saved);
  Supervisor supervisor;
  set_up_board(supervisor, held.board, held.list.by_id, setup);
  return kExitPassed;
}

void add_setup_options(CLI::App& verb, Flags& flags) {
  CLI::Option_group* const which = verb.add_option_group("what");
  which->add_flag("--ardupilot-hil", flags.ardupilot_hil,
                  "ArduPilot: all sensors by External AHRS (docs/use/firmware/ardupilot_hil.md)");
  which->add_option("--restore", flags.setup.restore, "Give back the parameters of this file");
  which->require_option(1);
  verb.add_option("--serial", flags.setup.port, "Serial port of the board with the sensors' line")
      ->check(CLI::Range(0, 9));
  verb.add_option("--save", flags.setup.saved, "File for the old values (NAME_before.params)");
  verb.add_flag("--yes", flags.setup.writes, "Set them; without it they are only shown");
}

void add_lock_options(CLI::App& lock, Flags& flags) {
  lock.add_option("COMMAND", flags.command,
                  "Program and arguments, behind --; without it the board is held in the "
                  "background, and the line to put into the environment is printed");
  lock.add_option("--for", flags.purpose, "What for: others are told");
  lock.add_option("--at-most", flags.at_most_s, "Seconds that it is held in the background (14400)")
      ->check(base::cli::whole_number)
      ->check(CLI::Range(1, 7 * 24 * 3600));
}

void add_flash_options(CLI::App& flash, Flags& flags) {
  flash.add_option("FILE", flags.file, "Firmware, for the hook");
  flash.add_option("--firmware", flags.firmware, "Version that must boot, instead of the list's");
  flash.add_option("--commit", flags.commit,
                   "Commit that must boot (its beginning), instead of the list's");
}

void add_power_options(CLI::App& power, Flags& flags) {
  power.add_option("STATE", flags.power_state, "on, off or cycle")
      ->required()
      ->check(CLI::IsMember({"on", "off", "cycle"}));
  power.add_option("NAME", flags.name, "Board")->required();
  power.add_flag("--force", flags.force,
                 "cycle: also a board that is armed, or whose port another program has");
}

/// The verbs of `board`, as they are added.
class BoardVerbs {
 public:
  using Run = int (*)(const BoardList& list, const Flags& flags);

  BoardVerbs(CLI::App& above, std::shared_ptr<Flags> kept)
      : above_(above), kept_(std::move(kept)) {}

  CLI::App* add(const char* name, const char* description, Run run) {
    CLI::App* verb = above_.add_subcommand(name, description);
    verb->fallthrough();  // --boards may follow the verb
    verbs_.push_back({verb, [kept = kept_, run] { return run(load_list(*kept), *kept); }});
    return verb;
  }
  /// A verb with the name of a board.
  CLI::App* add_of_one(const char* name, const char* description, Run run) {
    CLI::App* verb = add(name, description, run);
    verb->add_option("NAME", flags().name, "Board")->required();
    return verb;
  }
  Flags& flags() { return *kept_; }
  const std::vector<Verb>& all() const { return verbs_; }

 private:
  CLI::App& above_;
  std::shared_ptr<Flags> kept_;
  std::vector<Verb> verbs_;
};

void add_list(BoardVerbs& verbs) {
  CLI::App* list = verbs.add("list", "Show the boards, whether they are there, and who holds them",
                             [](const BoardList& boards, const Flags& f) {
                               return f.names ? show_names(boards) : show_list(boards, f.json);
                             });
  list->add_flag("--json", verbs.flags().json, "As JSON");
  list->add_flag("--names", verbs.flags().names, "The names alone, one a line");
}

void add_locks(BoardVerbs& verbs) {
  CLI::App* lock =
      verbs.add_of_one("lock", "Hold a board while a command runs, or until it is unlocked",
                       [](const BoardList& boards, const Flags& f) {
                         HeldBoard held = take(boards, f, "lock");
                         return hold(std::move(*held.lock), held.board, f.command,
                                     std::chrono::seconds(f.at_most_s));
                       });
  add_lock_options(*lock, verbs.flags());
  add_wait(*lock, verbs.flags().boards.wait);
  verbs
      .add_of_one("unlock", "End a lock of `hils board lock`",
                  [](const BoardList& boards, const Flags& f) {
                    unlock_board(boards.board(f.name), lock_folder(boards), f.force);
                    return static_cast<int>(kExitPassed);
                  })
      ->add_flag("--force", verbs.flags().force, "End whatever program holds the board");
}

void add_restarts(BoardVerbs& verbs) {
  Flags& flags = verbs.flags();
  CLI::App* flash_verb = verbs.add_of_one(
      "flash", "Run the hook `flash`, and wait for the firmware to boot",
      [](const BoardList& boards, const Flags& f) { return flash(take(boards, f, "flash"), f); });
  add_flash_options(*flash_verb, flags);
  add_wait(*flash_verb, flags.boards.wait);

  CLI::App* reboot_verb =
      verbs.add_of_one("reboot", "Restart a board that is not armed, and wait for it",
                       [](const BoardList& boards, const Flags& f) {
                         return reboot(take(boards, f, "reboot"), f.hard);
                       });
  reboot_verb->add_flag("--hard", flags.hard, "By the hook `reset`, not by a command");
  add_wait(*reboot_verb, flags.boards.wait);

  CLI::App* power = verbs.add(
      "power", "Switch a board on, off, or off and on; on waits for it to boot", switch_power);
  add_power_options(*power, flags);
  add_wait(*power, flags.boards.wait);
}

void add_log_and_console(BoardVerbs& verbs) {
  CLI::App* log =
      verbs.add_of_one("log", "Fetch the newest log of a board, as key `log` of its entry says",
                       [](const BoardList& boards, const Flags& f) {
                         const HeldBoard held = take(boards, f, "log");
                         fetch_log(held.board, boards, f.file);
                         return static_cast<int>(kExitPassed);
                       });
  log->add_option("FILE", verbs.flags().file, "Where to (NAME.ulg)");
  add_wait(*log, verbs.flags().boards.wait);

  CLI::App* setup = verbs.add_of_one(
      "setup", "Show which parameters a board needs to fly in the loop, and set them",
      [](const BoardList& boards, const Flags& f) { return set_up(take(boards, f, "setup"), f); });
  add_setup_options(*setup, verbs.flags());
  add_wait(*setup, verbs.flags().boards.wait);

  CLI::App* console = verbs.add_of_one("console", "Run the hook `console` on this terminal",
                                       [](const BoardList& boards, const Flags& f) {
                                         return open_console(take(boards, f, "console"));
                                       });
  add_wait(*console, verbs.flags().boards.wait);
}

}  // namespace

base::cli::WordsByCommand board_words() {
  const base::cli::ArgumentWords names{.command = "hils board list --names"};
  return {{"board lock", names},    {"board unlock", names},
          {"board flash", names},   {"board reboot", names},
          {"board console", names}, {"board log", names},
          {"board setup", names},   {"board power", {.known = {"on", "off", "cycle"}}}};
}

Verb add_board(CLI::App& app) {
  const auto kept = std::make_shared<Flags>();
  CLI::App* board = app.add_subcommand("board", "Flight controllers of the bench, by name");
  board->require_subcommand(1);
  add_board_list(*board, kept->boards.list);
  BoardVerbs verbs(*board, kept);
  add_list(verbs);
  add_locks(verbs);
  add_restarts(verbs);
  add_log_and_console(verbs);
  return {board, [verbs = verbs.all()] { return base::cli::find_asked(verbs)->run(); }};
}

}  // namespace cas::hils
