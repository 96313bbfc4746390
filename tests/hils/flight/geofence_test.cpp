// SPDX-License-Identifier: BSD-3-Clause
#include "hils/flight/geofence.hpp"

#include <gmock/gmock.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>

#include "base/rpc/client.hpp"
#include "hils/firmware/fence_keeper.hpp"
#include "hils/measure/fence_verdict.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using nlohmann::json;
using testing::HasSubstr;

Geofence fence(const std::string& text) {
  return parse_geofence(base::ConfigNode::parse(text, "test"));
}

TEST(Geofence, IsInEachAutopilotsOwnParameters) {
  const Geofence low = fence("{radius_m: 15, altitude_m: 30, action: hold, margin_m: 5}");
  EXPECT_EQ(fence_params("PX4", low),
            (FenceParams{{"GF_MAX_HOR_DIST", 15}, {"GF_MAX_VER_DIST", 30}, {"GF_ACTION", 2}}));
  EXPECT_EQ(fence_params("ArduPilot", low), (FenceParams{{"FENCE_TYPE", 3},
                                                         {"FENCE_RADIUS", 15},
                                                         {"FENCE_ALT_MAX", 30},
                                                         {"FENCE_ACTION", 4},
                                                         {"FENCE_ENABLE", 1}}));
  EXPECT_EQ(low.early_m, low.margin_m);
  EXPECT_EQ(fence("{radius_m: 15, action: hold, margin_m: 5, early_m: 10}").early_m, 10);
  const Geofence open = fence("{radius_m: 15, action: return, margin_m: 5}");
  EXPECT_EQ(fence_params("PX4", open),
            (FenceParams{{"GF_MAX_HOR_DIST", 15}, {"GF_MAX_VER_DIST", 0}, {"GF_ACTION", 3}}));
  EXPECT_EQ(fence_params("ArduPilot", open).front(),
            (std::pair<std::string, double>{"FENCE_TYPE", 2}));
  EXPECT_TRUE(fence_params("other", open).empty());
  EXPECT_EQ(fence_mode("PX4", FenceAction::kHold), "HOLD");
  EXPECT_EQ(fence_mode("ArduPilot", FenceAction::kReturn), "RTL");
}

TEST(GeofenceThatIsNone, IsRefused) {
  struct BadFence {
    const char* text;
    const char* sentence;
  };
  const BadFence rows[] = {
      {"{radius_m: 15, action: hold}", "margin_m"},
      {"{radius_m: 15, action: hold, margin_m: 5, early_m: 15}", "early_m"},
      {"{radius_m: 1, action: hold, margin_m: 5}", "radius_m"},
      {"{radius_m: 15, action: retrun, margin_m: 5}", "did you mean 'return'?"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.text);
    EXPECT_THAT(test::refusal([&] { fence(row.text); }), HasSubstr(row.sentence));
  }
}

TEST(Geofence, IsAnnouncedInTheWordsOfStockFirmware) {
  for (const char* text :
       {"Approaching on Geofence", "Maximum distance from home reached (15.00000)",
        "Maximum altitude above home reached (30.00000)",
        "Geofence: exceeding maximum distance to Home\t", "Fence Breached",
        "Circle fence breached"}) {
    EXPECT_TRUE(tells_of_breach(text)) << text;
  }
  for (const char* text : {"Geofence imported", "PreArm: Fence requires position",
                           "Fence breach cleared", "Offboard setpoints lost", ""}) {
    EXPECT_FALSE(tells_of_breach(text)) << text;
  }
}

/// A vehicle with parameters, behind casd.
struct Vehicle {
  std::map<std::string, double> params{{"A", 1}, {"B", 2.5}};
  std::string refuses{};
  std::vector<std::string> order{};

  json call(const std::string& method, const json& request) {
    const auto name = request.at("name").get<std::string>();
    if (method == "param.get") return {{"value", params.at(name)}};
    if (name == refuses) throw base::rpc::CallError(1, name + " is read only", "null");
    order.push_back(name);
    params[name] = request.at("value").get<double>();
    return json::object();
  }
};

class FenceKeeping : public testing::Test {
 protected:
  std::string kept() const {
    std::ifstream in(folder_.path() / "fence.params");
    return {std::istreambuf_iterator<char>(in), {}};
  }

  const cas::test::TemporaryFolder folder_;
  Vehicle vehicle_;
  FenceKeeper keeper_{
      [this](const std::string& method, json params) { return vehicle_.call(method, params); },
      folder_.path() / "fence.params"};
  const base::RunTime later_ = base::steady_now() + std::chrono::hours(1);
};

