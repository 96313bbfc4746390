// SPDX-License-Identifier: BSD-3-Clause
#include "hils/runs/run_story.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>

#include "hils/replay/replay_page.hpp"
#include "hils/runs/run_folder.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace {

using namespace cas::hils;
using Json = nlohmann::json;

/// Flies into a wall after a fault, and is told as hils tells it: limits and step beside incidents.
Json crashed() {
  return Json::parse(R"({
    "schema": 2, "scenario": "yard", "architecture": "direct", "seed": 4, "valid": true, "passed": false, "virtual_clock": true, "simulated_s": 60.0,
    "vehicles": [{
      "name": "hexa", "valid": true, "passed": false,
      "failures": [
        "the vehicle hit the ground at 5.2 m/s in step 'cruise' at 21.40 s",
        "the vehicle hit 'wall' with rotor 2, which stopped in step 'cruise' at 20.50 s",
        "the flight was not completed: step 3, 'cruise' (goto), was not done within 40 s: 0.0 m of 5.0 m high",
        "RMS error of the true position, x_m: 9.1 m; the limit is 0.3 m",
        "fault 'gust' never began: its condition never came true"],
      "failure_times_s": [21.4, 20.5, 50.0, null, null],
      "remarks": [], "warnings": ["yard.sdf:4: <actor> is left out"],
      "incidents": [{"kind": "strike", "time_s": 20.5, "what": "hit 'wall' with rotor 2, which stopped in step 'cruise' at 20.50 s"},
                    {"kind": "crash", "time_s": 21.4, "what": "hit the ground at 5.2 m/s in step 'cruise' at 21.40 s"}],
      "stages": [{"step": "takeoff", "name": "takeoff", "begin_s": 2.0, "end_s": 10.0}, {"step": "goto", "name": "cruise", "begin_s": 10.0, "end_s": 50.0, "finished": false}],
      "faults": [{"name": "compass", "begin_s": 19.0, "end_s": null}, {"name": "gust", "begin_s": null, "end_s": null}],
      "paths": [{"message": "HIL_SENSOR", "sent": 1000, "received": 990, "losses": {"too old in casd's queue": 10}}],
      "changes": [{"time_s": 5.0, "by": "the vehicle itself", "parameter": "CAL", "old": 0, "new": 1, "from_outside": false},
                  {"time_s": 6.0, "by": "casctl", "parameter": "MPC_XY_P", "old": 0.9, "new": 2.5, "from_outside": true}],
      "acts": []}]})");
}

/// It tilts by 0.5 rad (29 deg) from 20 s on; rotors turn at 900 of 1000 rad/s.
Json record_of_crash() {
  return Json::parse(R"({
    "description": "A flight between walls", "controller": "fcu_emulator",
    "vehicles": [{
      "scene": {"name": "hexa600", "mass_kg": 3.5, "rotors": [{"omega_max_rad_s": 1000.0}]},
      "truth": {"t": {"k": 1, "d": [18, 1, 1, 1, 1, 1, 1]}, "roll": {"k": 0.1, "d": [0, 0, 5, 0, 0, 0, 0]}, "pitch": {"k": 0.1, "d": [0, 0, 0, 0, 0, 0, 0]},
                "z": {"k": 1, "d": [1, 4, 0, -5, 0, 0, 0]}, "vx": {"k": 1, "d": [3, 0, 0, 0, 0, 0, 0]}, "vy": {"k": 1, "d": [4, 0, 0, 0, 0, 0, 0]},
                "vz": {"k": 1, "d": [0, 0, 0, 0, 0, 0, 0]}, "rotor1": {"k": 1, "d": [900, 0, 0, 0, 0, 0, 0]}},
      "checks": [
        {"what": "largest error", "validity": false, "value": 0.9, "bound": 1.0, "margin": 0.1, "unit": "m", "digits": 1, "judged": true, "kept": true},
        {"what": "drift", "validity": false, "value": 0.1, "bound": 1.0, "margin": 0.9, "unit": "m", "digits": 1, "judged": true, "kept": true}],
      "log": {"texts": [[3.0, 2, "Arming denied"], [20.7, 4, "Compass inconsistent"], [20.8, 6, "only information"]], "states": []}}]})");
}

