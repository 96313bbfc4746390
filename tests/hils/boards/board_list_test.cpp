// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_list.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>

#include "base/error.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using std::chrono::seconds;

BoardList parse(const std::string& boards) {
  return BoardList::parse(
      base::ConfigNode::parse("schema: 1\nboards:\n" + boards, "/shelf/boards.yaml"));
}

TEST(BoardList, ReadsABoardWithItsHooks) {
  const BoardList list = parse(R"(
  bench1:
    serial: 0123
    kind: px4_fmu-v6x
    firmware: 1.15
    commit: 12ab
    calibration: done
    boot_timeout_s: 12
    hooks:
      flash: {command: [./flash, "${CAS_BOARD_FILE}"], timeout_s: 90}
      power_off: [uhubctl, -a, off]
  bench2: {device: ports/b, baud: 57600, sensors_device: ports/c, outputs_disconnected: true}
)");
  const Board& board = list.board("bench1");
  EXPECT_EQ(board.serial, "0123");
  EXPECT_EQ(board.firmware, "1.15");
  EXPECT_EQ(board.commit, "12ab");
  EXPECT_EQ(board.calibration, Calibration::kDone);
  EXPECT_EQ(board.boot_timeout, seconds(12));
  EXPECT_EQ(board.hooks.at(HookKind::kFlash).timeout, seconds(90));
  EXPECT_EQ(board.hooks.at(HookKind::kFlash).command.back(), "${CAS_BOARD_FILE}");
  EXPECT_EQ(board.hooks.at(HookKind::kPowerOff).timeout, seconds(30));
  EXPECT_FALSE(board.hooks.contains(HookKind::kReset));
  EXPECT_EQ(list.board("bench2").device, "/shelf/ports/b");
  EXPECT_EQ(list.board("bench2").baud, 57600U);
  EXPECT_EQ(list.board("bench2").sensors_device, "/shelf/ports/c");
  EXPECT_TRUE(list.board("bench2").outputs_disconnected);
  EXPECT_FALSE(board.outputs_disconnected);
  EXPECT_EQ(list.find("bench3"), nullptr);
}

TEST(BoardList, TheShippedExampleIsOne) {
  const BoardList list =
      BoardList::parse(base::ConfigNode::load(cas::test::source_dir() + "/config/boards.yaml"));
  EXPECT_GE(list.boards.size(), 2U);
  EXPECT_TRUE(list.boards.front().hooks.contains(HookKind::kFlash));
}

TEST(BadBoardList, IsRefusedWithTheLineAndTheReason) {
  struct BadList {
    const char* boards;
    const char* sentence;
  };
  const BadList rows[] = {
      {"  a: {kind: x}\n", ":3: boards.a: has a `serial`"},
      {"  a: {serial: 1, device: /dev/x}\n", "one of them"},
      {"  a: {serial: 1}\n  b: {serial: 1}\n", "is the same board as 'a'"},
      {"  a/b: {serial: 1}\n", "a board's name is made of"},
      {"  a: {serial: 1, hooks: {flash: make flash}}\n", "boards.a.hooks.flash: is a list"},
      {"  a: {serial: 1, hooks: {flash: []}}\n", "names no program"},
      {"  a: {serial: 1, calibration: some}\n", "'some' is none of unknown, done, missing"},
      {"  a: {serial: 1, commit: xyz}\n", "is hexadecimal"},
      {"  a: {serial: 1, hooks: {flsh: [a]}}\n", "did you mean 'flash'"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.boards);
    const std::string text = test::refusal([&] { parse(row.boards); });
    EXPECT_EQ(text.find("/shelf/boards.yaml:"), 0U) << text;
    EXPECT_NE(text.find(row.sentence), std::string::npos) << text;
  }
}

TEST(BoardList, SaysWhichBoardMayHaveBeenMeant) {
  const BoardList list = parse("  bench1: {serial: 1}\n");
  EXPECT_EQ(test::refusal([&] { list.board("bensh1"); }),
            "/shelf/boards.yaml: there is no board 'bensh1'; did you mean 'bench1'?");
}

TEST(BoardList, IsNeverFoundInTheWorkingFolder) {
  const test::TemporaryFolder folder;
  const std::filesystem::path before = std::filesystem::current_path();
  folder.write("boards.yaml", "schema: 1\nboards: {a: {device: fcu0}}\n");
  ::setenv("XDG_CONFIG_HOME", (folder / "none").c_str(), 1);
  ::unsetenv("CAS_BOARDS");
  std::filesystem::current_path(folder.path());
  const std::filesystem::path found = find_board_list("");
  std::filesystem::current_path(before);
  ::unsetenv("XDG_CONFIG_HOME");
  EXPECT_TRUE(found.empty() || found == "/etc/cas/boards.yaml") << found;
}

TEST(BoardList, ThatOthersMayWriteIsNotRead) {
  const test::TemporaryFolder folder;
  const auto file = folder.write("boards.yaml", "schema: 1\nboards: {a: {device: fcu0}}\n");
  EXPECT_NO_THROW(BoardList::load(file));
  std::filesystem::permissions(file, std::filesystem::perms(0646));
  EXPECT_THROW(BoardList::load(file), base::ConfigError);
}

}  // namespace
}  // namespace cas::hils
