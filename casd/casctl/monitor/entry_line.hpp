// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "casd/casctl/monitor/prompt.hpp"

namespace cas::casctl {

/// The line that is typed at the bottom of the screen: a filter, a command, or the gains of a loop.
/// Pure: keys and words come in, a Result goes out.
class EntryLine {
 public:
  enum class Kind { kNone, kFilter, kCommand, kGain };

  /// Effect of a key.
  struct Result {
    bool ended = false;                    ///< the line is closed
    std::optional<std::string> filter{};   ///< to be shown from now on
    std::optional<std::string> command{};  ///< to be run
    bool wants_parameters = false;         ///< completion needs their names
  };

  void begin(Kind kind, std::string text);
  /// @param values  those in force, "0.15 0.2 0.003"; the first character typed replaces them
  void begin_gains(std::string loop, std::string values);
  /// @param key  a character or a Terminal::Key
  Result on_key(int key, const PromptWords& words);
  /// Notes a command for kUp and kDown.
  void remember(const std::string& command) { history_.push_back(command); }
  /// The newest command. There is one.
  const std::string& newest() const { return history_.back(); }

  Kind kind() const { return kind_; }
  bool is_open() const { return kind_ != Kind::kNone; }

  /// "filter: HIL", "vehicle 2 : takeoff 3", "gains of roll (P I D): 6.5".
  /// @param addressee  target of a command, if casd hears several
  std::string text(const std::string& addressee) const;
  /// Words that may follow, as many as fit into `width`.
  /// @param asking  the parameters' names are being fetched
  std::string hint(const PromptWords& words, bool asking, std::size_t width) const;

 private:
  bool edit_command(int key, const PromptWords& words);

  Kind kind_ = Kind::kNone;
  std::string text_;                  ///< under edit
  std::string loop_;                  ///< whose gains are under edit
  bool untouched_ = false;            ///< they are those in force, and no key was pressed
  std::vector<std::string> history_;  ///< of commands
  std::size_t earlier_ = 0;           ///< place in it
};

}  // namespace cas::casctl
