// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/os/descriptor.hpp"
#include "base/time/clock.hpp"
#include "hils/boards/board_list.hpp"
#include "hils/boards/lock_holder.hpp"

namespace cas::hils {

/// The user's own folder for locks in another one, made with mode 0700 where it is missing.
/// @throws base::ConfigError if it is another user's, or others have access to it
std::filesystem::path own_lock_folder(const std::filesystem::path& parent);

/// Where the locks are: the list's `lock_folder`, else the user's own in /var/tmp, which no
/// environment moves and no logout clears; made where it is missing. @throws base::ConfigError also
/// where others may delete a lock
std::filesystem::path lock_folder(const BoardList& list);

/// "CAS_BOARD_HOLDER=TOKENS": for programs that may use the boards that this one holds or uses as a
/// guest.
std::string holder_setting();

/// The file that is locked.
std::filesystem::path lock_file(const std::filesystem::path& folder, const Board& board);

/// Descriptors of a process that are this file, however it came by them; none where its descriptors
/// are not this user's to see, or the number is of another container.
std::vector<int> descriptors_of(pid_t process, const std::filesystem::path& file);

/// Processes that hold a board or use it below a lock, as far as this user can see them:
/// "process 12 (make)".
std::vector<std::string> who_has_locked(const Board& board, const std::filesystem::path& folder);

/// Present holder of a board.
struct LockState {
  bool held = false;
  bool has_guests = false;             ///< a program uses it below a lock
  std::optional<LockHolder> holder{};  ///< nothing where it has not said so yet
  std::vector<std::string> heirs{};    ///< after the holder's end: owners of its lock
  std::size_t waiting = 0;             ///< programs in the queue
};
LockState look_at_lock(const Board& board, const std::filesystem::path& folder);

/// "it is held by process 12 of ann since ...: hils run hover.yaml; 2 wait for it".
std::string to_words(const LockState& state);

/// The lock of one board: that of a file, which the kernel frees when the holder ends, however it
/// ends. The file says who holds it; its token goes into this program's environment, as
/// CAS_BOARD_HOLDER, so that its children may use the board. Such a guest holds a shared lock on a
/// second file: while one works, no other program takes the board, even if the lock above it has
/// ended.
///
///   NAME.lock    exclusive: the holder, and heirs of its descriptor
///   NAME.guests  shared: guests; exclusive, for a moment: who takes NAME.lock
///
/// A waiter has a ticket in a queue; the kernel frees it when the waiter ends. First come, first
/// served.
class BoardLock {
 public:
  /// @param wait  longest time in the queue; nullopt: does not queue
  /// @throws BoardError (kExitBoardBusy), base::ConfigError
  BoardLock(const Board& board, const std::filesystem::path& folder, const std::string& purpose,
            std::optional<base::Duration> wait);
  ~BoardLock();
  BoardLock(BoardLock&&) = default;
  BoardLock& operator=(BoardLock&&) = delete;

  /// Used below a lock that CAS_BOARD_HOLDER names.
  bool is_guest() const { return !lock_; }
  /// Descriptor for a child that shall hold the board, too; -1 for a guest.
  int descriptor() const { return lock_.get(); }
  /// A child in the background that has inherited the descriptor holds the board from now on.
  void hand_over(pid_t child);
  /// A child that has inherited the descriptor holds the board until it ends; the file still names
  /// this process.
  void leave_to_heirs() { handed_over_ = true; }

 private:
  void write() const;

  bool become_guest(const Board& board, const std::filesystem::path& folder);

  base::Descriptor lock_;
  base::Descriptor guest_;
  LockHolder holder_;
  bool handed_over_ = false;
};

}  // namespace cas::hils
