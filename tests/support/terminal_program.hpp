// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "tests/support/wait_until.hpp"

namespace cas::test {

/// A full-screen program on a terminal of its own, whose screen the test reads and whose keys it
/// presses. The terminal is a VT52: it has no attributes and a handful of sequences.
class TerminalProgram {
 public:
  TerminalProgram(const std::vector<std::string>& command, std::size_t rows, std::size_t columns);
  ~TerminalProgram();
  TerminalProgram(const TerminalProgram&) = delete;
  TerminalProgram& operator=(const TerminalProgram&) = delete;

  void resize(std::size_t rows, std::size_t columns);
  void press(const std::string& keys);
  /// The lines that are on the screen now, without trailing blanks.
  const std::vector<std::string>& screen();
  std::string text();
  /// Waits until the screen has this text, in a line or in words that go on in the next one.
  bool shows(const std::string& wanted, base::Duration patience = kPatience);
  /// Waits for the end of the program. @return its exit code
  std::optional<int> wait_exit();

 private:
  void read_terminal();
  void on_byte(unsigned char byte);
  void on_escape(unsigned char byte);
  void put(char c);
  void clear_from(std::size_t row, std::size_t column, bool to_the_end);

  int master_ = -1;
  pid_t pid_ = -1;
  std::optional<int> exit_code_;
  std::vector<std::string> cells_;   ///< as wide as the terminal
  std::vector<std::string> screen_;  ///< trimmed
  std::size_t row_ = 0, column_ = 0;
  /// Kind of the next byte: text, the letter behind ESC, or a place behind ESC Y.
  enum class Expects { kText, kLetter, kRow, kColumn } expects_ = Expects::kText;
};

}  // namespace cas::test
