// SPDX-License-Identifier: BSD-3-Clause
#include "hils/campaign/campaign.hpp"

#include <gmock/gmock.h>

#include <set>
#include <string>
#include <vector>

#include "hils/sweep/run_table.hpp"
#include "hils/sweep/study.hpp"
#include "hils/sweep/sweep_folder.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using testing::HasSubstr;

std::string campaign_text(const std::string& failures) {
  return "schema: 1\nname: two\nscenario: " + test::source_dir() +
         "/config/scenarios/hover.yaml\n"
         "phases: {up: phase == takeoff and height > 1, hover: phase == hold}\n"
         "seeds: [3, 4]\n"
         "set:\n  steps[takeoff].altitude_m: 3\n  line: {preset: baud_460800}\n"
         "failures:\n" +
         failures;
}

class CampaignFile : public testing::Test {
 protected:
  Campaign load(const std::string& failures) {
    return Campaign::load(folder_.write("two.yaml", campaign_text(failures)));
  }
  std::string error_of(const std::string& failures) {
    return test::refusal([&] { load(failures); });
  }
  test::TemporaryFolder folder_;
};

constexpr const char* kTwo =
    "  - {failure: gps_lost, with: {for_s: 2}, expect: [no_crash], expect_in: {hover: "
    "[detected]}}\n"
    "  - {failure: casd_reloaded, expect: [stays_up]}\n"
    "  - {name: 'heavy', failure: mass_wrong, with: {factor: 1.5}, phases: [hover], expect: "
    "[stays_up]}\n";

TEST_F(CampaignFile, IsAStudyOfTheScenariosFaults) {
  const Campaign campaign = load(kTwo);
  ASSERT_EQ(cells_of(campaign).size(), 3U) << "casd_reloaded needs casd as a program";
  const auto file = folder_.write("study.yaml", study_of(campaign));
  const Study study = Study::load(file);
  EXPECT_EQ(study.name, "two");
  EXPECT_EQ(study.architecture, Architecture::kDirect);
  EXPECT_EQ(Study::scenario_of(file), campaign.scenario);
  ASSERT_EQ(study.settings.size(), 2U);
  EXPECT_EQ(study.settings[0].second, "3");
  EXPECT_THAT(study.settings[1].second, HasSubstr("baud_460800"));
  const RunTable table = RunTable::of(study, 1);
  ASSERT_EQ(table.rows.size(), 8U) << "each cell with each seed, and no failure with each";
  EXPECT_EQ(table.rows[0].seed, 3U);
  EXPECT_EQ(table.rows[1].seed, 4U);
  EXPECT_EQ(table.rows[0].values[0],
            "[{name: gps_lost in up, when: phase == takeoff and height > 1, for_s: 2, drop: gps}]");
  EXPECT_EQ(table.rows[5].values[0],
            "[{name: heavy in hover, when: phase == hold, mass_factor: 1.5}]");
  EXPECT_EQ(table.rows[7].values[0], "null");
}

TEST_F(CampaignFile, OfABoardIsFlownWithCasdAndWithoutWhatAPortCannotPlay) {
  const auto file =
      folder_.write("two.yaml", campaign_text(std::string(kTwo) +
                                              "  - {failure: line_cut, expect: [no_crash]}\n"
                                              "  - {failure: cpu_starved, expect: [no_crash]}\n"));
  const Campaign campaign = Campaign::load(file, {.controllers = {"bench1"}});
  std::vector<std::string> flown;
  for (const CampaignCell& cell : cells_of(campaign)) {
    flown.push_back(campaign.failures[cell.failure].name);
  }
  EXPECT_EQ(flown, (std::vector<std::string>{"gps_lost", "gps_lost", "casd_reloaded",
                                             "casd_reloaded", "heavy"}));
  EXPECT_EQ(campaign.architecture, Architecture::kTcas);
  EXPECT_NE(study_of(campaign), study_of(Campaign::load(file, {.controllers = {"bench2"}})))
      << "flights of one board are none of another";
}