std::string told(const Json& summary, const Json& record) {
  return story_text(run_story(summary, record));
}

TEST(RunStory, TellsTheFirstCauseFirstAndItsConsequencesBelow) {
  EXPECT_EQ(told(crashed(), record_of_crash()),
            "FAILED     yard: A flight between walls\n"
            "flown      hexa (hexa600, 3.5 kg) by fcu_emulator, direct, seed 4: 60.0 s on the "
            "virtual clock\n"
            "steps      takeoff 8.0 s, cruise 40.0 s, not done\n"
            "first      the vehicle hit 'wall' with rotor 2, which stopped in step 'cruise' at "
            "20.50 s\n"
            "           at that moment 4.0 m high, 5.0 m/s, tilted by 29 deg, rotors at 90 % of "
            "their highest speed in the 2 s before\n"
            "           1.50 s after fault 'compass' had begun\n"
            "           the vehicle said 'Compass inconsistent' at 20.70 s\n"
            "then       the vehicle hit the ground at 5.2 m/s in step 'cruise' at 21.40 s\n"
            "then       the flight was not completed: step 3, 'cruise' (goto), was not done within "
            "40 s: 0.0 m of 5.0 m high\n"
            "therefore  RMS error of the true position, x_m: 9.1 m; the limit is 0.3 m; fault "
            "'gust' never began: its condition never came true\n"
            "fault      'compass' from 19.00 s on; until 5 s later tilted by at most 29 deg; the "
            "vehicle said 'Compass inconsistent' after 1.70 s\n"
            "fault      'gust' never began\n"
            "lost       10 of 1000 HIL_SENSOR: 10 too old in casd's queue\n"
            "closest    largest error 0.9 of 1 m (10 % left); drift 0.1 of 1 m (90 % left)\n"
            "note       yard.sdf:4: <actor> is left out\n"
            "changed    MPC_XY_P 0.9 -> 2.5 by casctl at 6.00 s\n");
}

TEST(RunStory, WithoutARecordLacksOnlyWhatTheRecordHas) {
  const std::string text = told(crashed(), nullptr);
  EXPECT_NE(text.find("first      the vehicle hit 'wall'"), std::string::npos) << text;
  EXPECT_EQ(text.find("at that moment"), std::string::npos) << text;
  EXPECT_EQ(text.find("closest"), std::string::npos) << text;
}

TEST(RunStory, AMissedLimitWithoutAnIncidentIsItsOwnCause) {
  Json summary = crashed();
  Json& vehicle = summary["vehicles"][0];
  vehicle["failures"] = Json::array({"drift: 2.0 m; the limit is 1 m"});
  vehicle["failure_times_s"] = Json::array({nullptr});
  vehicle["incidents"] = Json::array();
  EXPECT_NE(told(summary, nullptr).find("missed   drift: 2.0 m; the limit is 1 m\n"),
            std::string::npos);
  vehicle["valid"] = summary["valid"] = false;
  EXPECT_NE(told(summary, nullptr).find("why      drift"), std::string::npos);
}

TEST(RunStory, NamesTheWindAndNoModeOfThePlanAmongTheCircumstances) {
  Json summary = crashed();
  summary["vehicles"][0]["faults"] = Json::array();
  Json& stages = summary["vehicles"][0]["stages"];
  stages[0]["end_s"] = stages[1]["begin_s"] = 18.0;
  Json record = record_of_crash();
  record["mean_wind_m_s"] = 22.0;
  record["vehicles"][0]["log"]["states"] = Json::parse(
      R"([[10.0, true, "TAKEOFF"], [15.0, true, "HOLD"], [18.9, true, "GOTO"], [20.4, true, "LAND"]])");
  const std::string text = told(summary, record);
  EXPECT_NE(text.find("           in a wind of 22 m/s on average\n"
                      "           the vehicle changed to LAND at 20.40 s, said 'Compass "
                      "inconsistent' at 20.70 s\n"),
            std::string::npos)
      << text;
}

