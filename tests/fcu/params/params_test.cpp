// SPDX-License-Identifier: BSD-3-Clause
#include "fcu/params/params.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "base/error.hpp"
#include "fcu/params/param_file.hpp"
#include "fcu/params/param_table.hpp"
#include "tests/support/paths.hpp"

namespace cas::fcu {
namespace {

base::Vehicle paper_iris() {
  return base::Vehicle::load(cas::test::source_dir() + "/config/vehicles/iris_paper.yaml");
}

TEST(Params, AreSortedUniqueAndFitTheWire) {
  const ParamStore store(paper_iris());
  std::set<std::string> names;
  for (std::size_t i = 0; i < store.size(); ++i) {
    const Param& p = store.at(i);
    EXPECT_LE(p.name.size(), 16U) << p.name;
    EXPECT_TRUE(names.insert(p.name).second) << p.name;
    EXPECT_LE(p.low, p.value + 1e-6) << p.name;
    EXPECT_GE(p.high, p.value - 1e-6) << p.name;
    if (i > 0) {
      EXPECT_LT(store.at(i - 1).name, p.name);
    }
    EXPECT_EQ(store.index_of(p.name), i);
  }
}

TEST(Params, IntegersTravelBytewise) {
  ParamStore store(paper_iris());
  ASSERT_EQ(store.set("NAV_DLL_ACT", 3), ParamSetResult::kOk);
  const Param& p = store.at(*store.index_of("NAV_DLL_ACT"));
  EXPECT_EQ(std::bit_cast<std::int32_t>(ParamStore::to_wire(p)), 3);
  EXPECT_EQ(ParamStore::from_wire(ParamType::kInt32, std::bit_cast<float>(std::int32_t{-7})), -7);
  EXPECT_EQ(ParamStore::from_wire(ParamType::kReal32, 0.25F), 0.25);
}

TEST(Params, RefuseWhatIsOutOfRangeOrNoNumber) {
  ParamStore store(paper_iris());
  const double before = store.get("MC_ROLL_P");
  EXPECT_EQ(store.set("MC_ROLL_P", 1e6), ParamSetResult::kOutOfRange);
  EXPECT_EQ(store.set("MC_ROLL_P", NAN), ParamSetResult::kNotANumber);
  EXPECT_EQ(store.set("NO_SUCH", 1), ParamSetResult::kUnknown);
  EXPECT_EQ(store.get("MC_ROLL_P"), before);
}

TEST(Params, CountEachChangeOnce) {
  ParamStore store(paper_iris());
  const auto before = store.revision();
  store.set("MC_ROLL_P", 5);
  store.set("MC_ROLL_P", 5);
  EXPECT_EQ(store.revision(), before + 1);
}

TEST(Params, WhatIsSavedIsWhatDiffersFromTheStart) {
  ParamStore store(paper_iris());
  const double initial = store.get("MC_ROLL_P");
  store.set("MC_ROLL_P", 6);  // by the configuration
  store.mark_start();
  EXPECT_EQ(store.changed_text(), "");
  store.set("MC_ROLL_P", initial);  // back to the default is a change too
  store.set("CAL_GYRO0_ID", 2147483647);
  EXPECT_EQ(store.changed_text(), "CAL_GYRO0_ID 2147483647\nMC_ROLL_P 7\n");
}

TEST(Params, HashChangesWithAnyValue) {
  ParamStore store(paper_iris());
  const auto before = store.hash();
  store.set("MPC_XY_P", 1.25);
  EXPECT_NE(store.hash(), before);
}

TEST(Params, ReachTheGainsTheyName) {
  ParamStore store(paper_iris());
  store.set("MC_PITCHRATE_D", 0.004);
  store.set("MC_PITCHRATE_K", 2);
  store.set("MPC_Z_VEL_I_ACC", 1.5);
  const ControlParams p = read_settings(store).control;
  EXPECT_NEAR(p.rate_pitch.d, 0.008, 1e-6);
  EXPECT_NEAR(p.z_velocity.i, 1.5, 1e-6);
}

TEST(Params, HaveTheDefaultsOfTheSettings) {
  const Settings defaults;
  const Settings settings = read_settings(ParamStore(paper_iris()));
  EXPECT_FLOAT_EQ(static_cast<float>(settings.flight.land_tilt_rad),
                  static_cast<float>(defaults.flight.land_tilt_rad));
  EXPECT_EQ(settings.flight.battery_action, defaults.flight.battery_action);
  EXPECT_TRUE(settings.flight.termination_enabled);
  EXPECT_EQ(settings.battery.drain_s, defaults.battery.drain_s);
  EXPECT_EQ(settings.estimator.mag_gate, defaults.estimator.mag_gate);
}

TEST(Params, AreReadInTheUnitsOfTheSettings) {
  ParamStore store(paper_iris());
  store.set("MPC_TILTMAX_AIR", 30);
  store.set("EKF2_GPS_DELAY", 120);
  store.set("CBRK_FLIGHTTERM", 121212);
  const Settings settings = read_settings(store);
  EXPECT_DOUBLE_EQ(settings.control.tilt_limit_rad, M_PI / 6);
  EXPECT_DOUBLE_EQ(settings.estimator.gps_delay_s, 0.12);
  EXPECT_FALSE(settings.flight.termination_enabled);
}

TEST(Params, OfRotorsCountWhereTheAnswerIsByMotor) {
  ParamStore store(base::Vehicle::load(cas::test::source_dir() + "/config/vehicles/hexa_x.yaml"));
  ASSERT_EQ(store.set("CAS_ROT_LOST", 4), ParamSetResult::kOk);
  EXPECT_EQ(read_settings(store).control.rotors_lost, 0U);
  store.set("CAS_HIL_ACT", 1);
  EXPECT_EQ(read_settings(store).control.rotors_lost, 4U);
  EXPECT_TRUE(read_settings(store).control.detect_rotor_loss);
}

// The file.

class ParamFileTest : public testing::Test {
 protected:
  ParamFileTest() { std::filesystem::create_directories(folder_); }
  ~ParamFileTest() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_ = std::filesystem::temp_directory_path() /
                                  ("cas_param_file_" + std::to_string(::getpid()) + "_" +
                                   testing::UnitTest::GetInstance()->current_test_info()->name());
  std::filesystem::path path_ = folder_ / "params";
};

TEST_F(ParamFileTest, GivesBackWhatWasSaved) {
  const ParamFile file(path_);
  EXPECT_TRUE(file.load().empty());
  ASSERT_TRUE(file.save("MC_ROLL_P 5.5\nNAV_DLL_ACT 2\n"));
  const auto entries = file.load();
  ASSERT_EQ(entries.size(), 2U);
  EXPECT_EQ(entries[0].name, "MC_ROLL_P");
  EXPECT_EQ(entries[0].value, 5.5);
}

TEST_F(ParamFileTest, ATornWriteLosesNothing) {
  const ParamFile file(path_);
  ASSERT_TRUE(file.save("MC_ROLL_P 5\n"));
  ASSERT_TRUE(file.save("MC_ROLL_P 6\n"));
  const auto whole = std::filesystem::file_size(path_);
  for (std::uintmax_t size = 0; size < whole; ++size) {
    ASSERT_TRUE(file.save("MC_ROLL_P 5\n"));
    ASSERT_TRUE(file.save("MC_ROLL_P 6\n"));
    std::filesystem::resize_file(path_, size);
    const auto entries = file.load();
    ASSERT_EQ(entries.size(), 1U) << size;
    EXPECT_EQ(entries[0].value, 5) << size;
  }
}

TEST_F(ParamFileTest, SaysSoWhenNothingIntactIsLeft) {
  std::ofstream(path_) << "MC_ROLL_P 5\n";
  EXPECT_THROW(ParamFile(path_).load(), base::ConfigError);
}

}  // namespace
}  // namespace cas::fcu
