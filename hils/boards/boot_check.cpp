// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/boot_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace cas::hils {

namespace {

std::string where(const Board& board) {
  if (board.serial.empty()) return "there is no " + board.device.string();
  return fmt::format("no serial port of a USB device with the serial number {}", board.serial);
}

BootVerdict no_boot(const Board& board, const std::string& what) {
  return {.code = kExitNoBoot, .sentence = fmt::format("board '{}' {}", board.name, what)};
}

}  // namespace

std::string commit_text(const std::array<std::uint8_t, 8>& custom_version,
                        std::string_view autopilot) {
  if (std::ranges::all_of(custom_version, [](std::uint8_t byte) { return byte == 0; })) return {};
  std::string text;
  if (autopilot == "ArduPilot") {
    for (const std::uint8_t byte : custom_version) {
      if (std::isxdigit(byte) != 0) text += static_cast<char>(std::tolower(byte));
    }
    return text;
  }
  for (auto byte = custom_version.rbegin(); byte != custom_version.rend(); ++byte) {
    text += fmt::format("{:02x}", *byte);
  }
  return text;
}

bool is_version(std::string_view said, std::string_view wanted) {
  if (!said.starts_with(wanted)) return false;
  return said.size() == wanted.size() || said[wanted.size()] == '.';
}

bool is_commit(std::string_view said, std::string_view wanted) {
  constexpr std::size_t kTelling = 7;
  const std::size_t common = std::min(said.size(), wanted.size());
  return common >= std::min(kTelling, wanted.size()) &&
         said.substr(0, common) == wanted.substr(0, common);
}

bool has_booted(const BoardFacts& facts) { return facts.heard && !facts.firmware.empty(); }

BootVerdict judge_boot(const BoardFacts& facts, const Board& board) {
  if (facts.device.empty()) {
    return {.code = kExitBoardAbsent,
            .sentence = fmt::format("board '{}' is not there: {}", board.name, where(board))};
  }
  const std::string device = facts.device.string();
  if (!facts.link_up) {
    return {.code = kExitBoardAbsent,
            .sentence = fmt::format("board '{}': {} cannot be opened: {}", board.name, device,
                                    facts.link_words)};
  }
  if (!facts.heard) return no_boot(board, "does not boot: no HEARTBEAT comes from " + device);
  const bool has_to_tell = !board.firmware.empty() || !board.commit.empty();
  if (facts.firmware.empty() && has_to_tell) {
    return no_boot(board, "does not say its version: no AUTOPILOT_VERSION comes from " + device);
  }
  if (!board.firmware.empty() && !is_version(facts.firmware, board.firmware)) {
    return no_boot(board,
                   fmt::format("runs firmware {} instead of {}", facts.firmware, board.firmware));
  }
  if (!board.commit.empty() && !is_commit(facts.commit, board.commit)) {
    return no_boot(board,
                   fmt::format("runs firmware of commit {} instead of {}",
                               facts.commit.empty() ? "unknown" : facts.commit, board.commit));
  }
  return {.sentence =
              fmt::format("board '{}' has booted: {} {}{}, {}, {}", board.name, facts.autopilot,
                          facts.firmware.empty() ? "of an unknown version" : facts.firmware,
                          facts.commit.empty() ? "" : " (" + facts.commit + ")",
                          facts.hil ? "in HIL" : "not in HIL", facts.armed ? "armed" : "disarmed")};
}

}  // namespace cas::hils