TEST(RunStory, TellsOnlyWhatFollowedAFaultAsItsConsequence) {
  Json record = record_of_crash();
  record["vehicles"][0]["log"]["texts"].push_back(Json::array({14.0, 4, "Weak signal"}));
  const std::string text = told(crashed(), record);
  EXPECT_EQ(text.find("Weak signal"), std::string::npos) << text;
}

TEST(RunStory, RefusesMembersThatHilsDoesNotWrite) {
  Json summary = crashed();
  summary["vehicles"][0]["stages"] = Json::array({7});
  EXPECT_NE(cas::test::refusal([&] { told(summary, nullptr); }).find("is not as hils writes it"),
            std::string::npos);
}

TEST(RunFolder, SaysInOneSentenceThatAFolderHoldsNoRun) {
  const cas::test::TemporaryFolder folder;
  const auto said = [&](const std::filesystem::path& where) {
    return cas::test::refusal([&] { read_summary(where); });
  };
  EXPECT_EQ(said(folder / "none"), (folder / "none").string() + ": no such folder");
  EXPECT_EQ(said(folder.path()), folder.path().string() +
                                     ": holds no run: it has no summary.json, which `hils run` "
                                     "leaves in its folder of results");
  folder.write("summary.json", "{\"passed\": true}");
  EXPECT_NE(said(folder.path()).find("has no list of vehicles"), std::string::npos);
  folder.write("summary.json", "[1, 2");
  EXPECT_NE(said(folder.path()).find("is not JSON"), std::string::npos);
}

TEST(RunStory, OfAForeignRecordKeepsToTheTerminalAndToFewDigits) {
  Json summary = crashed();
  Json& vehicle = summary["vehicles"][0];
  vehicle["valid"] = vehicle["passed"] = summary["passed"] = true;
  vehicle["failures"] = vehicle["failure_times_s"] = vehicle["incidents"] = Json::array();
  Json record = record_of_crash();
  for (Json& check : record["vehicles"][0]["checks"]) check["digits"] = -1;
  record["description"] = "two\x1b[2J\xC2\x9Bwalls";
  const std::string text = told(summary, record);
  EXPECT_NE(text.find("largest error 1 of 1 m"), std::string::npos) << text;
  EXPECT_NE(text.find("two?[2J?walls"), std::string::npos) << text;
  record["description"] = nullptr;
  EXPECT_EQ(cas::test::refusal([&] { told(summary, record); }),
            "the run's summary or record is not as hils writes it");
}

TEST(RunFolder, RefusesARecordWithoutEnd) {
  const cas::test::TemporaryFolder folder;
  folder.write("run/record.json.gz", gzip("{\"a\":" + std::string(100'000, '[')));
  EXPECT_NE(cas::test::refusal([&] { read_record(folder.path()); }).find("more levels or values"),
            std::string::npos);
}

TEST(RunFolder, ReadsTheRecordThatTheReplayIsMadeOf) {
  const cas::test::TemporaryFolder folder;
  EXPECT_TRUE(read_record(folder.path()).is_null());
  folder.write("run/record.json.gz", gzip("{\"name\": \"hover\"}"));
  EXPECT_EQ(read_record(folder.path()).at("name"), "hover");
  folder.write("run/record.json.gz", gzip("{\"name\": \"hover\"}").substr(0, 12));
  EXPECT_NE(cas::test::refusal([&] { read_record(folder.path()); }).find("cut"), std::string::npos);
}

}  // namespace
