// SPDX-License-Identifier: BSD-3-Clause
// Somebody who may write into a folder of results lays symlinks there: no flight follows one.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "base/error.hpp"
#include "base/os/result_file.hpp"
#include "hils/campaign/board_flight.hpp"
#include "hils/sweep/flight_pool.hpp"
#include "hils/sweep/row_again.hpp"
#include "hils/sweep/row_flight.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

namespace fs = std::filesystem;

class RowFolder : public testing::Test {
 protected:
  RowFolder() {
    fs::create_directories(out);
    fs::create_directories(elsewhere / "row_1/run");
    fs::copy_file(test::source_dir() + "/config/scenarios/hover.yaml", out / "scenario.yaml");
  }
  void lay_symlink(const char* name) const { fs::create_directory_symlink(elsewhere, out / name); }
  /// Files that were laid there, or deleted, by whoever followed the symlink.
  void expect_untouched() const {
    EXPECT_EQ(std::distance(fs::recursive_directory_iterator(elsewhere), {}), 2);
  }

  const test::TemporaryFolder folder;
  const fs::path out = folder / "out";
  const fs::path elsewhere = folder / "elsewhere";
};

TEST_F(RowFolder, OfACampaignIsNotBehindASymlink) {
  lay_symlink("again");
  const fs::path task = folder / "task";
  fs::create_directories(task);
  RowTask{.row = 1, .scenario = out / "scenario.yaml", .study_folder = out}.save(task /
                                                                                 "task.json");
  fly_campaign_row(task);
  EXPECT_NE(test::TemporaryFolder::read(task / "result.json").find("again"), std::string::npos);
  expect_untouched();
}

TEST_F(RowFolder, OfARowFlownAgainIsNotBehindASymlink) {
  lay_symlink("again");
  SweepFolder sweep;
  sweep.path = out;
  sweep.table.rows.push_back({.row = 1});
  EXPECT_THROW(write_row_again(sweep, 1), base::ConfigError);
  expect_untouched();
}

TEST_F(RowFolder, OfAFlightUnderWayIsNotBehindASymlink) {
  lay_symlink("work");
  EXPECT_THROW(FlightPool({out, "work/row_1"}, 1), base::ConfigError);
  expect_untouched();
}

}  // namespace
}  // namespace cas::hils
