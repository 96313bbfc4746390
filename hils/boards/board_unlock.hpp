// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>

#include "hils/boards/board_list.hpp"

namespace cas::hils {

/// Ends the holders of a board, waits for their end, and says on standard output that the board is
/// free.
/// @param folder  of the locks
/// @param force  ends also a program at work, not only a lock in the background
/// @throws BoardError (kExitBoardBusy)
void unlock_board(const Board& board, const std::filesystem::path& folder, bool force);

}  // namespace cas::hils
