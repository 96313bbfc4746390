// SPDX-License-Identifier: BSD-3-Clause
#include "base/config/install_paths.hpp"

#include <gtest/gtest.h>

#include "base/error.hpp"
#include "tests/base/config/scoped_environment.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::base {
namespace {

namespace fs = std::filesystem;

TEST(InstallPaths, TheBuildTreeFindsTheShippedConfiguration) {
  const ScopedEnvironment no_path("CAS_CONFIG_PATH", nullptr);
  ASSERT_FALSE(config_dirs().empty());
  EXPECT_TRUE(fs::equivalent(config_dirs().front(), fs::path(cas::test::source_dir()) / "config"));
  EXPECT_TRUE(fs::exists(find_config("vehicles/iris_paper.yaml")));
}

TEST(InstallPaths, TheEnvironmentComesFirst) {
  const test::TemporaryFolder folder;
  folder.write("vehicles/iris_paper.yaml", "");
  const std::string path = "/nowhere::" + folder.path().string();
  const ScopedEnvironment variable("CAS_CONFIG_PATH", path.c_str());
  EXPECT_EQ(find_config("vehicles/iris_paper.yaml"),
            fs::canonical(folder.path()) / "vehicles/iris_paper.yaml");
  EXPECT_TRUE(fs::exists(find_config("vehicles/iris_px4.yaml")));  // falls through
}

TEST(InstallPaths, AnExistingFileIsTakenAsItStands) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.write("mine.yaml", "");
  EXPECT_EQ(find_config(file), file);
}

TEST(InstallPaths, AShippedFileIsNeverThatOfTheWorkingFolder) {
  const test::TemporaryFolder folder;
  folder.write("frames.yaml", "of: somebody\n");
  const fs::path before = fs::current_path();
  fs::current_path(folder.path());
  EXPECT_FALSE(fs::equivalent(shipped_config("frames.yaml"), folder.path() / "frames.yaml"));
  EXPECT_TRUE(fs::equivalent(find_config("frames.yaml"), folder.path() / "frames.yaml"));
  EXPECT_THROW(shipped_config("none.yaml"), ConfigError);
  fs::current_path(before);
}

TEST(InstallPaths, AMissingFileSaysWhereItWasSearched) {
  const test::TemporaryFolder folder;
  const ScopedEnvironment variable("CAS_CONFIG_PATH", folder.path().c_str());
  const std::string said = test::refusal([] { find_config("vehicles/none.yaml"); });
  EXPECT_NE(said.find(folder.path().filename()), std::string::npos) << said;
  EXPECT_THROW(find_config("/nowhere/x.yaml"), ConfigError);
}

TEST(InstallPaths, AMissingFileIsToldTheNearestShippedOne) {
  const ScopedEnvironment no_path("CAS_CONFIG_PATH", nullptr);
  for (const char* name : {"hoover.yaml", "hover.yaml", "scenario/hover.yaml", "hover"}) {
    const std::string text = test::refusal([&] { find_config(name); });
    EXPECT_NE(text.find("no such file here or in "), std::string::npos) << name << ": " << text;
    EXPECT_NE(text.find("did you mean scenarios/hover.yaml?"), std::string::npos)
        << name << ": " << text;
  }
}

TEST(InstallPaths, OfSeveralFilesOfANameTheOneOfAFolderThatWasNamedIsMeant) {
  const ScopedEnvironment no_path("CAS_CONFIG_PATH", nullptr);
  const std::string text = test::refusal([] { find_config("../vehicles/sub/hexa_x.yaml"); });
  EXPECT_NE(text.find("did you mean vehicles/hexa_x.yaml?"), std::string::npos) << text;
}

ConfigNode vehicle_key(const fs::path& file) { return ConfigNode::load(file).at("vehicle"); }

TEST(InstallPaths, AKeyNamesAFileBesideItsOwnBeforeAShippedOne) {
  const test::TemporaryFolder folder;
  const fs::path file = folder.write("mine.yaml", "vehicle: vehicles/iris_paper.yaml\n");
  const fs::path shipped = fs::path(cas::test::source_dir()) / "config/vehicles/iris_paper.yaml";
  EXPECT_TRUE(fs::equivalent(find_config(vehicle_key(file)), shipped));
  const fs::path own = folder.write("vehicles/iris_paper.yaml", "");
  EXPECT_EQ(find_config(vehicle_key(file)), own);
}

TEST(InstallPaths, ACopyOfAShippedFileFindsWhatItNames) {
  const test::TemporaryFolder folder;
  const fs::path copy = folder.write("a/mine.yaml", "vehicle: ../vehicles/iris_paper.yaml\n");
  EXPECT_EQ(find_config(vehicle_key(copy)).filename(), "iris_paper.yaml");
}

TEST(InstallPaths, AKeyThatNamesNoFileSaysWhereItWasSearched) {
  const test::TemporaryFolder folder;
  const ScopedEnvironment variable("CAS_CONFIG_PATH", folder.path().c_str());
  const fs::path file = folder.write("a/mine.yaml", "schema: 1\nvehicle: vehicles/none.yaml\n");
  const std::string text = test::refusal([&] { find_config(vehicle_key(file)); });
  EXPECT_EQ(text.rfind(file.string() + ":2: vehicle: there is no file 'vehicles/none.yaml'", 0), 0U)
      << text;
  EXPECT_NE(text.find((folder.path() / "a/vehicles").string()), std::string::npos) << text;
  EXPECT_NE(text.find("below " + fs::canonical(folder.path()).string()), std::string::npos) << text;
}

TEST(InstallPaths, AKeyThatNamesNoFileIsToldTheNearestOne) {
  const ScopedEnvironment no_path("CAS_CONFIG_PATH", nullptr);
  const test::TemporaryFolder folder;
  folder.write("a/tower.sdf", "");
  const auto meant = [&folder](const std::string& text) {
    return test::refusal(
        [&] { find_config(ConfigNode::load(folder.write("a/mine.yaml", text)).at("file")); });
  };
  const std::string shipped = meant("file: ../vehicles/iris_papre.yaml\n");
  EXPECT_NE(shipped.find("; did you mean vehicles/iris_paper.yaml?"), std::string::npos) << shipped;
  const std::string own = meant("file: twoer.sdf\n");
  EXPECT_NE(own.find("; did you mean tower.sdf?"), std::string::npos) << own;
}

TEST(InstallPaths, NeitherAFolderNorNothingIsAFile) {
  for (const char* name : {"vehicles", ".", "..", "''"}) {
    const ConfigNode root = ConfigNode::parse(std::string("vehicle: ") + name, "mine.yaml");
    EXPECT_THROW(find_config(root.at("vehicle")), ConfigError) << name;
  }
}

TEST(InstallPaths, PluginFoldersOfTheEnvironmentComeFirstAndOnce) {
  const test::TemporaryFolder folder;
  const std::string path = folder.path().string() + ":" + folder.path().string() + ":/nowhere";
  const ScopedEnvironment variable("CAS_PLUGIN_PATH", path.c_str());
  const std::vector<fs::path> folders = plugin_dirs();
  ASSERT_FALSE(folders.empty());
  EXPECT_EQ(folders.front(), fs::canonical(folder.path()));
  EXPECT_EQ(std::count(folders.begin(), folders.end(), folders.front()), 1);
}

}  // namespace
}  // namespace cas::base
