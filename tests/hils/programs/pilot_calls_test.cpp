// SPDX-License-Identifier: BSD-3-Clause
#include "hils/programs/pilot_calls.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace cas::hils {
namespace {

TEST(ToReport, KeepsAReasonThatArduPilotRepeatsEvery30sWhileItCannotBeArmed) {
  const std::string reason = "PreArm: Proximity 25 deg, 0.53m (want > 0.6m)";
  nlohmann::json state{
      {"statustexts", {{{"severity", "critical"}, {"text", reason}, {"age_s", 29}}}}};
  EXPECT_EQ(to_report(state).warning, "");
  state["position_lacks"] = "its arming checks fail";
  EXPECT_EQ(to_report(state).warning, reason);
  state["statustexts"][0]["age_s"] = 32;
  EXPECT_EQ(to_report(state).warning, "");
}

}  // namespace
}  // namespace cas::hils
