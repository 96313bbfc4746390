// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "tests/support/child_process.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {

/// A shelf of stand-ins for boards: emulators behind pseudo-terminals, under links that are named
/// as udev names boards, and a boards.yaml whose hooks switch them on and off and "flash" them. The
/// hooks are the programs that a user has; a file NAME.defect names a board's defect:
///   absent   its port does not come      silent   it comes, and the firmware hangs
///   slow     it comes late               hang     the flash tool hangs
///   broken   the flash tool fails    stuck    its power switch and its button do nothing
class BoardShelf {
 public:
  /// @param boards  the names of boards, each with further keys of boards.yaml behind a space:
  /// "left boot_timeout_s: 2, firmware: 1.15"; their systems are 1, 2, ...
  explicit BoardShelf(const std::vector<std::string>& boards = {"a"});
  ~BoardShelf();
  BoardShelf(const BoardShelf&) = delete;
  BoardShelf& operator=(const BoardShelf&) = delete;

  /// The command line of the real hils on this shelf.
  std::vector<std::string> command(const std::vector<std::string>& arguments) const;
  /// Starts it. @param environment  further "NAME=VALUE"
  std::unique_ptr<ChildProcess> start(const std::vector<std::string>& arguments,
                                      const std::vector<std::string>& environment = {}) const;
  /// Runs it to its end.
  Ended hils(const std::vector<std::string>& arguments,
             const std::vector<std::string>& environment = {}) const;
  Ended board(std::vector<std::string> arguments,
              const std::vector<std::string>& environment = {}) const;

  void set_defect(const std::string& board, const std::string& defect) const;
  /// The stand-in dies, and udev takes its link away.
  void crash(const std::string& board) const;
  /// It stops: the port is there, and nothing comes from it.
  void hang(const std::string& board) const;
  /// The emulator's answer to `fcu.status` on its control socket, as JSON text; empty: not there.
  std::string status(const std::string& board) const;
  /// The USB cable is drawn, for longer than any test.
  bool unplug(const std::string& board) const;

  std::filesystem::path link(const std::string& board) const;
  std::string said(const std::string& file) const { return TemporaryFolder::read(folder / file); }

  TemporaryFolder folder;

 private:
  int process(const std::string& board) const;

  std::vector<std::string> names_;
};

}  // namespace cas::test
