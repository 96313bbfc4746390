// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_unlock.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>

#include <chrono>
#include <string>
#include <vector>

#include "base/time/clock.hpp"
#include "hils/boards/board_error.hpp"
#include "hils/boards/board_lock.hpp"

namespace cas::hils {

namespace {

namespace fs = std::filesystem;

/// Behind a sentence: the processes that hold the board, as far as they can be seen.
std::string seen_holders(const Board& board, const fs::path& folder) {
  const std::vector<std::string> seen = who_has_locked(board, folder);
  if (seen.empty()) return ": what holds the board is another user's or another container's";
  return fmt::format("; what holds the board is {}", fmt::join(seen, ", "));
}

/// Refuses to end a process that the lock's file names and that does not hold it, as far as can be
/// seen: others may write to the file, and numbers of processes are used again.
void refuse_wrong_process(const Board& board, const fs::path& folder, const LockState& state) {
  if (!state.heirs.empty()) {
    throw BoardError(kExitBoardBusy,
                     fmt::format("board '{}': {}; end that", board.name, to_words(state)));
  }
  const fs::path file = lock_file(folder, board);
  if (!descriptors_of(state.holder->pid, file).empty()) return;
  throw BoardError(
      kExitBoardBusy,
      fmt::format("board '{}': process {} does not have {} open, as far as can be seen{}",
                  board.name, state.holder->pid, file.string(), seen_holders(board, folder)));
}

/// Waits until this lock has ended. @throws BoardError
LockState wait_for_end(const Board& board, const fs::path& folder, const LockHolder& holder) {
  constexpr base::Duration kPatience = std::chrono::seconds(10);
  constexpr int kLookMs = 20;
  const base::RunTime begin = base::steady_now();
  while (true) {
    LockState state = look_at_lock(board, folder);
    if (!state.held || (state.holder && state.holder->token != holder.token)) return state;
    if (!state.holder && state.has_guests) return state;
    if (base::steady_now() - begin > kPatience) {
      throw BoardError(kExitBoardBusy, fmt::format("board '{}': process {} was told to end, and "
                                                   "it or what it started still holds the board",
                                                   board.name, holder.pid));
    }
    ::poll(nullptr, 0, kLookMs);
  }
}

}  // namespace

void unlock_board(const Board& board, const fs::path& folder, bool force) {
  LockState state = look_at_lock(board, folder);
  if (state.held) {
    if (!state.holder) {
      throw BoardError(kExitBoardBusy, fmt::format("board '{}' is at work: {}{}", board.name,
                                                   to_words(state), seen_holders(board, folder)));
    }
    if (!force && !state.holder->in_background && state.heirs.empty()) {
      throw BoardError(kExitBoardBusy,
                       fmt::format("board '{}' is at work: {}; --force ends that program",
                                   board.name, to_words(state)));
    }
    const LockHolder holder = *state.holder;
    refuse_wrong_process(board, folder, state);
    if (::kill(holder.pid, SIGTERM) != 0) {
      throw BoardError(kExitBoardBusy, fmt::format("board '{}': process {} is not yours to end: {}",
                                                   board.name, holder.pid, to_words(state)));
    }
    state = wait_for_end(board, folder, holder);
  }
  fmt::print("board '{}' is {}\n", board.name,
             state.has_guests ? "free once the program ends that uses it below the lock" : "free");
}

}  // namespace cas::hils