TEST_F(CampaignFile, LeavesOutFailuresThatAreNotAskedFor) {
  const auto file = folder_.write("two.yaml", campaign_text(kTwo));
  const Campaign campaign = Campaign::load(file, {.only = {"heavy"}});
  ASSERT_EQ(campaign.failures.size(), 1U);
  EXPECT_EQ(campaign.failures[0].name, "heavy");
  EXPECT_EQ(campaign.left_out, (std::vector<std::string>{"gps_lost", "casd_reloaded"}));
  EXPECT_THROW(Campaign::load(file, {.only = {"heavy", "light"}}), base::ConfigError);
}

TEST_F(CampaignFile, NamesWithBracketsStayInTheirQuotes) {
  const Campaign campaign =
      load("  - {failure: gps_lost, name: '[a]', phases: [up], expect: [no_crash]}\n");
  const Study study = Study::load(folder_.write("study.yaml", study_of(campaign)));
  const auto faults = base::ConfigNode::parse("faults: " + study.parameters[0].values[0]);
  EXPECT_EQ(faults.at("faults").items()[0].require<std::string>("name"), "[a] in up");
}

TEST_F(CampaignFile, FilesOfItsSettingsLieBesideIt) {
  const std::string shipped = test::source_dir() + "/config/vehicles/iris_paper";
  folder_.write("vehicles/own.yaml", test::TemporaryFolder::read(shipped + ".yaml"));
  folder_.write("vehicles/iris_paper.urdf", test::TemporaryFolder::read(shipped + ".urdf"));
  std::string text = campaign_text("  - {failure: gps_lost, expect: [no_crash]}\n");
  text.replace(text.find("set:\n"), 5, "set:\n  vehicle: vehicles/own.yaml\n");
  const Campaign campaign = Campaign::load(folder_.write("two.yaml", text));
  const SweepFolder sweep = SweepFolder::plan(
      folder_.write("elsewhere/study.yaml", study_of(campaign)), folder_ / "out", campaign.folder);
  EXPECT_TRUE(std::filesystem::exists(folder_ / "out/vehicle_own.yaml"));
}

TEST_F(CampaignFile, MayBringFailuresOfItsOwn) {
  folder_.write("own.yaml",
                "icing: {part: rotor, meaning: Ice, physics: less thrust, source: a flight,\n"
                "  parameters: {share: {usual: 0.8, least: 0, most: 1}},\n"
                "  effects: [{rotor: {number: 2, thrust_share: $share}}]}\n");
  const std::string failures = "  - {failure: icing, phases: [up], expect: [stays_up]}\n";
  const auto file = folder_.write("two.yaml", "catalogue: own.yaml\n" + campaign_text(failures));
  const RunTable table =
      RunTable::of(Study::load(folder_.write("study.yaml", study_of(Campaign::load(file)))), 1);
  EXPECT_EQ(table.rows[0].values[0],
            "[{name: icing in up, when: phase == takeoff and height > 1, "
            "rotor: {number: 2, thrust_share: 0.8}}]");
  EXPECT_THAT(catalogue_of(file).text(), HasSubstr("icing (rotor): Ice"));
}

TEST_F(CampaignFile, IsRefusedWhereItsScenarioCannotBeFlown) {
  const std::string text = campaign_text("  - {failure: gps_lost, expect: [no_crash]}\n");
  const auto error_with = [&](const std::string& old, const std::string& other) {
    const auto file =
        folder_.write("two.yaml", std::string(text).replace(text.find(old), old.size(), other));
    return test::refusal([&] { Campaign::load(file); });
  };
  EXPECT_THAT(error_with("hover.yaml", "two_vehicles.yaml"),
              HasSubstr("two.yaml:3: scenario: flies several vehicles"));
  EXPECT_THAT(error_with("phase == hold", "phase == holt"),
              HasSubstr("two.yaml:4: phases.hover: the scenario has no step 'holt'; did you mean"));
  EXPECT_THAT(error_with("name: two", "name: \"a\\eb\""), HasSubstr("control character"));
  EXPECT_THAT(error_with("steps[takeoff]", "steps[jump]"), HasSubstr("two.yaml:6: set"));
}

