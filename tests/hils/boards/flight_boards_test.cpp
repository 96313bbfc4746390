// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/flight_boards.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "hils/boards/board_flags.hpp"
#include "tests/support/refusal.hpp"

namespace cas::hils {
namespace {

const VehicleNames kOne{"iris0"};
const VehicleNames kTwo{"left", "right"};

std::string error_of(const std::vector<std::string>& words, const VehicleNames& vehicles) {
  return test::refusal([&] { parse_fcu_words(words, vehicles); });
}

TEST(FcuWords, NameTheControllerOfTheOnlyVehicle) {
  const auto choices = parse_fcu_words({"bench1"}, kOne);
  ASSERT_EQ(choices.size(), 1U);
  EXPECT_EQ(choices[0].vehicle, 0U);
  EXPECT_EQ(choices[0].controller, "bench1");
  EXPECT_EQ(parse_fcu_words({"/dev/serial/by-id/a=b"}, kOne)[0].controller,
            "/dev/serial/by-id/a=b");
}

TEST(FcuWords, NameTheVehicleWhereThereAreSeveral) {
  const auto choices = parse_fcu_words({"right=bench1", "left=/dev/ttyACM0"}, kTwo);
  ASSERT_EQ(choices.size(), 2U);
  EXPECT_EQ(choices[0].vehicle, 1U);
  EXPECT_EQ(choices[1].vehicle, 0U);
  EXPECT_EQ(choices[1].controller, "/dev/ttyACM0");
}

TEST(FcuWords, ThatFitNoVehicleAreRefused) {
  EXPECT_EQ(error_of({"bench1"}, kTwo),
            "--fcu bench1: the scenario has several vehicles: say which one, --fcu left=bench1");
  EXPECT_EQ(error_of({"middle=a"}, kTwo),
            "--fcu: there is no vehicle 'middle'; vehicles are left, right");
  EXPECT_EQ(error_of({"left=a", "left=b"}, kTwo), "--fcu: vehicle 'left' has two controllers");
  EXPECT_EQ(error_of({"left=a", "right=a"}, kTwo), "--fcu: a cannot fly two vehicles");
  EXPECT_EQ(error_of({"left="}, kTwo), "--fcu left=: names no board");
}

TEST(FcuWords, AreBoardsBeforeTheyArePaths) {
  BoardList list;
  list.boards = {{.name = "bench1", .serial = "1"}};
  EXPECT_TRUE(is_board("bench1", &list, true));
  EXPECT_FALSE(is_board("./bench1", &list, true));
  EXPECT_FALSE(is_board("ttyACM0", &list, true)) << "a file of the working folder";
  EXPECT_THROW(is_board("bensh1", &list, false), base::ConfigError);
  EXPECT_FALSE(is_board("ttyACM0", nullptr, true));
  EXPECT_FALSE(is_board("/dev/ttyACM9", nullptr, false)) << "told of when it is opened";
}

TEST(GoneBoard, FailsItsFlightAndNoOtherThatPassed) {
  RunResult run;
  run.vehicles.resize(2);
  run.vehicles[0].verdict = {.valid = true, .passed = true, .failures = {}};
  run.vehicles[1].figures.vehicle = "right";
  run.vehicles[1].verdict = {.valid = false, .passed = false, .failures = {"too busy"}};
  run.verdict = judge_together(run.vehicles);
  fail_absent({{0, "left is gone"}}, run);
  EXPECT_EQ(run.verdict.exit_code(), kExitInvalid);
  fail_absent({{0, "left is gone"}, {1, "it is gone"}}, run);
  EXPECT_EQ(run.verdict.exit_code(), kExitLimitsMissed);
  EXPECT_EQ(run.verdict.failures,
            (std::vector<std::string>{"right: it is gone", "right: too busy"}));
  EXPECT_TRUE(run.vehicles[0].verdict.passed);
}

TEST(Wait, IsForeverOrSoManySeconds) {
  EXPECT_FALSE(parse_wait(""));
  EXPECT_EQ(parse_wait("2.5"), base::Duration(std::chrono::milliseconds(2500)));
  EXPECT_GT(parse_wait("forever"), base::Duration(std::chrono::hours(1000)));
  EXPECT_THROW(parse_wait("-1"), base::ConfigError);
  EXPECT_THROW(parse_wait("soon"), base::ConfigError);
}

TEST(Wait, WithItsSecondsBehindASpaceIsNamed) {
  using Words = std::vector<std::string_view>;
  EXPECT_EQ(misread_wait(Words{"hils", "board", "flash", "a", "--wait", "600"}),
            "--wait has its seconds behind a '=': --wait=600");
  EXPECT_EQ(misread_wait(Words{"hils", "board", "flash", "a", "--wait=600", "600"}), std::nullopt);
  EXPECT_EQ(misread_wait(Words{"hils", "board", "lock", "a", "--wait", "--", "sleep", "1"}),
            std::nullopt);
  EXPECT_EQ(misread_wait(Words{"hils", "board", "lock", "a", "--", "make", "--wait", "1"}),
            std::nullopt);
}

}  // namespace
}  // namespace cas::hils
