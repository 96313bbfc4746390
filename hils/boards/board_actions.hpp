// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <functional>
#include <utility>

#include "hils/boards/board_list.hpp"
#include "hils/boards/board_session.hpp"
#include "hils/boards/boot_check.hpp"
#include "hils/programs/supervisor.hpp"

namespace cas::hils {

/// Whether a board that is not there is waited for: it is, after something that makes it come back.
enum class Absence { kFails, kWaits };

/// Actions on a board for the holder of its lock.
class BoardActions {
 public:
  /// @param logs  folder for the output of hooks; where it is empty or cannot be written to, their
  ///              output goes when they end. All outlive it
  BoardActions(Supervisor& supervisor, const BoardList& list, const Board& board,
               std::filesystem::path logs)
      : supervisor_(supervisor), list_(list), board_(board), logs_(std::move(logs)) {}

  /// Waits for the board's HEARTBEAT and version, at most for its boot time.
  /// @return its facts @throws BoardError (kExitBoardAbsent, kExitNoBoot), RunStopped
  BoardFacts boot(Absence absence);

  /// Each of these waits for the boot that comes of it.
  /// @throws BoardError, RunStopped, base::ConfigError where there is no such hook
  BoardFacts flash(const std::filesystem::path& file);
  /// By its own command; by the hook `reset` where it is silent, or `hard` is set.
  BoardFacts reboot(bool hard);
  /// Restarts the board for a new flight: by its power if hooks switch it, by hook `reset`, else by
  /// its command; an armed one in HIL is disarmed for that. One that reports not to be in HIL is
  /// left alone: BoardError.
  BoardFacts restart();
  BoardFacts power_on();
  /// @param force  also of a board that is armed, or whose port another program has
  BoardFacts power_cycle(bool force);
  void power_off();

 private:
  void hook(HookKind kind, const std::filesystem::path& file = {});
  void refuse_armed(const BoardFacts& facts) const;
  BoardFacts first_look();
  void disarm_in_hil(const std::filesystem::path& device);
  void restart_by_command();
  void restart_by_hook();
  void want_silence();
  bool goes(const std::function<bool(BoardSession&, const BoardFacts&)>& shows);

  Supervisor& supervisor_;
  const BoardList& list_;
  const Board& board_;
  std::filesystem::path logs_;
};

}  // namespace cas::hils
