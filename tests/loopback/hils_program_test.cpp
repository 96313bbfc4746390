// SPDX-License-Identifier: BSD-3-Clause
// The command line of hils, up to where a flight would begin.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/file.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <string>
#include <utility>
#include <vector>

#include "base/os/descriptor.hpp"
#include "tests/hils/ulog/ulog_bytes.hpp"
#include "tests/support/ended_with.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr int kExitUsage = 2;

/// Error of hils on these arguments.
std::string refusal_of(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), cas::test::binary_dir() + "/bin/hils");
  ChildProcess hils(arguments);
  EXPECT_EQ(hils.wait_exit(), kExitUsage) << hils.output();
  return hils.output();
}

/// Error of `hils run` on them.
std::string refusal(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), "run");
  return refusal_of(std::move(arguments));
}

TEST(HilsProgram, TakesTheLastOfTwoFoldersForTheResults) {
  const TemporaryFolder folder;
  const std::string text =
      refusal({"no_such_scenario.yaml", "--out", folder / "first", "--out", folder / "second"});
  EXPECT_THAT(text, HasSubstr("no_such_scenario.yaml"));
  EXPECT_THAT(text, Not(HasSubstr("--out")));
}

TEST(HilsProgram, RefusesANegativeSeed) {
  const TemporaryFolder folder;
  const std::string text =
      refusal({"no_such_scenario.yaml", "--out", folder / "out", "--seed", "-1"});
  EXPECT_THAT(text, HasSubstr("'-1' is not a whole number"));
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
  EXPECT_THAT(refused("udp:14550", {"--virtual"}), HasSubstr(sentence));
  EXPECT_THAT(refused("udp:14550", {"--architecture", "direct"}), HasSubstr(sentence));
  EXPECT_THAT(refused("udp:14550", {"--lockstep"}),
              HasSubstr("a ground station has a clock of its own and no place in lockstep"));
  EXPECT_THAT(refused("14550", {}), HasSubstr("--gcs '14550' is none of udp:PORT"));
  EXPECT_THAT(refused("udp:0", {}), HasSubstr("no port from 1 to 65535"));
}

int exit_code(std::vector<std::string> arguments) {
  arguments.insert(arguments.begin(), {cas::test::binary_dir() + "/bin/hils", "run"});
  return ChildProcess(arguments).end().code;
}

TEST(HilsProgram, FliesAScenarioWithOtherValues) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  const std::string setting = "line.packet_loss=0.05";
  std::vector<std::string> arguments{source_dir() + "/config/scenarios/hover.yaml", "--virtual",
                                     "--out", out};
  const std::vector<std::string> plain = arguments;
  arguments.insert(arguments.end(), {"--set", setting, "--set", "limits={}"});
  EXPECT_EQ(exit_code(arguments), 0);
  const auto summary = nlohmann::json::parse(TemporaryFolder::read(out + "/summary.json"));
  EXPECT_GT(summary["vehicles"][0]["rates"]["HIL_SENSOR"]["lost"].get<int>(), 300);
  EXPECT_THAT(summary["remarks"].dump(), HasSubstr(setting)) << summary["remarks"];
  EXPECT_EQ(exit_code(plain), 0);
  EXPECT_FALSE(std::filesystem::exists(out + "/run/scenario")) << "of the run before";
}

TEST(HilsProgram, ChecksAScenarioWithoutAFlight) {
  const std::string hover = source_dir() + "/config/scenarios/hover.yaml";
  EXPECT_EQ(exit_code({hover, "--check"}), 0);
  EXPECT_EQ(exit_code({hover, "--check", "--set", "vehicle.rotor.omega_max_rad_s=1200"}), 0);
  for (const auto& [setting, sentence] :
       {std::pair{"line.packet_loss=2", "line.packet_loss: 2 must lie in [0, 1]"},
        std::pair{"line.packet_los=0.1", "line.packet_los"},
        std::pair{"vehicle.rotor.radius_m=-1", "rotor.radius_m"},
        std::pair{"steps[nowhere].name=x", "no entry of the list is called 'nowhere'"},
        std::pair{"seed", "is not KEY=VALUE"}}) {
    const std::string text = refusal({hover, "--check", "--set", setting});
    EXPECT_THAT(text, HasSubstr(sentence));
    const bool is_setting = std::string(setting).find('=') != std::string::npos;
    const std::string named = hover + " with --set " + setting;
    EXPECT_EQ(text.find(named) != std::string::npos, is_setting) << text;
    EXPECT_THAT(text, Not(HasSubstr("scenario.yaml")));  // the copy
  }
}

