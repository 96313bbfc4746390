// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_actions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>

#include "base/time/clock.hpp"
#include "hils/boards/board_device.hpp"
#include "hils/boards/board_error.hpp"
#include "hils/boards/board_hook.hpp"
#include "hils/boards/board_session.hpp"

namespace cas::hils {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

constexpr base::Duration kLook = milliseconds(100);
constexpr base::Duration kAskAgain = seconds(2);
/// A board that runs says HEARTBEAT once a second.
constexpr base::Duration kHeartbeatPatience = seconds(4);
/// A board that has been up for this long says a shorter time after a restart: SYSTEM_TIME comes
/// once a second.
constexpr double kTellingUptime_s = 2;
/// From the acknowledged command to the restart, and to a SYSTEM_TIME that shows it.
constexpr base::Duration kRestartPatience = seconds(15);

}  // namespace

BoardFacts BoardActions::boot(Absence absence) {
  const base::RunTime begin = base::steady_now();
  base::RunTime next_question = begin + kAskAgain;
  std::optional<BoardSession> session;
  BoardFacts facts;
  while (true) {
    const auto device = find_device(board_, list_.by_id);
    if (!device || (session && session->device() != *device)) session.reset();
    if (device && !session) session.emplace(supervisor_, board_, *device);
    facts = session ? session->look() : BoardFacts{};
    const base::RunTime now = base::steady_now();
    if (has_booted(facts) || (!device && absence == Absence::kFails) ||
        now - begin >= board_.boot_timeout) {
      break;
    }
    if (facts.heard && now >= next_question) {
      session->ask_version();
      next_question = base::steady_now() + kAskAgain;
    }
    supervisor_.wait(kLook);
  }
  const BootVerdict verdict = judge_boot(facts, board_);
  if (verdict.code != kExitPassed) throw BoardError(verdict.code, verdict.sentence);
  fmt::print(stderr, "{}\n", verdict.sentence);
  return facts;
}

BoardFacts BoardActions::flash(const std::filesystem::path& file) {
  refuse_armed(first_look());
  hook(HookKind::kFlash, file);
  return boot(Absence::kWaits);
}

BoardFacts BoardActions::reboot(bool hard) {
  const BoardFacts facts = first_look();
  refuse_armed(facts);
  const bool has_reset = board_.hooks.contains(HookKind::kReset);
  if (hard || (!facts.heard && has_reset)) {
    hook(HookKind::kReset);
  } else if (!facts.heard) {
    const BootVerdict verdict = judge_boot(facts, board_);
    throw BoardError(verdict.code, verdict.sentence);
  } else {
    restart_by_command();
  }
  return boot(Absence::kWaits);
}

BoardFacts BoardActions::power_on() {
  hook(HookKind::kPowerOn);
  return boot(Absence::kWaits);
}

BoardFacts BoardActions::power_cycle() {
  power_off();
  supervisor_.wait(board_.off_time);
  return power_on();
}

void BoardActions::power_off() { hook(HookKind::kPowerOff); }

void BoardActions::hook(HookKind kind, const std::filesystem::path& file) {
  const std::filesystem::path folder = list_.file.parent_path();
  const auto device = find_device(board_, list_.by_id).value_or(std::filesystem::path());
  const HookCommand command =
      hook_command(board_, kind, folder, hook_variables(board_, device, file));
  run_hook(supervisor_, command, folder,
           logs_ / fmt::format("{}_{}.log", board_.name, to_string(kind)));
}

void BoardActions::refuse_armed(const BoardFacts& facts) const {
  if (!facts.armed) return;
  throw BoardError(kExitBoardFailed,
                   fmt::format("board '{}' is armed: disarm it first (casctl disarm), or cut its "
                               "power (hils board power off {})",
                               board_.name, board_.name));
}

/// What a board that runs says within a few seconds; a dead one is there, and not heard. Nothing is
/// done to one whose port somebody else has: it may fly.
BoardFacts BoardActions::first_look() {
  const auto device = find_device(board_, list_.by_id);
  if (!device) return {};
  BoardSession session(supervisor_, board_, *device);
  const base::RunTime begin = base::steady_now();
  BoardFacts facts = session.look();
  while (!facts.heard && base::steady_now() - begin < kHeartbeatPatience) {
    supervisor_.wait(kLook);
    facts = session.look();
  }
  if (!facts.link_up) throw BoardError(kExitBoardAbsent, judge_boot(facts, board_).sentence);
  return facts;
}

/// Returns once the board has gone: its port is away, or its clock begins again.
void BoardActions::restart_by_command() {
  const auto device = find_device(board_, list_.by_id);
  if (!device) throw BoardError(kExitBoardAbsent, judge_boot({}, board_).sentence);
  BoardSession session(supervisor_, board_, *device);
  std::optional<double> before_s;
  base::RunTime begin = base::steady_now();
  while (before_s.value_or(0) < kTellingUptime_s &&
         base::steady_now() - begin < kHeartbeatPatience) {
    session.look();  // finds the autopilot
    before_s = session.uptime_s();
    supervisor_.wait(kLook);
  }
  session.reboot();
  begin = base::steady_now();
  while (base::steady_now() - begin < kRestartPatience) {
    const BoardFacts facts = session.look();
    const std::optional<double> now_s = session.uptime_s();
    if (!facts.link_up || !facts.heard || (before_s && now_s && *now_s < *before_s)) return;
    before_s = std::max(before_s, now_s);
    supervisor_.wait(kLook);
  }
  throw BoardError(kExitNoBoot,
                   fmt::format("board '{}' acknowledged the restart and did not restart: its port "
                               "stayed, and its SYSTEM_TIME went on",
                               board_.name));
}

}  // namespace cas::hils
