// SPDX-License-Identifier: BSD-3-Clause
// A day in a board's life, with stand-ins, in real time. The tests check events, not precision: on
// a busy machine a flight may have no verdict (3) and still be flown.
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <set>
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

constexpr base::Duration kFlightPatience = std::chrono::minutes(3);
constexpr int kInvalid = 3;
constexpr int kAbsent = 4;

const std::string kVehicle = source_dir() + "/config/vehicles/iris_paper.yaml";

std::string scenario(const std::string& vehicles) {
  return scenario_text(vehicles + "sensors: rtk\n",
                       "[arm, takeoff: {altitude_m: 2}, hold: {duration_s: 3, measure: true}, "
                       "land: {timeout_s: 60}]");
}

/// A whole flight, with a verdict or, on a busy machine, without; all that it leaves is there.
void expect_flown(const BoardShelf& shelf, const Ended& run, const std::string& out) {
  EXPECT_TRUE(run.code == 0 || run.code == kInvalid) << run.code << run.output;
  for (const char* file :
       {"summary.json", "junit.xml", "report.html", "flight.tlog", "boards.json"}) {
    EXPECT_FALSE(shelf.said(out + "/" + file).empty()) << file << run.output;
  }
  EXPECT_NE(run.output.find("has booted"), std::string::npos) << run.output;
}

/// Two boards that have booted, and a scenario for them.
std::string hop_of_two(const BoardShelf& shelf) {
  EXPECT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  EXPECT_EQ(shelf.board({"power", "on", "b"}).code, 0);
  const std::string vehicles = "vehicles:\n  - {name: left, vehicle: " + kVehicle +
                               ", pose: {x_m: 0, y_m: 0}}\n  - {name: right, vehicle: " + kVehicle +
                               ", pose: {x_m: 3, y_m: 0}}\n";
  return shelf.folder.write("two.yaml", scenario(vehicles)).string();
}

std::set<std::string> steps_of(const json& vehicle) {
  std::set<std::string> steps;
  for (const json& stage : vehicle.at("stages")) steps.insert(stage.at("step").get<std::string>());
  return steps;
}

/// Whether the stand-in flies.
bool is_in_air(const BoardShelf& shelf, const std::string& board) {
  const json status = json::parse(shelf.status(board), nullptr, false);
  return status.is_object() && status.value("landed", "") == "in_air";
}

TEST(BoardDay, LockFlashBootFlyCrashPowerCycleFlyAgain) {
  const BoardShelf shelf({"a firmware: 1.15"});
  const std::string hop =
      shelf.folder.write("hop.yaml", scenario("vehicle: " + kVehicle + "\n")).string();

  // In the morning a user locks the board, and all others see it.
  const Ended lock = shelf.board({"lock", "a", "--for", "today"});
  ASSERT_EQ(lock.code, 0) << lock.output;
  const std::string ticket = lock.output.substr(0, lock.output.find('\n'));
  EXPECT_NE(shelf.board({"list"}).output.find("hils board lock: today"), std::string::npos);

  // It is flashed, and boots.
  const std::string firmware = shelf.folder.write("new.px4", "-").string();
  ASSERT_THAT(shelf.board({"flash", "a", firmware}, {ticket}),
              EndedWith(0, "has booted: PX4 1.15.0"));

  // It flies, and its firmware dies in the air.
  const auto first =
      shelf.start({"run", hop, "--fcu", "a", "--out", (shelf.folder / "first").string()}, {ticket});
  ASSERT_TRUE(wait_until([&] { return is_in_air(shelf, "a"); }, kFlightPatience))
      << first->output();
  const Ended armed = shelf.board({"reboot", "a"});
  EXPECT_EQ(armed.code, 7) << "held by the day's lock: " << armed.output;
  shelf.crash("a");
  const int crashed = first->wait_exit(kFlightPatience).value_or(-1);
  EXPECT_EQ(crashed, 1) << first->output();
  EXPECT_NE(first->output().find("board 'a' is not there"), std::string::npos) << first->output();
  EXPECT_NE(first->output().find("; it was there when the run began"), std::string::npos);
  EXPECT_NE(shelf.said("first/junit.xml").find("<failure message=\"board &apos;a&apos; is not"),
            std::string::npos);

  // It cannot be flown.
  EXPECT_THAT(
      shelf.hils({"run", hop, "--fcu", "a", "--out", (shelf.folder / "gone").string()}, {ticket}),
      EndedWith(kAbsent));

  // Its power goes off and on, and it flies again.
  ASSERT_THAT(shelf.board({"power", "cycle", "a"}, {ticket}), EndedWith(0));
  const auto second = shelf.start(
      {"run", hop, "--fcu", "a", "--out", (shelf.folder / "second").string()}, {ticket});
  const int flown = second->wait_exit(kFlightPatience).value_or(-1);
  expect_flown(shelf, {flown, second->output()}, "second");
  EXPECT_EQ(steps_of(vehicle_summary(shelf.folder / "second")),
            (std::set<std::string>{"arm", "takeoff", "hold", "land"}));
  const json boards = json::parse(shelf.said("second/boards.json"));
  EXPECT_EQ(boards.at(0).at("firmware"), "1.15.0");

  // In the evening it is free.
  EXPECT_EQ(shelf.board({"unlock", "a"}).code, 0);
  EXPECT_NE(shelf.board({"list"}).output.find("it is free"), std::string::npos);
}

