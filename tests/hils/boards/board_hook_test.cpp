// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_hook.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "tests/support/refusal.hpp"

namespace cas::hils {
namespace {

const Board kBoard{.name = "bench1", .serial = "3A0027", .kind = "fmu-v6x", .firmware = "1.15"};

std::string error_of(const std::vector<std::string>& command, const HookVariables& variables) {
  return test::refusal([&] { fill_in(command, variables); });
}

TEST(BoardHook, IsToldWhichBoardItIsAbout) {
  const HookVariables variables = hook_variables(kBoard, "/dev/ttyACM0", "/tmp/new.px4");
  const std::vector<std::string> filled =
      fill_in({"flash", "--port=${CAS_BOARD_DEVICE}", "${CAS_BOARD}:${CAS_BOARD_SERIAL}",
               "${CAS_BOARD_FILE}", "$HOME and {}"},
              variables);
  EXPECT_EQ(filled, (std::vector<std::string>{"flash", "--port=/dev/ttyACM0", "bench1:3A0027",
                                              "/tmp/new.px4", "$HOME and {}"}));
}

TEST(BoardHook, ThatAsksForWhatIsNotThereIsRefused) {
  const HookVariables variables = hook_variables(kBoard, "", "");
  EXPECT_EQ(error_of({"${CAS_BOARD_FILE}"}, variables),
            "CAS_BOARD_FILE has no value here, and the hook's command asks for it");
  EXPECT_EQ(error_of({"${HOME}"}, variables), "a hook knows no variable HOME");
  EXPECT_EQ(error_of({"${CAS_BOARD"}, variables), "'${CAS_BOARD' has no closing brace");
}

TEST(BoardHook, FindsItsProgramInPathAndHasItsVariablesInTheEnvironment) {
  Board board = kBoard;
  board.hooks[HookKind::kReset] = {.command = {"sh", "-c", "true"}, .timeout = {}};
  const HookCommand command =
      hook_command(board, HookKind::kReset, "/nowhere", hook_variables(board, "", ""));
  EXPECT_EQ(command.name, "hook reset of board 'bench1'");
  EXPECT_TRUE(std::filesystem::path(command.arguments.front()).is_absolute());
  EXPECT_EQ(command.environment.front(), "CAS_BOARD=bench1");
  board.hooks[HookKind::kReset].command.front() = "./sh";
  EXPECT_THROW(hook_command(board, HookKind::kReset, "/nowhere", {}), base::ConfigError);
  EXPECT_THROW(hook_command(board, HookKind::kFlash, "/nowhere", {}), base::ConfigError);
}

}  // namespace
}  // namespace cas::hils
