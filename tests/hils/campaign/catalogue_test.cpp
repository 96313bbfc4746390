// SPDX-License-Identifier: BSD-3-Clause
#include "hils/campaign/catalogue.hpp"

#include <gmock/gmock.h>

#include <fstream>
#include <sstream>

#include "base/config/config.hpp"
#include "hils/flight/bench_fault.hpp"
#include "tests/support/paths.hpp"
#include "tests/support/refusal.hpp"
#include "tests/support/temporary_folder.hpp"

namespace cas::hils {
namespace {

using testing::HasSubstr;

ScenarioFaults parsed(const std::string& list) {
  const auto line = base::ConfigNode::parse("{preset: baud_921600}", "line");
  return parse_scenario_faults(base::ConfigNode::parse("faults: " + list).at("faults"), line);
}

const FailureCatalogue& shipped() {
  static const FailureCatalogue kCatalogue = FailureCatalogue::shipped();
  return kCatalogue;
}

/// Every failure at the usual and at the outer values of its parameters is a fault that a scenario
/// takes.
TEST(Catalogue, EveryFailureIsAFaultOfAScenario) {
  for (const Failure& failure : shipped().failures()) {
    std::map<std::string, double, std::less<>> least;
    std::map<std::string, double, std::less<>> most{{std::string(kDuration), 2}};
    for (const FailureParameter& parameter : failure.parameters) {
      most[parameter.name] = parameter.most;
    }
    for (const auto& values : {least, most}) {
      const std::string list = faults_of(failure, "title", "phase == hover and height > 2", values);
      SCOPED_TRACE(failure.name + ": " + list);
      EXPECT_EQ(list.find('$'), std::string::npos) << "a parameter without a value";
      const ScenarioFaults faults = parsed(list);
      EXPECT_EQ(faults.bench.size(), failure.of_bench ? failure.effects.size() : 0U);
      EXPECT_EQ(faults.vehicle.size(), failure.of_bench ? 0U : failure.effects.size());
    }
  }
}

TEST(Catalogue, KnowsWhatTheBenchMustHave) {
  EXPECT_EQ(shipped().failures().size(), 76U);
  EXPECT_EQ(shipped().find("gps_spoofeds"), nullptr);
  EXPECT_EQ(shipped().find("gps_spoofed")->needs, FailureNeeds::kNothing);
  EXPECT_FALSE(shipped().find("gps_spoofed")->of_bench);
  EXPECT_EQ(shipped().find("line_cut")->needs, FailureNeeds::kLineModel);
  EXPECT_EQ(shipped().find("casd_reloaded")->needs, FailureNeeds::kPrograms);
  EXPECT_EQ(shipped().find("casd_killed")->needs, FailureNeeds::kNothing);
  EXPECT_TRUE(shipped().find("casd_killed")->of_bench);
  for (const Failure& failure : shipped().failures()) {
    EXPECT_EQ(failure.unrecorded, failure.name == "ground_lost") << failure.name;
  }
}

std::string failure(const std::string& changed, const std::string& by) {
  std::string text =
      "icing:\n  part: rotor\n  meaning: Ice\n  physics: less thrust\n  source: a flight\n"
      "  parameters: {share: {usual: 0.8, least: 0, most: 1}}\n"
      "  effects: [{rotor: {number: 2, thrust_share: $share}}]\n";
  if (const std::size_t at = text.find(changed); at != std::string::npos) {
    text.replace(at, changed.size(), by);
  }
  return text;
}

TEST(Catalogue, IsTheShippedOneWhereverItIsAskedFor) {
  const cas::test::TemporaryFolder folder;
  folder.write("failures.yaml", "of: somebody\n");
  const std::filesystem::path before = std::filesystem::current_path();
  std::filesystem::current_path(folder.path());
  EXPECT_EQ(FailureCatalogue::shipped().failures().size(), 76U);
  std::filesystem::current_path(before);
}

TEST(Catalogue, TakesFailuresOfAnotherFile) {
  const cas::test::TemporaryFolder folder;
  FailureCatalogue catalogue = shipped();
  catalogue.add(folder.write("own.yaml", failure("", "")));
  ASSERT_EQ(catalogue.failures().size(), shipped().failures().size() + 1);
  EXPECT_EQ(faults_of(*catalogue.find("icing"), "ice", "armed", {{"share", 0.5}}),
            "[{name: ice, when: armed, rotor: {number: 2, thrust_share: 0.5}}]");
}

TEST(Catalogue, RefusesAFailureAtItsLine) {
  const cas::test::TemporaryFolder folder;
  const auto refused = [&](const std::string& changed, const std::string& by) {
    FailureCatalogue catalogue = shipped();
    const auto file = folder.write("own.yaml", failure(changed, by));
    return cas::test::refusal([&] { catalogue.add(file); });
  };
  EXPECT_THAT(refused("icing", "gps_lost"), HasSubstr("own.yaml:1: gps_lost: there is a failure"));
  EXPECT_THAT(refused("  meaning: Ice\n", ""), HasSubstr("icing: key 'meaning' is missing"));
  EXPECT_THAT(refused("less thrust", "'a | b'"), HasSubstr("icing.physics: must be one line"));
  EXPECT_THAT(refused("usual: 0.8", "usual: 8"), HasSubstr("icing.parameters.share.usual: "));
  EXPECT_THAT(refused("least: 0", "least: 2"), HasSubstr(".share.most: is less than 'least'"));
  EXPECT_THAT(refused("{share:", "{for_s:"), HasSubstr("for_s: every failure takes this one"));
  EXPECT_THAT(refused("}}]", "}, drop: gps}]"), HasSubstr("icing.effects[0]: must be one effect"));
  EXPECT_THAT(refused("[{rotor: {number: 2, thrust_share: $share}}]",
                      "[{reload: casd}, {starve: {p50_us: $share, p99_us: 9}}]"),
              HasSubstr("icing.effects: needs casd as a program and the virtual clock"));
  EXPECT_THAT(refused("icing", "'i|ng'"), HasSubstr("'i|ng' is made of letters"));
  EXPECT_THAT(refused("[{rotor", "[{unplug: fcu}, {rotor"), HasSubstr("icing.effects: mixes"));
  EXPECT_THAT(refused("$share", "$shar"), HasSubstr("icing.effects: there is no parameter $shar"));
  EXPECT_THAT(refused("$share", "0.5"), HasSubstr("icing.parameters.share: no effect has $share"));
  EXPECT_THAT(refused("thrust_share", "thrust_shre"),
              HasSubstr("icing.effects: with its usual values:1: faults[0].rotor.thrust_shre: "
                        "unknown key; did you mean 'thrust_share'?"));
  EXPECT_THAT(refused("rotor:", "rotr:"), HasSubstr("did you mean 'rotor'?"));
  EXPECT_THAT(refused("source", "sauce: x\n  source"), HasSubstr("icing.sauce: unknown key"));
}

TEST(Catalogue, PutsParametersIntoTheFault) {
  const Failure& noise = *shipped().find("imu_noise");
  EXPECT_EQ(
      faults_of(noise, "shaken", "armed", {{"m_s2", 3}, {"deg_s", 4.5}, {"for_s", 2}}),
      "[{name: shaken, when: armed, for_s: 2, noise: {sensor: imu, specific_force_m_s2: 3}}, "
      "{name: shaken, when: armed, for_s: 2, noise: {sensor: imu, angular_rate_deg_s: 4.5}}]");
  const auto fault = parsed(faults_of(*shipped().find("line_latency"), "late", "armed", {}));
  const auto& line = std::get<LineFault>(fault.bench.at(0).kind).line;
  EXPECT_EQ(line.extra_delay, std::chrono::milliseconds(40));
  EXPECT_EQ(fault.bench.at(0).lasting, std::chrono::seconds(5)) << "the bench's have an end";
}

TEST(Catalogue, IsTheTableOfTheDocumentation) {
  std::ifstream stream(test::source_dir() + "/docs/reference/failures.md");
  std::ostringstream page;
  page << stream.rdbuf();
  std::istringstream table(shipped().markdown());
  for (std::string line; std::getline(table, line);) {
    EXPECT_THAT(page.str(), HasSubstr(line))
        << "docs/reference/failures.md lacks what 'hils campaign --list --markdown' prints:\n"
        << line;
  }
}

}  // namespace
}  // namespace cas::hils
