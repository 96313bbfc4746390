// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

#include "hils/boards/board_list.hpp"
#include "hils/measure/judgement.hpp"

namespace cas::hils {

/// State of a board as seen through casd.
struct BoardFacts {
  std::filesystem::path device{};  ///< empty: the board is not there
  bool link_up = false;
  std::string link_words{};  ///< why the port cannot be opened
  bool heard = false;        ///< a HEARTBEAT has come, not long ago
  bool armed = false;
  bool hil = false;
  std::string autopilot{};  ///< "PX4"
  std::string firmware{};   ///< "1.15.0", by AUTOPILOT_VERSION; empty: it has not come
  std::string commit{};     ///< of the firmware, in hexadecimal; empty: it does not say
};

/// The commit in AUTOPILOT_VERSION.flight_custom_version: PX4 has its first eight bytes as a
/// little-endian number, ArduPilot its first eight digits as text. Empty: it has none. Pure.
std::string commit_text(const std::array<std::uint8_t, 8>& custom_version,
                        std::string_view autopilot);

/// Whether version `said` is the one that is wanted: "1.15" wants any 1.15.x. Pure.
bool is_version(std::string_view said, std::string_view wanted);

/// Whether commit `said` may be the one that is wanted: they agree as far as both go, for seven
/// digits at least where that many are wanted. A firmware says the beginning alone. Pure.
bool is_commit(std::string_view said, std::string_view wanted);

/// Whether there is nothing more to wait for: it has been heard, and has said its version. Pure.
bool has_booted(const BoardFacts& facts);

/// Verdict on a boot.
struct BootVerdict {
  ExitCode code = kExitPassed;  ///< or kExitBoardAbsent, kExitNoBoot
  std::string sentence;
};

/// Judges a board at the end of the time that it had. Pure.
BootVerdict judge_boot(const BoardFacts& facts, const Board& board);

}  // namespace cas::hils
