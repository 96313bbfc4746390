// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "hils/measure/judgement.hpp"
#include "hils/measure/measurement.hpp"
#include "hils/scenario/scenario.hpp"
#include "hils/virtual/virtual_run.hpp"
#include "tests/hils/report/run_text.hpp"
#include "tests/support/paths.hpp"

namespace cas::hils::test {

inline std::string content(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

/// One flight on the virtual clock in a folder of its own, which goes with it.
class Flight {
 public:
  Flight(const Scenario& scenario, std::uint64_t seed, const std::string& name)
      : folder_(std::filesystem::path(testing::TempDir()) /
                ("closed_loop_" + name + std::to_string(::getpid()))) {
    std::filesystem::create_directories(folder_);
    const RunRequest request{
        .scenario = scenario, .architecture = Architecture::kDirect, .seed = seed, .out = folder_};
    const RunRecord record = run_on_virtual_clock(request).front();
    figures_ = measure(request, record);
    verdict_ = judge(figures_, scenario.limits);
    truth_ = content(record.truth_csv);
    log_ = content(record.flight_tlog);
    simulator_stats_ = content(folder_ / "run" / "hilsim_stats.json");
  }
  ~Flight() { std::filesystem::remove_all(folder_); }
  Flight(const Flight&) = delete;
  Flight& operator=(const Flight&) = delete;

  const Measurement& figures() const { return figures_; }
  const Verdict& verdict() const { return verdict_; }
  std::string text() const { return run_text(figures_, verdict_); }
  const std::string& truth() const { return truth_; }
  /// A column of it.
  std::vector<double> truth(const std::string& name) const {
    std::istringstream lines(truth_);
    std::string line;
    std::string field;
    std::getline(lines, line);
    std::istringstream names(line);
    std::ptrdiff_t column = 0;
    while (std::getline(names, field, ',') && field != name) ++column;
    EXPECT_EQ(field, name);
    std::vector<double> values;
    while (std::getline(lines, line)) {
      std::istringstream fields(line);
      for (std::ptrdiff_t i = 0; i <= column; ++i) std::getline(fields, field, ',');
      values.push_back(std::stod(field));
    }
    return values;
  }
  const std::string& log() const { return log_; }
  const std::string& simulator_stats() const { return simulator_stats_; }

 private:
  std::filesystem::path folder_;
  Measurement figures_;
  Verdict verdict_;
  std::string truth_;
  std::string log_;
  std::string simulator_stats_;
};

inline Scenario hover() {
  return Scenario::load(cas::test::source_dir() + "/config/scenarios/hover.yaml");
}

}  // namespace cas::hils::test
