// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/pty_admission.hpp"

#include <sys/sysmacros.h>

#include <fmt/format.h>
#include <sstream>

#include "base/error.hpp"
#include "base/os/pty_lock.hpp"
#include "base/read_file.hpp"
#include "base/text.hpp"

namespace cas::casd {
namespace {

namespace fs = std::filesystem;

/// As /proc writes device numbers: twelve bits of minor number around the major one.
std::uint32_t kernel_number(std::uint64_t device) {
  const std::uint32_t low = minor(device) & 0xFFU;
  const std::uint32_t high = minor(device) & ~0xFFU;
  return low | major(device) << 8U | high << 12U;
}

struct ProcessLine {
  std::string program;
  std::int64_t terminal = 0;
};

/// "PID (PROGRAM) STATE PARENT GROUP SESSION TERMINAL ..."; a program's name may hold anything.
std::optional<ProcessLine> read_process(const fs::path& folder) {
  const std::string text = base::read_file(folder / "stat").value_or("");  // it may have ended
  const std::size_t begin = text.find('(');
  const std::size_t end = text.rfind(')');
  if (begin == text.npos || end == text.npos) return std::nullopt;
  ProcessLine line{.program = text.substr(begin + 1, end - begin - 1)};
  std::istringstream rest(text.substr(end + 1));
  std::string state;
  std::string parent;
  std::string group;
  std::string session;
  if (!(rest >> state >> parent >> group >> session >> line.terminal)) return std::nullopt;
  return line;
}

using base::is_number;

/// Whether processes of all users are to be seen: the first one is root's.
bool shows_everybody(const fs::path& proc) { return read_process(proc / "1").has_value(); }

std::string terminal_name(std::uint64_t device) {
  return fmt::format("pseudo-terminal /dev/pts/{}", minor(device));
}

}  // namespace

std::optional<TerminalUser> find_terminal_user(std::uint64_t device, const fs::path& proc) {
  const std::uint32_t wanted = kernel_number(device);
  std::error_code ended;
  for (fs::directory_iterator at(proc, ended); !ended && at != fs::directory_iterator();
       at.increment(ended)) {
    const std::string name = at->path().filename().string();
    if (!is_number(name)) continue;
    const std::optional<ProcessLine> line = read_process(at->path());
    if (line && static_cast<std::uint32_t>(line->terminal) == wanted)
      return TerminalUser{line->program, std::stoi(name)};
  }
  return std::nullopt;
}

std::optional<std::string> pty_refusal(int slave, const std::string& device, bool unlocked,
                                       const fs::path& proc) {
  const std::optional<base::PtyIdentity> terminal = base::identify_pty(slave);
  CAS_CHECK(terminal.has_value());
  const std::string where = device + ": " + terminal_name(terminal->device);
  const base::PtyOffer offer = base::pty_offer(device, slave);
  if (offer == base::PtyOffer::kThis) return std::nullopt;
  if (offer == base::PtyOffer::kOther) {
    return where + " is not the one that the program behind this path offers now";
  }
  if (!unlocked) {
    return where +
           " is offered by no running program, somebody may work at it: start fcu_emulator with "
           "this path as --link; for a program that holds no lock (socat, PX4) set unlocked_pty: "
           "true";
  }
  if (const auto user = find_terminal_user(terminal->device, proc)) {
    return fmt::format(
        "{} is the terminal of {}, process {}: nothing is written to it; end that "
        "session, or remove the old symlink",
        where, user->program, user->process);
  }
  if (!shows_everybody(proc)) {
    return where +
           " may be somebody's terminal, and /proc hides the processes of other users: let casd "
           "see them (under systemd ProtectProc=default in a drop-in)";
  }
  return std::nullopt;
}

}  // namespace cas::casd
