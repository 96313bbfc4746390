// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "casd/casctl/monitor/screen_text.hpp"

namespace cas::casctl {

/// The terminal in full-screen mode for as long as the object lives.
class Terminal {
 public:
  /// Keys that are no characters.
  enum Key : int {
    kNone = -1,
    kUp = 0x1000,
    kDown,
    kLeft,
    kRight,
    kPageUp,
    kPageDown,
    kEnter,
    kEscape,
    kTab,
    kBackspace,
    kClear,  ///< Ctrl-U: the whole line
    kResize
  };

  Terminal();
  ~Terminal();
  Terminal(const Terminal&) = delete;
  Terminal& operator=(const Terminal&) = delete;

  std::size_t rows() const;
  std::size_t width() const;
  /// Whether text beyond ASCII can be shown.
  bool unicode() const;
  void draw(const Block& lines);
  /// Waits for a key. @return a character, a Key, or kNone when none came in time
  int read_key(int patience_ms);
};

}  // namespace cas::casctl