TEST_F(FenceKeeping, GivesBackWhatWasThereTheOtherWayRound) {
  EXPECT_EQ(keeper_.set({{"A", 7}, {"B", 8}}), std::nullopt);
  EXPECT_EQ(vehicle_.params.at("B"), 8);
  EXPECT_THAT(kept(), HasSubstr("B 2.5\nA 1\n"));
  EXPECT_EQ(keeper_.restore(later_), std::nullopt);
  EXPECT_EQ(vehicle_.params, (std::map<std::string, double>{{"A", 1}, {"B", 2.5}}));
  EXPECT_EQ(vehicle_.order, (std::vector<std::string>{"A", "B", "B", "A"}));
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "fence.params"));
  EXPECT_EQ(keeper_.restore(later_), std::nullopt) << "nothing is left to do";
  EXPECT_EQ(vehicle_.order.size(), 4U);
}

TEST_F(FenceKeeping, NamesWhatTheVehicleDoesNotTakeBack) {
  EXPECT_EQ(keeper_.set({{"A", 7}, {"B", 8}}), std::nullopt);
  vehicle_.refuses = "A";
  EXPECT_THAT(keeper_.restore(later_).value_or(""), HasSubstr("were not given back (A 1): "));
  EXPECT_FALSE(kept().empty()) << "for casctl param load";
}

TEST_F(FenceKeeping, DoesNotWaitForeverForAVehicle) {
  EXPECT_EQ(keeper_.set({{"A", 7}}), std::nullopt);
  const std::string said =
      keeper_.restore(base::steady_now() - std::chrono::seconds(1)).value_or("");
  EXPECT_THAT(said, HasSubstr("does not answer"));
}

TEST_F(FenceKeeping, GivesBackWhatItSetBeforeARefusal) {
  vehicle_.refuses = "B";
  EXPECT_THAT(keeper_.set({{"A", 7}, {"B", 8}}).value_or(""), HasSubstr("read only"));
  vehicle_.refuses.clear();
  EXPECT_EQ(keeper_.restore(later_), std::nullopt);
  EXPECT_EQ(vehicle_.params.at("A"), 1);
}

constexpr Geofence kFence{
    .radius_m = 15, .action = FenceAction::kHold, .margin_m = 5, .early_m = 3};

/// The missed limits of a flight, in one line.
std::string missed(const FenceFigures& figures, bool flew_there = true) {
  std::vector<Stage> flown(1);
  flown.front().step.kind = flew_there ? StepKind::kBreach : StepKind::kTakeoff;
  std::string all;
  for (const LimitCheck& check : fence_checks(kFence, figures, flown)) all += check.sentence;
  return all;
}

TEST(FenceVerdict, PassesWithinTheMarginOnly) {
  EXPECT_EQ(missed({.words = "Fence Breached", .farthest_m = 17, .highest_m = 5}), "");
  EXPECT_THAT(missed({.words = "Fence Breached", .farthest_m = 20.5}),
              HasSubstr("20.50 m; the limit is 20 m"));
  EXPECT_THAT(missed({.words = "Fence Breached"}), HasSubstr("not measured"));
}

TEST(FenceVerdict, FailsAFenceThatDidNotActOrSaidNothing) {
  EXPECT_THAT(missed({.farthest_m = 17}), HasSubstr("did not announce"));
  EXPECT_THAT(missed({.words = "Fence Breached", .farthest_m = 4}),
              HasSubstr("did not come within"));
  EXPECT_EQ(missed({.words = "Fence Breached", .farthest_m = 12.1}), "");
  EXPECT_THAT(missed({.words = "Fence Breached", .farthest_m = 11.9}),
              HasSubstr("within 3.0 m of its fence"));
  EXPECT_EQ(missed({.farthest_m = 4}, false), "") << "the flight ended before: not judged";
}

TEST(FenceVerdict, FailsWhereParametersStay) {
  EXPECT_EQ(missed({.words = "Fence Breached", .not_restored = "GF_ACTION", .farthest_m = 17}),
            "GF_ACTION");
}

TEST(FenceVerdict, CountsFromWhereTheVehicleStood) {
  FenceFigures figures;
  const std::vector<PoseSample> truth{{.pose = {.x_m = 5, .z_m = 0.2}},
                                      {.pose = {.x_m = 8, .y_m = 4, .z_m = 3.2}},
                                      {.pose = {.x_m = 5, .z_m = 0.2}}};
  add_reach(truth, figures);
  EXPECT_DOUBLE_EQ(*figures.farthest_m, 5);
  EXPECT_DOUBLE_EQ(*figures.highest_m, 3);
}

}  // namespace
}  // namespace cas::hils