TEST(BoardDay, ABoardWhoseCableIsDrawnInTheAirFailsTheFlight) {
  const BoardShelf shelf;
  const std::string hop =
      shelf.folder.write("hop.yaml", scenario("vehicle: " + kVehicle + "\n")).string();
  ASSERT_EQ(shelf.board({"power", "on", "a"}).code, 0);
  const auto run =
      shelf.start({"run", hop, "--fcu", "a", "--out", (shelf.folder / "out").string()});
  ASSERT_TRUE(wait_until([&] { return is_in_air(shelf, "a"); }, kFlightPatience)) << run->output();
  EXPECT_THAT(shelf.board({"reboot", "a"}), EndedWith(7, ": hils run "));
  ASSERT_TRUE(shelf.unplug("a"));
  const int code = run->wait_exit(kFlightPatience).value_or(-1);
  EXPECT_EQ(code, 1) << run->output();
  EXPECT_NE(run->output().find("board 'a' is not there"), std::string::npos) << run->output();
}

TEST(BoardDay, BoardsWithEachOthersSystemIdsDoNotFly) {
  const BoardShelf shelf({"a", "b"});
  const std::string hop = hop_of_two(shelf);
  EXPECT_THAT(
      shelf.hils({"run", hop, "--fcu", "right=a", "--fcu", "left=b", "--out",
                  (shelf.folder / "out").string()}),
      EndedWith(kInvalid, "system 1 is heard on link ", "the boards have each other's system ids"));
}

TEST(BoardDay, TwoBoardsFlyInOneRun) {
  const BoardShelf shelf({"a", "b"});
  const std::string hop = hop_of_two(shelf);
  const auto run = shelf.start({"run", hop, "--fcu", "right=b", "--fcu", "left=a", "--out",
                                (shelf.folder / "out").string()});
  const int code = run->wait_exit(kFlightPatience).value_or(-1);
  expect_flown(shelf, {code, run->output()}, "out");
  const json summary = json::parse(shelf.said("out/summary.json"));
  for (const json& vehicle : summary.at("vehicles")) {
    EXPECT_EQ(vehicle.at("from_device"), true);
    EXPECT_TRUE(steps_of(vehicle).contains("land")) << vehicle.dump();
  }
  EXPECT_EQ(json::parse(shelf.said("out/boards.json")).at(1).at("board"), "b");
}

}  // namespace
}  // namespace cas::test
