// SPDX-License-Identifier: BSD-3-Clause
#include "hils/campaign/catalogue.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <sstream>

#include "base/config/config.hpp"
#include "hils/flight/bench_fault.hpp"
#include "tests/support/paths.hpp"

namespace cas::hils {
namespace {

ScenarioFaults parsed(const std::string& list) {
  const auto line = base::ConfigNode::parse("{preset: baud_921600}", "line");
  return parse_scenario_faults(base::ConfigNode::parse("faults: " + list).at("faults"), line);
}

/// Every failure at the usual and at the outer values of its parameters is a fault that a scenario
/// takes.
TEST(Catalogue, EveryFailureIsAFaultOfAScenario) {
  for (const Failure& failure : failure_catalogue()) {
    std::map<std::string, double, std::less<>> least;
    std::map<std::string, double, std::less<>> most{{std::string(kDuration), 2}};
    for (const FailureParameter& parameter : failure.parameters) {
      EXPECT_LE(parameter.least, parameter.usual) << failure.name;
      EXPECT_GE(parameter.most, parameter.usual) << failure.name;
      most[std::string(parameter.name)] = parameter.most;
    }
    for (const auto& values : {least, most}) {
      const std::string list = faults_of(failure, "title", "phase == hover and height > 2", values);
      SCOPED_TRACE(std::string(failure.name) + ": " + list);
      EXPECT_EQ(list.find('$'), std::string::npos) << "a parameter without a value";
      const ScenarioFaults faults = parsed(list);
      EXPECT_EQ(faults.bench.size(), failure.of_bench ? failure.effects.size() : 0U);
      EXPECT_EQ(faults.vehicle.size(), failure.of_bench ? 0U : failure.effects.size());
    }
  }
}

TEST(Catalogue, SaysOfEachWhatItIsWhatItDoesAndWhence) {
  std::set<std::string_view> names;
  for (const Failure& failure : failure_catalogue()) {
    EXPECT_TRUE(names.insert(failure.name).second) << failure.name;
    for (const std::string_view text :
         {failure.part, failure.meaning, failure.physics, failure.source}) {
      EXPECT_FALSE(text.empty()) << failure.name;
      EXPECT_EQ(text.find('|'), std::string_view::npos) << failure.name << " breaks its table";
    }
  }
  EXPECT_GE(names.size(), 40U);
  EXPECT_NE(find_failure("gps_drift"), nullptr);
  EXPECT_EQ(find_failure("gps_drifts"), nullptr);
}

TEST(Catalogue, PutsParametersIntoTheFault) {
  const Failure& noise = *find_failure("imu_noise");
  EXPECT_EQ(
      faults_of(noise, "shaken", "armed", {{"m_s2", 3}, {"deg_s", 4.5}, {"for_s", 2}}),
      "[{name: shaken, when: armed, for_s: 2, noise: {sensor: imu, specific_force_m_s2: 3}}, "
      "{name: shaken, when: armed, for_s: 2, noise: {sensor: imu, angular_rate_deg_s: 4.5}}]");
  const auto fault = parsed(faults_of(*find_failure("line_latency"), "late", "armed", {}));
  const auto& line = std::get<LineFault>(fault.bench.at(0).kind).line;
  EXPECT_EQ(line.extra_delay, std::chrono::milliseconds(40));
  EXPECT_EQ(fault.bench.at(0).lasting, std::chrono::seconds(5)) << "the bench's have an end";
}

TEST(Catalogue, IsTheTableOfTheDocumentation) {
  std::ifstream stream(test::source_dir() + "/docs/campaign.md");
  std::ostringstream page;
  page << stream.rdbuf();
  std::istringstream table(catalogue_markdown());
  for (std::string line; std::getline(table, line);) {
    EXPECT_NE(page.str().find(line), std::string::npos)
        << "docs/campaign.md lacks what 'hils campaign --list --markdown' prints:\n"
        << line;
  }
}

}  // namespace
}  // namespace cas::hils
