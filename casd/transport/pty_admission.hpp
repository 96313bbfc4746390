// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

namespace cas::casd {

/// A process whose terminal it is.
struct TerminalUser {
  std::string program;
  int process = 0;
};

/// The first process found whose controlling terminal has this device number (st_rdev). Nothing
/// when none has, or none that `proc` shows: that of other users may be hidden (hidepid,
/// ProtectProc).
std::optional<TerminalUser> find_terminal_user(std::uint64_t device,
                                               const std::filesystem::path& proc = "/proc");

/// Why nothing may be written to the open pseudo-terminal `slave`, nor its settings be changed;
/// nothing when it may. It may if a program that runs offers it under `device` (base::PtyLock), or
/// with `unlocked` if nobody works at it.
std::optional<std::string> pty_refusal(int slave, const std::string& device, bool unlocked,
                                       const std::filesystem::path& proc = "/proc");

}  // namespace cas::casd
