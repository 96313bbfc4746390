// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>

#include "base/os/descriptor.hpp"
#include "base/time/clock.hpp"
#include "hils/boards/board_list.hpp"
#include "hils/boards/lock_holder.hpp"

namespace cas::hils {

/// Where the locks are: the list's `lock_folder`, else `boards` in the user's runtime folder; made
/// where it is missing. @throws base::ConfigError
std::filesystem::path lock_folder(const BoardList& list);

/// "CAS_BOARD_HOLDER=PID": for programs that may use what `holder` holds, besides what this one
/// may.
std::string holder_setting(pid_t holder);

/// Who has a board, at this moment.
struct LockState {
  bool held = false;
  std::optional<LockHolder> holder{};  ///< nothing where it has not said so yet
  std::size_t waiting = 0;             ///< programs in the queue
};
LockState look_at_lock(const Board& board, const std::filesystem::path& folder);

/// "it is held by process 12 of ann since ...: hils run hover.yaml; 2 wait for it".
std::string to_words(const LockState& state);

/// The lock of one board: that of a file, which the kernel frees when the holder ends, however it
/// ends. The file says who holds it. Who waits has a ticket in a queue, which goes with it, too;
/// the first who came is the first to get the board.
class BoardLock {
 public:
  /// @param wait  how long to stand in the queue; nothing: not at all
  /// @throws BoardError (kExitBoardBusy), base::ConfigError
  BoardLock(const Board& board, const std::filesystem::path& folder, const std::string& purpose,
            std::optional<base::Duration> wait);
  ~BoardLock();
  BoardLock(BoardLock&&) = default;
  BoardLock& operator=(BoardLock&&) = delete;

  /// Held already by a process in CAS_BOARD_HOLDER: this object frees nothing.
  bool is_guest() const { return !lock_; }
  /// A child that has inherited the descriptor holds the board from now on.
  void hand_over(pid_t child);

 private:
  void write() const;

  base::Descriptor lock_;
  LockHolder holder_;
  bool handed_over_ = false;
};

}  // namespace cas::hils
