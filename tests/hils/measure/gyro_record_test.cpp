// SPDX-License-Identifier: BSD-3-Clause
#include "hils/measure/gyro_record.hpp"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <string>

#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

class GyroRecord : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& rows) const {
    return folder_.write("imu.csv",
                         "time_s,gyro_x_rad_s,gyro_y_rad_s,gyro_z_rad_s,accel_x_m_s2\n" + rows);
  }

  test::TemporaryFolder folder_;
};

TEST_F(GyroRecord, IsReadInItsColumns) {
  const auto samples = read_gyro(write("0.002,0.1,-0.2,0.3,9.8\n0.004,1e-3,0,0,9.8\n"));
  ASSERT_EQ(samples.size(), 2U);
  EXPECT_EQ(samples[0].time_us, 2000);
  EXPECT_EQ(samples[0].rate_rad_s, (std::array{0.1, -0.2, 0.3}));
  EXPECT_EQ(samples[1].time_us, 4000);
  EXPECT_EQ(samples[1].rate_rad_s[0], 1e-3);
}

TEST_F(GyroRecord, NamesTheLineThatIsNoSample) {
  const std::filesystem::path file = write("0.002,0.1,-0.2,0.3,9.8\n0.004,0.1\n");
  EXPECT_EQ(test::refusal([&] { read_gyro(file); }), file.string() + ":3: not a row of imu.csv");
}

TEST_F(GyroRecord, IsEmptyWhereNothingWasRecorded) {
  EXPECT_TRUE(read_gyro(folder_.path() / "none.csv").empty());
}

}  // namespace
}  // namespace cas::hils
