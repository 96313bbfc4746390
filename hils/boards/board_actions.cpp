// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_actions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <optional>
#include <string>

#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "base/time/clock.hpp"
#include "hils/boards/board_device.hpp"
#include "hils/boards/board_error.hpp"
#include "hils/boards/board_hook.hpp"
#include "hils/run/run_paths.hpp"

namespace cas::hils {

namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

/// Whether the output of a hook can be added to a file: it may be another user's.
bool can_append(const base::ResultPlace& place) {
  try {
    base::append_result(place);
    return true;
  } catch (const base::ConfigError&) {
    return false;
  }
}

constexpr base::Duration kLook = milliseconds(100);
constexpr base::Duration kAskAgain = seconds(2);
/// A board that runs says HEARTBEAT once a second.
constexpr base::Duration kHeartbeatPatience = seconds(4);
/// A board that has been up for this long says a shorter time after a restart: SYSTEM_TIME comes
/// once a second.
constexpr double kTellingUptime_s = 2;
/// From the acknowledged command to the restart, and to a SYSTEM_TIME that shows it.
constexpr base::Duration kRestartPatience = seconds(15);
/// From the end of a hook to its effect on the board; longer than two silences.
constexpr base::Duration kHookPatience = seconds(9);

/// The facts that a board reports within a few seconds.
BoardFacts hear(Supervisor& supervisor, BoardSession& session) {
  const base::RunTime begin = base::steady_now();
  BoardFacts facts = session.look();
  while (!facts.heard && base::steady_now() - begin < kHeartbeatPatience) {
    supervisor.wait(kLook);
    facts = session.look();
  }
  return facts;
}

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
    restart_by_hook();
  } else if (!facts.heard) {
    const BootVerdict verdict = judge_boot(facts, board_);
    throw BoardError(verdict.code, verdict.sentence);
  } else {
    restart_by_command();
  }
  return boot(Absence::kWaits);
}

BoardFacts BoardActions::restart() {
  const BoardFacts facts = first_look();
  if (facts.heard && !facts.hil) {
    throw BoardError(
        kExitBoardFailed,
        fmt::format("board '{}' does not say that it is in HIL: it is not restarted", board_.name));
  }
  const auto& hooks = board_.hooks;
  if (hooks.contains(HookKind::kPowerOn) && hooks.contains(HookKind::kPowerOff)) {
    return power_cycle(true);
  }
  if (hooks.contains(HookKind::kReset)) {
    restart_by_hook();
    return boot(Absence::kWaits);
  }
  if (facts.armed) disarm_in_hil(facts.device);
  return reboot(false);
}

BoardFacts BoardActions::power_on() {
  hook(HookKind::kPowerOn);
  return boot(Absence::kWaits);
}

BoardFacts BoardActions::power_cycle(bool force) {
  if (!force) refuse_armed(first_look());
  power_off();
  want_silence();
  supervisor_.wait(board_.off_time);
  return power_on();
}

void BoardActions::power_off() { hook(HookKind::kPowerOff); }

void BoardActions::hook(HookKind kind, const std::filesystem::path& file) {
  const std::filesystem::path folder = list_.file.parent_path();
  const auto device = find_device(board_, list_.by_id).value_or(std::filesystem::path());
  const HookCommand command =
      hook_command(board_, kind, folder, hook_variables(board_, device, file));
  const std::string name = fmt::format("{}_{}.log", board_.name, to_string(kind));
  std::filesystem::path log = logs_ / name;
  std::optional<RunDirectory> scratch;
  if (logs_.empty() || !can_append({logs_, name})) log = scratch.emplace().path() / name;
  run_hook(supervisor_, command, folder, log);
}

void BoardActions::refuse_armed(const BoardFacts& facts) const {
  if (!facts.armed) return;
  throw BoardError(kExitBoardFailed,
                   fmt::format("board '{}' is armed: disarm it first (casctl disarm), or cut its "
                               "power (hils board power off {})",
                               board_.name, board_.name));
}

/// Facts of a running board; a dead board is present but not heard. A board whose port another
/// program has is left alone: it may be flying.
BoardFacts BoardActions::first_look() {
  const auto device = find_device(board_, list_.by_id);
  if (!device) return {};
  BoardSession session(supervisor_, board_, *device);
  BoardFacts facts = hear(supervisor_, session);
  if (!facts.link_up) throw BoardError(kExitBoardAbsent, judge_boot(facts, board_).sentence);
  return facts;
}

void BoardActions::disarm_in_hil(const std::filesystem::path& device) {
  BoardSession session(supervisor_, board_, device);
  const BoardFacts facts = hear(supervisor_, session);
  if (facts.heard && facts.armed && facts.hil) session.disarm();
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
  refuse_armed(session.look());
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

/// By the hook `reset`. Returns once the board has gone: its port is away, or its clock began after
/// the hook did; where it has no clock to tell, its HEARTBEATs stopped.
void BoardActions::restart_by_hook() {
  const base::RunTime begin = base::steady_now();
  hook(HookKind::kReset);
  bool comes = false;
  const bool gone = goes([&](BoardSession& session, const BoardFacts& facts) {
    if (session.began().value_or(begin) > begin) return true;
    const bool stopped = comes && !facts.heard;
    comes = facts.heard;
    return stopped;
  });
  // One that is silent boots slowly or not at all: the wait for its boot tells.
  if (gone || !comes) return;
  throw BoardError(kExitNoBoot,
                   fmt::format("board '{}' did not restart: hook reset was done, and its port "
                               "stayed and its SYSTEM_TIME shows no restart",
                               board_.name));
}

/// Without power a board has no port, or nothing comes from it.
void BoardActions::want_silence() {
  std::optional<base::RunTime> last;
  const bool silent = goes([&](BoardSession&, const BoardFacts& facts) {
    const base::RunTime now = base::steady_now();
    if (!last || facts.heard) last = now;
    return now - *last >= kHeartbeatPatience;
  });
  if (silent) return;
  throw BoardError(kExitBoardFailed,
                   fmt::format("board '{}' still says HEARTBEAT after its power was cut: hook "
                               "power_off does not switch this board",
                               board_.name));
}

/// @return whether its port went, or `shows` said so, within the patience with a hook
bool BoardActions::goes(const std::function<bool(BoardSession&, const BoardFacts&)>& shows) {
  const auto device = find_device(board_, list_.by_id);
  if (!device) return true;
  BoardSession session(supervisor_, board_, *device);
  const base::RunTime begin = base::steady_now();
  while (base::steady_now() - begin < kHookPatience) {
    const BoardFacts facts = session.look();
    if (!facts.link_up || find_device(board_, list_.by_id) != device) return true;
    if (shows(session, facts)) return true;
    supervisor_.wait(kLook);
  }
  return false;
}

}  // namespace cas::hils
