// SPDX-License-Identifier: BSD-3-Clause
#include "hils/sweep/study.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "base/error.hpp"
#include "hils/sweep/run_table.hpp"
#include "hils/sweep/sweep_folder.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

TEST(StudyRefusal, NamesTheKeyAndWhatIsWrong) {
  struct RefusalCase {
    const char* text;
    const char* sentence;
  };
  const RefusalCase rows[] = {
      {"vary: [{key: a, uniform: [0, 1]}]", "'sampling' says how"},
      {"sampling: sobol\nvary: [{key: a, uniform: [0, 1]}]", "'points'"},
      {"sampling: sobol\nvary: [{key: a, values: [1]}]", "there is none"},
      {"vary: [{key: a, values: [1], uniform: [0, 1]}]", "one of values"},
      {"vary: [{key: a, uniform: [2, 1]}]", "LEAST < MOST"},
      {"vary: [{key: a, log: [0, 1]}]", "above 0"},
      {"vary: [{key: a, values: [1, 1]}]", "twice"},
      {"vary: [{key: a, values: [1]}, {key: b, name: A, values: [1]}]", "is taken"},
      {"vary: [{key: 'a..b', values: [1]}]", "no path of keys"},
      {"vary: [{key: a, values: [1], step: 2}]", "unknown key"},
      {"vary: [{key: a, values: [1]}]\nlimits: [{share: high}]", "is up, passed or judged"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.text);
    const test::TemporaryFolder folder;
    const std::filesystem::path file =
        folder.write("study.yaml", std::string("schema: 1\nscenario: s.yaml\n") + row.text);
    const std::string said = test::refusal([&] { Study::load(file); });
    EXPECT_NE(said.find(row.sentence), std::string::npos) << said;
  }
}

TEST(ShippedStudy, CanBePlanned) {
  for (const char* text : {"hover_envelope", "gain_grid"}) {
    SCOPED_TRACE(text);
    const test::TemporaryFolder folder;
    const std::filesystem::path file = test::source_dir() + "/config/studies/" + text + ".yaml";
    const SweepFolder sweep = SweepFolder::plan(file, folder / "sweep");
    EXPECT_GT(sweep.table.rows.size(), 1U);
    EXPECT_EQ(SweepFolder::plan(file, folder / "sweep").table.csv(), sweep.table.csv());
  }
}

TEST(Study, AFolderKeepsTheStudyItWasPlannedWith) {
  const test::TemporaryFolder folder;
  const auto write = [&folder](const std::string& values) {
    return folder.write("study.yaml",
                        "schema: 1\nscenario: scenarios/hover.yaml\nvary:\n"
                        "  - {key: line.packet_loss, values: [" +
                            values + "]}\n");
  };
  SweepFolder::plan(write("0, 0.1"), folder / "sweep");
  EXPECT_THROW(SweepFolder::plan(write("0, 0.2"), folder / "sweep"), base::ConfigError);
  EXPECT_EQ(SweepFolder::open(folder / "sweep").table.rows[1].values[0], "0.1");
}

TEST(Study, AKeyThatNoScenarioHasIsRefusedWhenItIsPlanned) {
  const test::TemporaryFolder folder;
  const auto study = folder.write("study.yaml",
                                  "schema: 1\nscenario: scenarios/hover.yaml\nvary:\n"
                                  "  - {key: limits.lots, values: [1]}\n");
  const std::string said = test::refusal([&] { SweepFolder::plan(study, folder / "sweep"); });
  EXPECT_NE(said.find("lots"), std::string::npos) << said;
}

}  // namespace
}  // namespace cas::hils
