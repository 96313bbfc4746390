// SPDX-License-Identifier: BSD-3-Clause
#include "tests/loopback/board_shelf.hpp"

#include <signal.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <system_error>

#include "base/rpc/client.hpp"
#include "tests/support/paths.hpp"

namespace cas::test {
namespace {

namespace fs = std::filesystem;

/// Longest for a program that waits for boots and restarts.
constexpr base::Duration kProgramPatience = std::chrono::seconds(90);

const char* const kPowerOn = R"SH(#!/bin/sh
# Plugs the stand-in in.
cd "$SHELF"
defect=$(cat "$CAS_BOARD.defect" 2>/dev/null)
[ "$defect" = stuck ] && exit 0
./power_off
[ "$defect" = absent ] && exit 0
delay=0
[ "$defect" = slow ] && delay=2
link=by-id/usb-CAS_Stand-in_$CAS_BOARD_SERIAL-if00
unset NOTIFY_SOCKET
setsid sh -c "sleep $delay; exec '$EMULATOR' '$CAS_BOARD.yaml' --link '$link' --control '$CAS_BOARD.sock' --files logs" \
  >>"$CAS_BOARD.log" 2>&1 </dev/null &
echo $! >"$CAS_BOARD.pid"
[ "$defect" = silent ] || exit 0
while [ ! -e "$link" ]; do sleep 0.02; done
kill -STOP $!
# What it said before it stopped waits in the line.
timeout 0.5 cat "$link" >/dev/null
exit 0
)SH";

const char* const kPowerOff = R"SH(#!/bin/sh
# Draws the plug: nothing is left but what udev takes away.
cd "$SHELF"
[ "$(cat "$CAS_BOARD.defect" 2>/dev/null)" = stuck ] && exit 0
if pid=$(cat "$CAS_BOARD.pid" 2>/dev/null); then
  kill -KILL "$pid" 2>/dev/null
  # Until it is gone, its control socket is taken.
  while [ -e "/proc/$pid/fd/0" ]; do sleep 0.02; done
fi
rm -f "$CAS_BOARD.pid" by-id/usb-CAS_Stand-in_"$CAS_BOARD_SERIAL"-if00*
exit 0
)SH";

const char* const kFlash = R"SH(#!/bin/sh
# Stands for a flash tool.
cd "$SHELF"
case $(cat "$CAS_BOARD.defect" 2>/dev/null) in
hang) echo "erasing"; sleep 1000 ;;
broken) echo "no bootloader answers"; exit 3 ;;
esac
[ -n "$CAS_BOARD_HOLDER" ] || { echo "knows no lock"; exit 4; }
echo "$1" >>"$CAS_BOARD.flashed"
exec ./power_on
)SH";

std::string program(const char* name) { return binary_dir() + "/bin/" + name; }

void make_program(const fs::path& file) {
  fs::permissions(file, fs::perms::owner_all, fs::perm_options::replace);
}

}  // namespace

BoardShelf::BoardShelf(const std::vector<std::string>& boards) {
  std::string list = "schema: 1\nby_id: by-id\nlock_folder: runtime/boards\nboards:\n";
  for (const std::string& board : boards) {
    const std::size_t space = std::min(board.find(' '), board.size());
    const std::string& name = names_.emplace_back(board.substr(0, space));
    const std::string system = std::to_string(names_.size());
    const std::string more = space < board.size() ? "," + board.substr(space) : "";
    list +=
        "  " + name + ": {serial: SN" + system + more +
        ", hooks: {power_on: [./power_on], power_off: [./power_off], reset: [./power_on], "
        "console: [sh, -c, 'echo console of \"$CAS_BOARD_DEVICE\"; [ -e boards.yaml ]; echo $?'], "
        "flash: {command: [./flash, \"${CAS_BOARD_FILE}\"], timeout_s: 5}}}\n";
    folder.write(name + ".yaml", "schema: 1\nvehicle: " + source_dir() +
                                     "/config/vehicles/iris_paper.yaml\nsystem_id: " + system +
                                     "\nsensors: rtk\n");
  }
  folder.write("boards.yaml", list);
  make_program(folder.write("power_on", kPowerOn));
  make_program(folder.write("power_off", kPowerOff));
  make_program(folder.write("flash", kFlash));
  fs::create_directories(folder / "by-id");
  fs::create_directories(folder / "logs");
  fs::create_directories(folder / "runtime");
  fs::permissions(folder / "runtime", fs::perms::owner_all, fs::perm_options::replace);
}

BoardShelf::~BoardShelf() {
  for (const std::string& name : names_) {
    if (const int stand_in = process(name); stand_in > 0) ::kill(stand_in, SIGKILL);
  }
}

std::vector<std::string> BoardShelf::command(const std::vector<std::string>& arguments) const {
  std::vector<std::string> words{"/usr/bin/env",
                                 "CAS_RUNTIME_DIR=" + (folder / "runtime").string(),
                                 "CAS_BOARDS=" + (folder / "boards.yaml").string(),
                                 "SHELF=" + folder.path().string(),
                                 "EMULATOR=" + program("fcu_emulator"),
                                 program("hils")};
  words.insert(words.end(), arguments.begin(), arguments.end());
  return words;
}

std::unique_ptr<ChildProcess> BoardShelf::start(const std::vector<std::string>& arguments,
                                                const std::vector<std::string>& environment) const {
  std::vector<std::string> words = command(arguments);
  words.insert(words.begin() + 1, environment.begin(), environment.end());
  return std::make_unique<ChildProcess>(words);
}

Ended BoardShelf::hils(const std::vector<std::string>& arguments,
                       const std::vector<std::string>& environment) const {
  const auto child = start(arguments, environment);
  const int code = child->wait_exit(kProgramPatience).value_or(-1);
  return {code, child->output()};
}

Ended BoardShelf::board(std::vector<std::string> arguments,
                        const std::vector<std::string>& environment) const {
  arguments.insert(arguments.begin(), "board");
  return hils(arguments, environment);
}

void BoardShelf::set_defect(const std::string& board, const std::string& defect) const {
  folder.write(board + ".defect", defect);
}

void BoardShelf::crash(const std::string& board) const {
  ::kill(process(board), SIGKILL);
  std::error_code ignored;
  fs::remove(link(board), ignored);
}

void BoardShelf::hang(const std::string& board) const { ::kill(process(board), SIGSTOP); }

std::string BoardShelf::status(const std::string& board) const {
  try {
    base::rpc::Client emulator("unix:" + (folder / (board + ".sock")).string());
    return emulator.call("fcu.status", nlohmann::json::object()).dump();
  } catch (const base::rpc::ConnectionError&) {
    return {};
  }
}

bool BoardShelf::unplug(const std::string& board) const {
  base::rpc::Client emulator("unix:" + (folder / (board + ".sock")).string());
  return emulator.call("line.hangup", {{"ms", 3'600'000}}).is_object();
}

fs::path BoardShelf::link(const std::string& board) const {
  const auto place = std::find(names_.begin(), names_.end(), board) - names_.begin();
  return folder / ("by-id/usb-CAS_Stand-in_SN" + std::to_string(place + 1) + "-if00");
}

int BoardShelf::process(const std::string& board) const {
  return std::atoi(said(board + ".pid").c_str());
}

}  // namespace cas::test
