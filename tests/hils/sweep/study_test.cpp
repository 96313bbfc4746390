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

struct RefusalCase {
  const char* name;
  const char* text;
  const char* sentence;
};

class StudyRefusal : public testing::TestWithParam<RefusalCase> {};

TEST_P(StudyRefusal, NamesTheKeyAndWhatIsWrong) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file =
      folder.write("study.yaml", std::string("schema: 1\nscenario: s.yaml\n") + GetParam().text);
  const std::string said = test::refusal([&] { Study::load(file); });
  EXPECT_NE(said.find(GetParam().sentence), std::string::npos) << said;
}

INSTANTIATE_TEST_SUITE_P(
    Each, StudyRefusal,
    testing::Values(
        RefusalCase{"NoSampling", "vary: [{key: a, uniform: [0, 1]}]", "'sampling' says how"},
        RefusalCase{"NoPoints", "sampling: sobol\nvary: [{key: a, uniform: [0, 1]}]", "'points'"},
        RefusalCase{"SamplingOfNothing", "sampling: sobol\nvary: [{key: a, values: [1]}]",
                    "there is none"},
        RefusalCase{"TwoKinds", "vary: [{key: a, values: [1], uniform: [0, 1]}]", "one of values"},
        RefusalCase{"EndsInTheWrongOrder", "vary: [{key: a, uniform: [2, 1]}]", "LEAST < MOST"},
        RefusalCase{"LogOfZero", "vary: [{key: a, log: [0, 1]}]", "above 0"},
        RefusalCase{"ValueTwice", "vary: [{key: a, values: [1, 1]}]", "twice"},
        RefusalCase{"NameTwice", "vary: [{key: a, values: [1]}, {key: b, name: A, values: [1]}]",
                    "is taken"},
        RefusalCase{"NoPath", "vary: [{key: 'a..b', values: [1]}]", "no path of keys"},
        RefusalCase{"UnknownKey", "vary: [{key: a, values: [1], step: 2}]", "unknown key"},
        RefusalCase{"UnknownShare", "vary: [{key: a, values: [1]}]\nlimits: [{share: high}]",
                    "is up, passed or judged"}),
    [](const auto& test) { return test.param.name; });

class ShippedStudy : public testing::TestWithParam<const char*> {};

TEST_P(ShippedStudy, CanBePlanned) {
  const test::TemporaryFolder folder;
  const std::filesystem::path file = test::source_dir() + "/config/studies/" + GetParam() + ".yaml";
  const SweepFolder sweep = SweepFolder::plan(file, folder / "sweep");
  EXPECT_GT(sweep.table.rows.size(), 1U);
  EXPECT_EQ(SweepFolder::plan(file, folder / "sweep").table.csv(), sweep.table.csv());
}

INSTANTIATE_TEST_SUITE_P(All, ShippedStudy, testing::Values("hover_envelope", "gain_grid"),
                         [](const auto& test) { return std::string(test.param); });

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