TEST_F(CampaignFile, ExpectsByPhase) {
  const Campaign campaign = load(kTwo);
  EXPECT_EQ(campaign.failures[0].expected.at("up").at(0).kind, Expectation::Kind::kNoCrash);
  EXPECT_EQ(campaign.failures[0].expected.at("hover").at(0).kind, Expectation::Kind::kDetected);
  EXPECT_FALSE(campaign.failures[2].expected.contains("up"));
}

TEST(BadCampaigns, AreRefusedWithAReason) {
  struct BadCampaign {
    const char* failures;
    const char* sentence;
  };
  const BadCampaign rows[] = {
      {"  - {failure: gps_lots, expect: [stays_up]}\n", "did you mean 'gps_lost'"},
      {"  - {failure: gps_lost}\n", "says for phase 'up' neither in 'expect' nor in 'expect_in'"},
      {"  - {failure: gps_lost, phases: [cruise], expect: [lands]}\n",
       "the campaign has no phase 'cruise'"},
      {"  - {failure: gps_lost, with: {m_s: 1}, expect: [lands]}\n", "m_s"},
      {"  - {failure: rotor_weak, with: {share: 2}, expect: [lands]}\n", "share"},
      {"  - {failure: rotor_stopped, with: {number: 5}, expect: [lands]}\n",
       ":10: failures[0].with: there is no rotor 5; vehicle 'iris_paper' has 4"},
      {"  - {failure: rotors_swapped, with: {second: 7}, expect: [lands]}\n",
       "there is no rotor 7"},
      {"  - {failure: gps_lost, expect: [lands]}\n"
       "  - {failure: gps_lost, expect: [lands]}\n",
       "two failures are called 'gps_lost'"},
      {"  - {failure: gps_lost, expect: [lands], expect_in: {cruise: [lands]}}\n", "cruise"},
      {"  - {failure: gps_lost, phases: [up], expect_in: {hover: [lands]}}\n",
       "the failure does not strike in phase 'hover'"},
      {"  - {failure: gps_lost, expect_in: {upp: [lands]}}\n",
       "the campaign has no phase 'upp'; did you mean 'up'?"}};
  for (const auto& row : rows) {
    SCOPED_TRACE(row.failures);
    const test::TemporaryFolder folder;
    const auto file = folder.write("two.yaml", campaign_text(row.failures));
    EXPECT_THAT(test::refusal([&] { Campaign::load(file); }), HasSubstr(row.sentence));
  }
}

TEST(ShippedCampaign, ReadsAndHasAtLeastThirtyFailuresInThreePhases) {
  const Campaign campaign =
      Campaign::load(test::source_dir() + "/config/campaigns/iris_paper.yaml");
  EXPECT_GE(campaign.phases.size(), 3U);
  EXPECT_GE(campaign.seeds.size(), 1U);
  std::size_t everywhere = 0;
  for (const CampaignFailure& failure : campaign.failures) {
    if (failure.expected.size() == campaign.phases.size()) ++everywhere;
  }
  EXPECT_GE(everywhere, 30U);
}

TEST(ShippedCampaign, QuadrotorAndPlaneFlyTheWholeCatalogue) {
  std::set<std::string> left;
  const FailureCatalogue catalogue = FailureCatalogue::shipped();
  for (const Failure& failure : catalogue.failures()) left.insert(failure.name);
  for (const char* name : {"iris_paper", "plane"}) {
    const Campaign campaign =
        Campaign::load(test::source_dir() + "/config/campaigns/" + name + ".yaml");
    for (const CampaignFailure& each : campaign.failures) left.erase(each.failure.name);
  }
  EXPECT_TRUE(left.empty()) << *left.begin() << " is in neither";
}

}  // namespace
}  // namespace cas::hils
