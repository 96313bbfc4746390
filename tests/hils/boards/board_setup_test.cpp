// SPDX-License-Identifier: BSD-3-Clause
#include "hils/boards/board_setup.hpp"

#include <gtest/gtest.h>

#include "tests/support/refusal.hpp"

namespace cas::hils {
namespace {

const casd::ParamValues kStock{
    {"EAHRS_TYPE", 0},    {"EAHRS_RATE", 50}, {"EAHRS_SENSORS", 15}, {"SERIAL2_PROTOCOL", 2},
    {"SERIAL2_BAUD", 57}, {"GPS1_TYPE", 1},   {"AHRS_EKF_TYPE", 3},  {"INS_ENABLE_MASK", 127}};

TEST(BoardSetup, ChangesWhatIsOtherwise) {
  const auto changes = external_ahrs_changes(kStock, 2);
  std::string names;
  for (const ParamChange& change : changes) {
    names += change.name + " ";
    EXPECT_EQ(change.before, kStock.at(change.name));
    EXPECT_FALSE(change.meaning.empty());
  }
  EXPECT_EQ(names,
            "EAHRS_TYPE EAHRS_RATE SERIAL2_PROTOCOL SERIAL2_BAUD GPS1_TYPE INS_ENABLE_MASK ");

  casd::ParamValues now = kStock;
  for (const ParamChange& change : changes) now[change.name] = change.after;
  EXPECT_TRUE(external_ahrs_changes(now, 2).empty());
}

TEST(BoardSetup, LeavesWhatIsHiddenWhileExternalAhrsIsOff) {
  casd::ParamValues now = kStock;
  now.erase("EAHRS_RATE");
  now.erase("EAHRS_SENSORS");
  EXPECT_EQ(external_ahrs_changes(now, 2).size() + 1, external_ahrs_changes(kStock, 2).size());
  now["EAHRS_TYPE"] = 1;
  EXPECT_NE(test::refusal([&] { external_ahrs_changes(now, 2); }).find("EAHRS_RATE"),
            std::string::npos);
}

TEST(BoardSetup, NeedsAFirmwareWithExternalAhrs) {
  EXPECT_NE(test::refusal([] {
              external_ahrs_changes({{"SYS_AUTOSTART", 4001}}, 2);
            }).find("no parameter EAHRS_TYPE"),
            std::string::npos);
  EXPECT_NE(
      test::refusal([] { external_ahrs_changes(kStock, 7); }).find("no parameter SERIAL7_PROTOCOL"),
      std::string::npos);
}

TEST(BoardSetup, GivesBackWhatWasThere) {
  casd::ParamValues now = kStock;
  now["GPS1_TYPE"] = 21;
  const auto changes = restoring_changes("GPS1_TYPE 1\nEAHRS_TYPE 0\n", "f", now);
  EXPECT_EQ(changes, (std::vector<ParamChange>{{"GPS1_TYPE", 21, 1}}));
  const auto said = [](const std::string& text) {
    return test::refusal([&] { restoring_changes(text, "f", kStock); });
  };
  EXPECT_EQ(said("GPS1_TYPE 1\nGPS1_TYPE\n"), "f:2: is not NAME VALUE");
  EXPECT_EQ(said("GPS9_TYPE 1\n"), "f:1: the board has no parameter GPS9_TYPE");
}

}  // namespace
}  // namespace cas::hils
