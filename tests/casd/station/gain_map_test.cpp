// SPDX-License-Identifier: BSD-3-Clause
#include "casd/station/gain_map.hpp"
#include "tests/support/paths.hpp"

#include <gtest/gtest.h>

#include "base/config/config.hpp"
#include "base/error.hpp"

namespace cas::casd {
namespace {

GainMap parse(const std::string& text) {
  return GainMap::parse(base::ConfigNode::parse(text, "gains.yaml"));
}

TEST(GainMap, TheShippedFileNamesEveryLoopForBothAutopilots) {
  const GainMap map = GainMap::load(cas::test::source_dir() + "/config/gains.yaml");
  for (const Autopilot autopilot : {Autopilot::kPx4, Autopilot::kArduPilot}) {
    for (const char* loop : {"rollrate", "pitchrate", "yawrate", "roll", "pitch", "yaw", "position",
                             "velocity", "altitude", "climb"}) {
      EXPECT_NE(map.find(autopilot, loop), nullptr) << loop;
    }
  }
  EXPECT_EQ(map.find(Autopilot::kPx4, "climb")->p, "MPC_Z_VEL_P_ACC");
}

TEST(GainMap, HasNothingForAnotherAutopilot) {
  const GainMap map = GainMap::load(cas::test::source_dir() + "/config/gains.yaml");
  EXPECT_TRUE(map.loops(Autopilot::kOther).empty());
  EXPECT_EQ(map.find(Autopilot::kOther, "roll"), nullptr);
}

TEST(GainMap, RefusesAnUnknownKeyALongNameAndAnEmptyLoop) {
  EXPECT_THROW(parse("schema: 1\npx4:\n  roll: {p: A, q: B}\n"), base::ConfigError);
  EXPECT_THROW(parse("schema: 1\npx4:\n  roll: {p: ABCDEFGHIJKLMNOPQ}\n"), base::ConfigError);
  EXPECT_THROW(parse("schema: 1\npx4:\n  roll: {}\n"), base::ConfigError);
  EXPECT_THROW(parse("schema: 2\n"), base::ConfigError);
}

}  // namespace
}  // namespace cas::casd
