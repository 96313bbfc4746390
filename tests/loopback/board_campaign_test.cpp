// SPDX-License-Identifier: BSD-3-Clause
// A campaign on a stand-in for a board, in real time. On a busy machine a flight may have no
// verdict, and still be flown.
#include <gtest/gtest.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/loopback/board_shelf.hpp"
#include "tests/support/ended_with.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/vehicle_summary.hpp"
#include "tests/support/wait_until.hpp"

namespace cas::test {
namespace {

using nlohmann::json;

constexpr base::Duration kCampaignPatience = std::chrono::minutes(5);
constexpr int kInvalid = 3;

constexpr const char* kCampaign = R"(
schema: 1
name: one
scenario: hop.yaml
phases: {hover: phase == hover and height > 1}
failures:
  - {failure: baro_door, with: {pa: -2}, expect: [no_crash]}
  - {failure: casd_reloaded, expect: [no_crash]}
  - {failure: line_cut, expect: [no_crash]}
)";

TEST(BoardCampaignFlight, FliesEachFailureOnABoardThatItHoldsAndRestarts) {
  const BoardShelf shelf({"a log: {folder: files}"});
  shelf.folder.write("logs/2026-03-01/12_00_00.ulg", "a log");
  shelf.folder.write(
      "hop.yaml",
      scenario_text("vehicle: " + source_dir() + "/config/vehicles/iris_paper.yaml\nsensors: rtk\n",
                    "[arm, takeoff: {altitude_m: 2}, hold: {name: hover, duration_s: 3, measure: "
                    "true}, land: {timeout_s: 60}]"));
  const std::string file = shelf.folder.write("one.yaml", kCampaign).string();
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  const std::string first = shelf.said("a.pid");

  const auto campaign =
      shelf.start({"campaign", file, "--fcu", "a", "--out", (shelf.folder / "out").string()});
  ASSERT_TRUE(wait_until([&] {
    return json::parse(shelf.board({"list", "--json"}).output).at(0).at("held").get<bool>();
  })) << campaign->output();
  EXPECT_THAT(shelf.board({"reboot", "a"}), EndedWith(7, ": hils campaign "));
  const int code = campaign->wait_exit(kCampaignPatience).value_or(-1);
  EXPECT_TRUE(code == 0 || code == kInvalid) << code << campaign->output();
  EXPECT_NE(shelf.said("a.pid"), first) << "the power hooks restart it before the second flight";

  const json results = json::parse(shelf.said("out/results.json"));
  ASSERT_EQ(results.at("cells").size(), 2U) << results;
  EXPECT_EQ(results.at("not_flown"), json::array({"line_cut"}));
  for (const json& cell : results.at("cells")) {
    EXPECT_TRUE(cell.at("verdict") == "as expected" || cell.at("verdict") == "no verdict") << cell;
  }
  for (const char* row : {"row_1", "row_2", "row_3"}) {
    const std::string folder = std::string("out/again/") + row;
    EXPECT_FALSE(shelf.said(folder + "/summary.json").empty()) << row << campaign->output();
    EXPECT_EQ(shelf.said(folder + "/board.ulg"), "a log") << row;
  }
  const json summary = vehicle_summary(shelf.folder / "out/again/row_2");
  ASSERT_EQ(summary.at("faults").size(), 1U) << summary.dump();
  EXPECT_NE(shelf.said("out/again/row_2/run/casd.log").find("casd.reload"), std::string::npos);
}

}  // namespace
}  // namespace cas::test
