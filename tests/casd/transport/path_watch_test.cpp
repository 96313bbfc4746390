// SPDX-License-Identifier: BSD-3-Clause
#include "casd/transport/path_watch.hpp"

#include <gtest/gtest.h>

#include "tests/support/temporary_folder.hpp"

namespace cas::casd::test {
namespace {

using cas::test::TemporaryFolder;

TEST(PathWatch, TellsWhatComesWhileItLooksInVain) {
  const TemporaryFolder folder;
  PathWatch watch(folder / "fcu");
  EXPECT_FALSE(watch.found_by([&] {
    // As udev does it: the node is made under another name. The look was just too early.
    folder.write("fcu.new", "");
    std::filesystem::rename(folder / "fcu.new", folder / "fcu");
    return false;
  }));
  EXPECT_TRUE(watch.take_changes());
  EXPECT_FALSE(watch.take_changes());
}

TEST(PathWatch, TellsFoldersThatComeOneInTheOther) {
  const TemporaryFolder folder;
  PathWatch watch(folder / "serial/by-id/fcu");
  EXPECT_FALSE(watch.found_by([] { return false; }));
  std::filesystem::create_directories(folder / "serial/by-id");
  EXPECT_TRUE(watch.take_changes());
  EXPECT_FALSE(watch.found_by([] { return false; }));
  folder.write("serial/by-id/fcu", "");
  EXPECT_TRUE(watch.take_changes());
}

TEST(PathWatch, EndsWhenTheDeviceIsFound) {
  const TemporaryFolder folder;
  PathWatch watch(folder / "fcu");
  EXPECT_TRUE(watch.found_by([] { return true; }));
  EXPECT_FALSE(watch.descriptor());
  EXPECT_FALSE(watch.take_changes());
}

}  // namespace
}  // namespace cas::casd::test
