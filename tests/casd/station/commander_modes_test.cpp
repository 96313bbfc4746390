// SPDX-License-Identifier: BSD-3-Clause
#include "tests/casd/station/commander_fixture.hpp"

namespace cas::casd {
namespace {

using namespace mavlink::common;
using test::VehicleCommanderTest;

TEST_F(VehicleCommanderTest, SetsPx4ModesByMainAndSubMode) {
  meet();
  commander_.hold(1, now_, done());
  EXPECT_TRUE(finish().ok());
  EXPECT_EQ(vehicle_.commands.at(0).param1, 33.0F);  // custom and HIL
  EXPECT_EQ(vehicle_.commands.at(0).param2, 4.0F);
  EXPECT_EQ(vehicle_.commands.at(0).param3, 3.0F);
}

TEST_F(VehicleCommanderTest, AnswersAnUnknownModeWithTheModesThereAre) {
  meet();
  commander_.set_mode(1, "WARP", now_, done());
  const Outcome outcome = finish();
  EXPECT_EQ(outcome.kind, OutcomeKind::kInvalid);
  EXPECT_NE(outcome.message.find("POSCTL"), std::string::npos);
}

}  // namespace
}  // namespace cas::casd
