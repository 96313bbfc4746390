// SPDX-License-Identifier: BSD-3-Clause
// A search as a user starts it: to its end, and after an end in the middle.
#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>

#include "hils/tune/tune_search.hpp"
#include "tests/support/child_process.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/scenario_text.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::test {
namespace {

namespace fs = std::filesystem;

/// For many flights, which take as long as the machine lets them.
constexpr base::Duration kTunePatience = std::chrono::minutes(8);

const std::string kScenario = scenario_text(
    paper_quadrotor(),
    "[arm, takeoff: {altitude_m: 0.6}, trajectory: {name: jump, shape: step, size_m: 1, "
    "duration_s: 4, measure: true}, land, disarm]");

/// The position loop begins far too slow.
constexpr const char* kStudy = R"(
schema: 1
name: hops
scenarios:
  - {name: hop, scenario: hop.yaml}
vary:
  - {name: position_p, key: controller.params.MPC_XY_P, log: [0.2, 2], from: 0.25}
objectives:
  - {name: step, figure: jump_integrated_error_m_s}
  - {name: effort, figure: rotor_activity_rad_s2, weight: 0.1}
guards:
  - {name: overshoot, figure: jump_overshoot_pct, at_most: 60}
search: {method: nsga2, population: 8, generations: 1, seed: 3}
verify: {seeds: [11]}
)";

class Tune : public testing::Test {
 protected:
  Tune() {
    folder_.write("hop.yaml", kScenario);
    study_ = folder_.write("hops.yaml", kStudy);
  }
  std::string tune(const fs::path& out, int code) const {
    ChildProcess program({binary_dir() + "/bin/hils", "tune", study_.string(), "--out",
                          out.string(), "--jobs", "2"});
    EXPECT_EQ(program.wait_exit(kTunePatience), code) << program.output();
    return program.output();
  }
  static std::string read(const fs::path& file) { return TemporaryFolder::read(file); }

  TemporaryFolder folder_;
  fs::path study_;
};

TEST_F(Tune, BeatsASluggishLoopAndGivesTheSameAfterAnEndInTheMiddle) {
  const fs::path whole = folder_ / "whole";
  if (!hils::has_search()) GTEST_SKIP() << "built without pagmo";
  const std::string said = tune(whole, 0);
  EXPECT_NE(said.find("BETTER: hops"), std::string::npos) << said;
  EXPECT_NE(said.find("1 of 1"), std::string::npos)
      << said;  // better with the seed of its own, too
  EXPECT_TRUE(read(whole / "gains.params").starts_with("MPC_XY_P ")) << said;
  EXPECT_NE(read(whole / "gains.yaml").find("params:\n  MPC_XY_P: "), std::string::npos);
  const std::string page = read(whole / "tune.html");
  for (const char* part :
       {"Values", "Verification", "Step responses", "hop, jump", "after/hop/report.html"}) {
    EXPECT_NE(page.find(part), std::string::npos) << part;
  }

  // As if it had been killed after ten flights: only the rest is flown. Row numbers do not matter,
  // and lines that do not name their flight are ignored.
  const fs::path cut = folder_ / "cut";
  fs::create_directories(cut);
  fs::copy(whole / "scenarios", cut / "scenarios", fs::copy_options::recursive);
  fs::copy(whole / "study.yaml", cut / "study.yaml");
  fs::create_directories(cut / "journal");
  std::istringstream lines(read(whole / "journal/flights.jsonl"));
  std::ofstream some(cut / "journal/flights.jsonl");
  std::string line;
  for (int i = 0; i < 10 && std::getline(lines, line); ++i) {
    if (i == 1) some << std::regex_replace(line, std::regex(R"("key":"[^"]*",)"), "") << '\n';
    if (i != 1) some << std::regex_replace(line, std::regex(R"("row":\d+)"), "\"row\":1") << '\n';
  }
  some << R"({"row": 11, "torn)";
  some.close();
  EXPECT_EQ(tune(cut, 0).find("Results: ") != std::string::npos, true);
  for (const char* file : {"candidates.csv", "front.csv", "gains.yaml"}) {
    EXPECT_EQ(read(cut / file), read(whole / file)) << file;
  }

  std::string changed = kStudy;
  changed += "deadline_s: 100\n";
  folder_.write("hops.yaml", changed);
  EXPECT_NE(tune(whole, 2).find("holds another study"), std::string::npos);
}

TEST_F(Tune, AFolderOfSomethingElseIsLeftAlone) {
  if (!hils::has_search()) GTEST_SKIP() << "without pagmo";
  const fs::path own = folder_.write("mine/work/thesis.txt", "mine");
  EXPECT_NE(tune(folder_ / "mine", 2).find("holds no tuning"), std::string::npos);
  EXPECT_TRUE(fs::exists(own));
}

TEST_F(Tune, ABuildWithoutTheSearchSaysHowToGetIt) {
  if (hils::has_search()) GTEST_SKIP() << "built with pagmo";
  EXPECT_NE(tune(folder_ / "out", 2).find("install libpagmo-dev"), std::string::npos);
}

TEST_F(Tune, AKeyThatTheScenarioHasNotIsNamedBeforeAnythingIsFlown) {
  if (!hils::has_search()) GTEST_SKIP() << "built without pagmo";
  std::string text = kStudy;
  const std::string known = "controller.params.MPC_XY_P";
  text.replace(text.find(known), known.size(), "rates.sensor_hertz");
  folder_.write("hops.yaml", text);
  const std::string said = tune(folder_ / "out", 2);
  EXPECT_NE(said.find("scenario 'hop': "), std::string::npos) << said;
  EXPECT_NE(said.find("sensor_hertz"), std::string::npos) << said;
}

TEST_F(Tune, AFigureThatAScenarioHasNotIsNamed) {
  if (!hils::has_search()) GTEST_SKIP() << "built without pagmo";
  std::string text = kStudy;
  const std::string known = "jump_overshoot_pct";
  text.replace(text.find(known), known.size(), "leap_overshoot_pct");
  folder_.write("hops.yaml", text);
  EXPECT_NE(tune(folder_ / "out", 2).find("scenario 'hop' has no figure 'leap_overshoot_pct'"),
            std::string::npos);
}

}  // namespace
}  // namespace cas::test
