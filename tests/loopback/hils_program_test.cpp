// SPDX-License-Identifier: BSD-3-Clause
// The command line of hils, up to where a flight would begin.
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

constexpr int kExitUsage = 2;

/// What `hils run` says against these arguments.
std::string refusal(const std::vector<std::string>& arguments) {
  std::vector<std::string> command{cas::test::binary_dir() + "/bin/hils", "run"};
  command.insert(command.end(), arguments.begin(), arguments.end());
  ChildProcess hils(command);
  EXPECT_EQ(hils.wait_exit(), kExitUsage) << hils.output();
  return hils.output();
}

TEST(HilsProgram, TakesTheLastOfTwoFoldersForTheResults) {
  const TemporaryFolder folder;
  const std::string text =
      refusal({"no_such_scenario.yaml", "--out", folder / "first", "--out", folder / "second"});
  EXPECT_NE(text.find("no_such_scenario.yaml"), std::string::npos) << text;
  EXPECT_EQ(text.find("--out"), std::string::npos) << text;
}

TEST(HilsProgram, RefusesANegativeSeed) {
  const TemporaryFolder folder;
  const std::string text =
      refusal({"no_such_scenario.yaml", "--out", folder / "out", "--seed", "-1"});
  EXPECT_NE(text.find("'-1' is not a whole number"), std::string::npos) << text;
}

TEST(HilsProgram, LetsAGroundStationJoinInRealTimeAlone) {
  const TemporaryFolder folder;
  const std::string hover = source_dir() + "/config/scenarios/hover.yaml";
  const auto refused = [&](const std::string& endpoint, const std::vector<std::string>& further) {
    std::vector<std::string> arguments{hover, "--out", folder / "out", "--gcs", endpoint};
    arguments.insert(arguments.end(), further.begin(), further.end());
    return refusal(arguments);
  };
  const std::string sentence = "a ground station cannot join a run on the virtual clock";
  EXPECT_NE(refused("udp:14550", {"--virtual"}).find(sentence), std::string::npos);
  EXPECT_NE(refused("udp:14550", {"--architecture", "direct"}).find(sentence), std::string::npos);
  EXPECT_NE(refused("udp:14550", {"--lockstep"})
                .find("a ground station has a clock of its own and no place in lockstep"),
            std::string::npos);
  EXPECT_NE(refused("14550", {}).find("--gcs '14550' is none of udp:PORT"), std::string::npos);
  EXPECT_NE(refused("udp:0", {}).find("no port from 1 to 65535"), std::string::npos);
}

}  // namespace
}  // namespace cas::test
