// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cas::hils {

/// Holder of a board according to the lock's file.
struct LockHolder {
  pid_t pid = 0;
  std::string user;
  std::string since;           ///< UTC: "2026-03-01T12:00:00Z"
  std::string purpose;         ///< "hils run hover.yaml"
  std::string token;           ///< proof_of() of the random token of this one lock
  bool in_background = false;  ///< no command of its own depends on it

  /// A line for each key.
  std::string text() const;
  /// @return nullopt where the text is no holder's: one that is just being written
  static std::optional<LockHolder> parse(std::string_view text);
};

/// "process 123 of ann since 2026-03-01T12:00:00Z: hils run hover.yaml".
std::string to_words(const LockHolder& holder);

/// Whether CAS_BOARD_HOLDER, tokens with commas between them, has this one. Programs below a holder
/// have it, so that the lock around them does not lock them out. Pure.
/// @param variable  its value; nullptr: none
bool names_token(const char* variable, std::string_view proof);

/// What a lock file, which others may read, has in the place of its token. Pure.
std::string proof_of(std::string_view token);

/// A waiter's place in the queue: the name of its ticket, which sorts by the time of its coming.
/// @param at_ns  since 1970
std::string ticket_name(std::int64_t at_ns, pid_t pid);

/// How many tickets of the queue stand before this one. Pure.
/// @param alive  names of tickets whose waiters are still there
std::size_t places_before(const std::vector<std::string>& alive, std::string_view own);

}  // namespace cas::hils
