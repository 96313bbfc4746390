// SPDX-License-Identifier: BSD-3-Clause
#include "base/install_paths.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "tests/base/scoped_environment.hpp"
#include "tests/base/temporary_folder.hpp"

namespace cas::base {
namespace {

namespace fs = std::filesystem;

TEST(InstallPaths, TheBuildTreeFindsTheShippedConfiguration) {
  const ScopedEnvironment no_path("CAS_CONFIG_PATH", nullptr);
  ASSERT_FALSE(config_dirs().empty());
  EXPECT_TRUE(fs::equivalent(config_dirs().front(), fs::path(CAS_SOURCE_DIR) / "config"));
  EXPECT_TRUE(fs::exists(find_config("vehicles/iris_paper.yaml")));
}

TEST(InstallPaths, TheEnvironmentComesFirst) {
  const TemporaryFolder folder;
  folder.write("vehicles/iris_paper.yaml", "");
  const std::string path = "/nowhere::" + folder.path().string();
  const ScopedEnvironment variable("CAS_CONFIG_PATH", path.c_str());
  EXPECT_EQ(find_config("vehicles/iris_paper.yaml"),
            fs::canonical(folder.path()) / "vehicles/iris_paper.yaml");
  EXPECT_TRUE(fs::exists(find_config("vehicles/iris_px4.yaml")));  // falls through
}

TEST(InstallPaths, AnExistingFileIsTakenAsItStands) {
  const TemporaryFolder folder;
  const fs::path file = folder.write("mine.yaml", "");
  EXPECT_EQ(find_config(file), file);
}

TEST(InstallPaths, AMissingFileSaysWhereItWasSearched) {
  const TemporaryFolder folder;
  const ScopedEnvironment variable("CAS_CONFIG_PATH", folder.path().c_str());
  try {
    find_config("vehicles/none.yaml");
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find(folder.path().filename()), std::string::npos);
  }
  EXPECT_THROW(find_config("/nowhere/x.yaml"), ConfigError);
}

TEST(InstallPaths, PluginFoldersOfTheEnvironmentComeFirstAndOnce) {
  const TemporaryFolder folder;
  const std::string path = folder.path().string() + ":" + folder.path().string() + ":/nowhere";
  const ScopedEnvironment variable("CAS_PLUGIN_PATH", path.c_str());
  const std::vector<fs::path> folders = plugin_dirs();
  ASSERT_FALSE(folders.empty());
  EXPECT_EQ(folders.front(), fs::canonical(folder.path()));
  EXPECT_EQ(std::count(folders.begin(), folders.end(), folders.front()), 1);
}

}  // namespace
}  // namespace cas::base