TEST(HilsProgram, LeavesTheFolderOfAnotherRunAlone) {
  const TemporaryFolder folder;
  const std::string out = folder / "out";
  std::filesystem::create_directory(out);
  const std::string verdict = folder.write("out/summary.json", "of the other run");
  const base::Descriptor other(::open(out.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  ASSERT_EQ(::flock(other.get(), LOCK_EX | LOCK_NB), 0);
  const std::string text =
      refusal({source_dir() + "/config/scenarios/hover.yaml", "--virtual", "--out", out});
  EXPECT_THAT(text, HasSubstr("another run writes its results there"));
  EXPECT_EQ(TemporaryFolder::read(verdict), "of the other run");
}

TEST(HilsProgram, NamesTheFaultOfTheBenchThatLockstepCannotPlay) {
  const TemporaryFolder folder;
  const std::string text = refusal(
      {source_dir() + "/config/scenarios/unplug.yaml", "--out", folder / "out", "--lockstep"});
  EXPECT_THAT(text, HasSubstr("fault 'plug pulled' of the bench has a clock of its own"));
}

TEST(HilsProgram, RefusesLockstepOnTheVirtualClock) {
  const TemporaryFolder folder;
  const std::string hover = source_dir() + "/config/scenarios/hover.yaml";
  for (const std::vector<std::string>& flags :
       {std::vector<std::string>{"--virtual"}, {"--architecture", "direct"}}) {
    std::vector<std::string> arguments{hover, "--out", folder / "out", "--lockstep"};
    arguments.insert(arguments.end(), flags.begin(), flags.end());
    const std::string text = refusal(arguments);
    EXPECT_THAT(text, HasSubstr("--lockstep: a run on the virtual clock"));
  }
}

class ResultsOf : public testing::TestWithParam<std::vector<std::string>> {};

TEST_P(ResultsOf, CannotBeWhereAFileIs) {
  const TemporaryFolder folder;
  std::ofstream(folder / "a_file") << "x";
  for (const char* const name : {"a_file", "a_file/below"}) {
    const std::string out = folder / name;
    std::vector<std::string> arguments = GetParam();
    arguments[1] = source_dir() + "/config/" + arguments[1];
    arguments.insert(arguments.end(), {"--out", out});
    const std::string text = refusal_of(arguments);
    EXPECT_THAT(text, HasSubstr("hils: --out: " + out + ": cannot be written: "));
  }
}

INSTANTIATE_TEST_SUITE_P(
    Verbs, ResultsOf,
    testing::Values(std::vector<std::string>{"run", "scenarios/hover.yaml", "--virtual"},
                    std::vector<std::string>{"campaign", "campaigns/iris_paper.yaml"},
                    std::vector<std::string>{"sweep", "studies/hover_envelope.yaml"},
                    std::vector<std::string>{"tune", "tunings/iris_paper.yaml"}),
    [](const auto& test) { return test.param.front(); });

TEST(HilsProgram, RefusesWhatMeansNothingToStockFirmware) {
  const TemporaryFolder folder;
  const std::string px4 = source_dir() + "/config/scenarios/px4_sitl.yaml";
  const std::vector<std::vector<std::string>> all{{"--virtual"}, {"--architecture", "loop"}};
  for (const std::vector<std::string>& flag : all) {
    std::vector<std::string> arguments{px4, "--out", folder / "out"};
    arguments.insert(arguments.end(), flag.begin(), flag.end());
    const std::string text = refusal(arguments);
    EXPECT_THAT(text, HasSubstr(flag[0] + ": stock firmware "));
  }
  EXPECT_THAT(refusal({px4, "--fcu", "/dev/ttyACM0", "--out", folder / "out"}),
              HasSubstr("--fcu: this stock firmware is a program without a serial line"));
  const std::string hitl = source_dir() + "/config/scenarios/px4_hitl.yaml";
  EXPECT_THAT(refusal({hitl, "--lockstep", "--out", folder / "out"}),
              HasSubstr("--lockstep: stock firmware on a serial line waits for nobody"));
  EXPECT_THAT(refusal({px4, "--lockstep", "--gcs", "udp:14550", "--out", folder / "out"}),
              HasSubstr("--gcs: a ground station"));
}

/// A file with a short flight. @param more  further keys
std::string short_flight(const TemporaryFolder& folder, const std::string& more) {
  return folder
      .write(
          "own.yaml",
          scenario_text(
              paper_quadrotor() + more + "\n",
              "[arm, takeoff: {altitude_m: 2}, wait_until: {condition: altitude > 1.5, of: truth}, "
              "hold: {duration_s: 1, measure: true}, land, disarm]"))
      .string();
}

/// Flies it on the virtual clock, with `web` as the page.
class Flight {
 public:
  Flight(const std::string& scenario, const std::string& out, const std::string& web)
      : hils_({"/usr/bin/env", "CAS_WEB_PATH=" + web, binary_dir() + "/bin/hils", "run", scenario,
               "--virtual", "--out", out}) {
    EXPECT_EQ(hils_.wait_exit(), 0) << hils_.output();
  }
  bool says(const std::string& words) const {
    return hils_.output().find(words) != std::string::npos;
  }
  std::string output() const { return hils_.output(); }

 private:
  ChildProcess hils_;
};

TEST(HilsProgram, KeepsItsVerdictWhereNoReplayCanBeWritten) {
  const TemporaryFolder folder;
  folder.write("web/index.html", "-");
  folder.write("out/replay.html/in_the_way", "-");
  const Flight flight(short_flight(folder, "architecture: direct"), folder / "out", folder / "web");
  EXPECT_TRUE(flight.says("Results: ")) << flight.output();
  EXPECT_TRUE(flight.says("hils: the replay was not written: ")) << flight.output();
}

/// Without --out each run gets a folder of its own, after the scenario's file.
TEST(HilsProgram, ChoosesTheNextFreeFolder) {
  const TemporaryFolder folder;
  const std::string scenario = short_flight(folder, "architecture: direct");
  const std::string taken = "hils: out/own is taken: the results go to out/own-2\n";
  for (const char* const name : {"out/own", "out/own-2"}) {
    ChildProcess hils({"/usr/bin/env", "-C", folder.path().string(), "CAS_WEB_PATH=/nowhere",
                       binary_dir() + "/bin/hils", "run", scenario});
    EXPECT_EQ(hils.wait_exit(), 0) << hils.output();
    EXPECT_THAT(hils.output(), HasSubstr("Results: " + std::string(name) + "\n"));
    EXPECT_EQ(hils.output().find(taken) != std::string::npos, std::string(name) != "out/own");
    EXPECT_TRUE(std::filesystem::exists(folder / (std::string(name) + "/summary.json")));
  }
}

TEST(HilsProgram, ListsTheShippedScenariosWithTheirControllers) {
  ChildProcess hils({binary_dir() + "/bin/hils", "run", "--list"});
  EXPECT_EQ(hils.wait_exit(), 0) << hils.output();
  const auto has_line = [text = hils.output()](const std::string& pattern) {
    return std::regex_search(text, std::regex("(^|\n)" + pattern + "(\n|$)"));
  };
  for (const auto& entry :
       std::filesystem::directory_iterator(source_dir() + "/config/scenarios")) {
    const std::string name = "scenarios/" + entry.path().filename().string();
    EXPECT_TRUE(has_line(name + " +(emulator|PX4|ArduPilot)  +[^ ].*")) << hils.output();
  }
  EXPECT_TRUE(has_line("scenarios/hover.yaml +emulator +Hover at 2.5 m for 30 s, heading north"));
  EXPECT_TRUE(has_line("scenarios/px4_sitl.yaml +PX4 .*"));
  EXPECT_TRUE(has_line("scenarios/ardupilot.yaml +ArduPilot .*"));
}

TEST(HilsProgram, LeavesNoReplayOfAnEarlierRun) {
  const TemporaryFolder folder;
  folder.write("web/index.html", "-");  // and no replay.html
  const std::filesystem::path old = folder.write("out/replay.html", "of an earlier run");
  const Flight flight(short_flight(folder, "architecture: direct"), folder / "out", folder / "web");
  EXPECT_FALSE(std::filesystem::exists(old));
  EXPECT_TRUE(flight.says("Report:  " + (folder / "out/report.html").string())) << flight.output();
  EXPECT_TRUE(flight.says("Replay:  no replay.html")) << flight.output();
}

TEST(HilsProgram, ARunThatDiesLeavesNoVerdictOfTheOneBefore) {
  const TemporaryFolder folder;
  const std::string topology = folder.write("no_topology.yaml", "schema: 1\nno: key\n").string();
  const std::string scenario =
      folder
          .write("mine.yaml",
                 "schema: 1\nname: mine\ndescription: With a casd that dies\n"
                 "world: " +
                     source_dir() +
                     "/config/worlds/px4_sitl.yaml\n"
                     "topology: " +
                     topology +
                     "\n"
                     "firmware: {command: [/bin/false]}\n"
                     "steps:\n  - arm: {timeout_s: 5}\n  - takeoff: {altitude_m: 2}\n"
                     "  - hold: {duration_s: 1, measure: true}\n  - land: {timeout_s: 5}\n")
          .string();
  std::filesystem::create_directories(folder / "out");
  for (const char* name : {"out/summary.json", "out/junit.xml"}) folder.write(name, "passed");
  ChildProcess hils({binary_dir() + "/bin/hils", "run", scenario, "--out", folder / "out"});
  EXPECT_NE(hils.wait_exit(), 0) << hils.output();
  EXPECT_THAT(hils.output(), HasSubstr("casd ended with exit code 78"));
  EXPECT_FALSE(std::filesystem::exists(folder / "out/summary.json")) << hils.output();
  EXPECT_FALSE(std::filesystem::exists(folder / "out/junit.xml")) << hils.output();
}

/// Exit code and output of `hils replay`, with a page that is a frame for records.
std::pair<int, std::string> replayed(const TemporaryFolder& folder, const std::string& source) {
  folder.write("web/index.html", "-");
  folder.write("web/replay.html", "<body><!--RECORDS--></body>");
  ChildProcess hils({"/usr/bin/env", "CAS_WEB_PATH=" + (folder / "web").string(),
                     binary_dir() + "/bin/hils", "replay", source, "--out", folder / "page.html"});
  const int code = hils.wait_exit().value_or(-1);
  return {code, hils.output()};
}

TEST(HilsProgram, ReplaysAVehiclesOwnLog) {
  const TemporaryFolder folder;
  UlogBytes log;
  log.format("vehicle_land_detected:uint64_t timestamp;bool landed;")
      .subscribe(0, "vehicle_land_detected")
      .data(0, 2'000'000, "\x01");
  const auto [code, output] = replayed(folder, folder.write("own.ulg", log.bytes()));
  EXPECT_EQ(code, 0) << output;
  EXPECT_THAT(output, HasSubstr("Replay: "));
  EXPECT_THAT(TemporaryFolder::read(folder / "page.html"), HasSubstr("class=\"record\""));
  EXPECT_THAT(output, Not(HasSubstr("not whole")));

  log.data(0, 3'000'000, "\x01");
  const std::string cut = folder.write("cut.ulg", log.bytes().substr(0, log.bytes().size() - 1));
  const auto [cut_code, said] = replayed(folder, cut);
  EXPECT_EQ(cut_code, 0) << said;
  EXPECT_THAT(said, HasSubstr(cut + ": the log is not whole: it ends within a message"));
}

TEST(HilsProgram, RefusesARecordOfMoreThanAGibibyte) {
  const TemporaryFolder folder;
  folder.write("out/run/record.json.gz", "");
  std::filesystem::resize_file(folder / "out/run/record.json.gz",
                               (std::uintmax_t{1} << 30U) + 1);  // no byte is written
  const auto [code, output] = replayed(folder, folder / "out");
  EXPECT_EQ(code, 2) << output;
  EXPECT_THAT(output, HasSubstr("record is larger than the 256 MiB that are read"));
}

TEST(HilsProgram, RefusesALogThatIsNone) {
  const TemporaryFolder folder;
  const std::string file = folder.write("bad.ulg", "no log");
  const auto [code, output] = replayed(folder, file);
  EXPECT_EQ(code, kExitUsage);
  EXPECT_EQ(output, "hils: " + file + ": this is no ULog: it does not begin as one\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "page.html"));
}

/// A plugin from a folder of its own flies, and its figures are in the run's folder.
TEST(HilsProgram, FindsPluginsInAFolderOfTheirOwn) {
  const TemporaryFolder folder;
  const std::string scenario =
      short_flight(folder, "architecture: tcas\nplugins:\n  - {plugin: fake_listener}");
  const std::vector<std::string> run{scenario, "--virtual", "--out", folder / "out"};
  EXPECT_THAT(refusal(run), HasSubstr("fake_listener"));
  std::vector<std::string> with_folder = run;
  with_folder.insert(with_folder.end(), {"--plugin-dir", binary_dir() + "/tests/fake_plugins"});
  EXPECT_THAT(refusal({scenario, "--virtual", "--out", folder / "out", "--plugin-dir", "/nowhere"}),
              HasSubstr("--plugin-dir /nowhere: no such folder"));
  with_folder.insert(with_folder.begin(), {binary_dir() + "/bin/hils", "run"});
  EXPECT_THAT(ChildProcess(with_folder).end(), EndedWith(0));
}

}  // namespace
}  // namespace cas::test
